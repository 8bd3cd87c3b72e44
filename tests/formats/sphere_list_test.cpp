// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/sphere_list.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/sample_trees.h"

namespace spheretree::formats {
namespace {

/// A root of two leaves, away from its origin.
SphereTree pairOfLeaves() {
  SphereTree tree = test::threeLevelTree();
  tree.origin_mm = {100, 0, -10};
  return tree;
}

TEST(SphereList, HoldsALevelInTheUnitAskedFor) {
  const SphereTree tree = pairOfLeaves();
  for (const auto& [name, unit] : {std::pair{"mm", 1.0}, {"cm", 10.0}, {"m", 1000.0}}) {
    const SphereListSettings settings{.level = 2, .unit = name, .kind = SphereKind::Cover, .name = "link"};
    const nlohmann::json list = nlohmann::json::parse(sphereListJson(tree, settings)).at("link");
    EXPECT_EQ(nlohmann::json::parse(sphereListJson(tree, settings)).at("unit"), name);
    const std::string csv = sphereListCsv(tree, settings), columns = csv.substr(0, csv.find('\n'));
    EXPECT_EQ(columns, std::string("x_") + name + ",y_" + name + ",z_" + name + ",radius_" + name);
    EXPECT_TRUE(sphereListYaml(tree, settings).starts_with(std::string("# unit: ") + name + "\n"));
    const std::vector<std::uint32_t> nodes = levelSet(tree, 2);
    ASSERT_EQ(list.size(), nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Sphere& s = tree.cover[nodes[i]];
      EXPECT_DOUBLE_EQ(list[i].at("origin")[0].get<double>() * unit, 100 + double{s.x});
      EXPECT_DOUBLE_EQ(list[i].at("origin")[2].get<double>() * unit, -10 + double{s.z});
      EXPECT_DOUBLE_EQ(list[i].at("radius").get<double>() * unit, s.radius);
    }
  }
}

TEST(SphereList, IsTheSameInEveryForm) {
  const SphereTree tree = pairOfLeaves();
  const SphereListSettings settings{.level = 0, .unit = "mm", .kind = SphereKind::Bound, .name = "a \"name\""};
  const nlohmann::json sphere = nlohmann::json::parse(sphereListJson(tree, settings)).at("a \"name\"")[0];
  const std::string x = sphere.at("origin")[0].dump(), r = sphere.at("radius").dump();
  const std::string csv = sphereListCsv(tree, settings), yaml = sphereListYaml(tree, settings);
  const auto number = [](const std::string& text, const std::string& after) {
    return std::stod(text.substr(text.find(after) + after.size()));
  };
  EXPECT_EQ(number(csv, "radius_mm\n"), std::stod(x));
  EXPECT_EQ(number(yaml, "center: ["), std::stod(x));
  EXPECT_EQ(number(yaml, "radius: "), std::stod(r));
}

}  // namespace
}  // namespace spheretree::formats
