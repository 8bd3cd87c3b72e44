// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/builder_names.h"

#include <gtest/gtest.h>

#include "spheretree/formats/scene_file.h"

namespace spheretree::pipeline {
namespace {

formats::TreeSettings settingsOf(const std::string& key, const std::string& name) {
  return formats::parseScene(R"({"schema": "spheretree.scene/1", "defaults": {")" + key + R"(": ")" + name +
                                 R"("}, "tool": {"name": "tool", "mesh": "tool.obj"}, "objects": [{"name": "a", "mesh": "a.obj"}]})",
                             "scene")
      .defaults;
}

// The reader of scenes has its own lists, since formats do not know the builders.
TEST(BuilderNames, CanStandInAScene) {
  for (const std::string& name : namesOf(kBuilders)) EXPECT_EQ(settingsOf("builder", name).builder, name);
  for (const std::string& name : namesOf(kQualities)) EXPECT_EQ(settingsOf("quality", name).quality, name);
}

TEST(BuilderNames, GiveTheirValueBack) {
  for (const BuilderKind kind : kBuilders) EXPECT_EQ(byName(kBuilders, std::string(builder::name(kind))), kind);
  for (const Quality quality : kQualities) EXPECT_EQ(byName(kQualities, std::string(builder::name(quality))), quality);
  EXPECT_THROW(byName(kQualities, "better"), std::logic_error);
}

}  // namespace
}  // namespace spheretree::pipeline
