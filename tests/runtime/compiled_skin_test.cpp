// SPDX-License-Identifier: Apache-2.0
// Subject: compiled_skin.h
#include "scene/compiled_skin.h"

#include <gtest/gtest.h>

#include "support/sample_skins.h"

namespace spheretree::runtime {
namespace {

// Four triangles are compiled at once, and as one alone to the last bit. The number of triangles is not always a
// multiple of four.
TEST(CompiledSkin, HoldsEachPatchToTheLastBit) {
  bool some_curved = false, some_flat = false;
  for (const Skin& skin :
       {test::roundSkin(4), test::gridSkin(3), test::gridSkin(45), test::boxSkin({1, 2, 3}), test::ellipsoidSkin({3, 2, 1}, 3),
        test::cuspedSkin(3), test::ridgeSkin(), test::randomSkin(1), test::randomSkin(2)}) {
    const CompiledSkin compiled = compileSkin(skin, Eigen::Vector3d::Zero());
    ASSERT_EQ(compiled.patch.size(), skin.triangles.size());
    for (std::size_t slot = 0; slot < compiled.tree.item.size(); ++slot) {
      const std::uint32_t t = compiled.tree.item[slot];
      if (t == kNoItem) continue;
      const PaddedPatch patch = padded(patchOf(skin, t));
      const Sphere sphere = enclose(patch);
      const Block& block = compiled.tree.bound[slot / 8];
      EXPECT_EQ((std::array{block.x[slot % 8], block.y[slot % 8], block.z[slot % 8], block.r[slot % 8]}),
                (std::array{sphere.x, sphere.y, sphere.z, sphere.radius}));
      const std::uint32_t flags = compiled.patch[t].flags;
      EXPECT_EQ(flags >> kLeanShift << kLeanShift, leanBits(leanOf(patch)));
      EXPECT_EQ((flags & kCurved) == 0, isFlat(patch));
      some_curved = some_curved || (flags & kCurved) != 0, some_flat = some_flat || (flags & kCurved) == 0;
    }
  }
  EXPECT_TRUE(some_curved && some_flat);
}

}  // namespace
}  // namespace spheretree::runtime
