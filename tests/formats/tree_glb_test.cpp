// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/tree_glb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "support/sample_hulls.h"
#include "support/sample_skins.h"

namespace spheretree::formats {
namespace {

std::uint32_t wordAt(const std::vector<std::byte>& bytes, std::size_t offset) {
  std::uint32_t word;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

/// The two chunks of a binary glTF, by its specification.
struct Glb {
  explicit Glb(const std::vector<std::byte>& bytes) {
    EXPECT_EQ(std::memcmp(bytes.data(), "glTF", 4), 0);
    EXPECT_EQ(wordAt(bytes, 4), 2u);
    EXPECT_EQ(wordAt(bytes, 8), bytes.size());
    const std::size_t text_size = wordAt(bytes, 12);
    EXPECT_EQ(std::memcmp(bytes.data() + 16, "JSON", 4), 0);
    EXPECT_EQ(text_size % 4, 0u);
    document = nlohmann::json::parse(reinterpret_cast<const char*>(bytes.data()) + 20,
                                     reinterpret_cast<const char*>(bytes.data()) + 20 + text_size);
    EXPECT_EQ(std::memcmp(bytes.data() + 24 + text_size, "BIN\0", 4), 0);
    EXPECT_EQ(wordAt(bytes, 20 + text_size), bytes.size() - 28 - text_size);
    binary.assign(bytes.begin() + static_cast<std::ptrdiff_t>(28 + text_size), bytes.end());
  }
  template <class T>
  std::vector<T> read(std::size_t accessor) const {
    const nlohmann::json& a = document["accessors"][accessor];
    const nlohmann::json& view = document["bufferViews"][a["bufferView"].get<std::size_t>()];
    std::vector<T> values(a["count"].get<std::size_t>());
    EXPECT_EQ(values.size() * sizeof(T), view["byteLength"].get<std::size_t>());
    EXPECT_EQ(view.value("byteOffset", std::size_t{0}) % 4, 0u);
    std::memcpy(values.data(), binary.data() + view.value("byteOffset", std::size_t{0}), values.size() * sizeof(T));
    return values;
  }
  nlohmann::json document;
  std::vector<std::byte> binary;
};

const nlohmann::json& nodeNamed(const nlohmann::json& document, const std::string& name) {
  for (const nlohmann::json& node : document["nodes"])
    if (node["name"] == name) return node;
  throw std::runtime_error("no node " + name);
}

/// Closed and facing outward, every point and normal at distance 1 m: every directed edge has its opposite, and the
/// volume is close to that of the ball.
void expectUnitBall(const Glb& glb, const nlohmann::json& mesh) {
  const nlohmann::json& primitive = mesh["primitives"][0];
  const std::size_t positions_at = primitive["attributes"]["POSITION"];
  const auto positions = glb.read<std::array<float, 3>>(positions_at),
             normals = glb.read<std::array<float, 3>>(primitive["attributes"]["NORMAL"]);
  const auto corners = glb.read<std::uint32_t>(primitive["indices"]);
  ASSERT_EQ(positions.size(), normals.size());
  std::array<float, 3> low = positions[0], high = positions[0];
  for (std::size_t i = 0; i < positions.size(); ++i) {
    double length2 = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(positions[i][axis], normals[i][axis], 1e-6);
      length2 += double{normals[i][axis]} * normals[i][axis];
      low[axis] = std::min(low[axis], positions[i][axis]), high[axis] = std::max(high[axis], positions[i][axis]);
    }
    EXPECT_NEAR(length2, 1, 1e-6);
  }
  EXPECT_EQ(glb.document["accessors"][positions_at]["min"].get<decltype(low)>(), low);
  EXPECT_EQ(glb.document["accessors"][positions_at]["max"].get<decltype(low)>(), high);
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  double volume = 0;
  for (std::size_t t = 0; t < corners.size(); t += 3) {
    std::array<Eigen::Vector3d, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_LT(corners[t + k], positions.size());
      EXPECT_TRUE(edges.emplace(corners[t + k], corners[t + (k + 1) % 3]).second);
      const std::array<float, 3>& at = positions[corners[t + k]];
      p[k] = Eigen::Vector3d(double{at[0]}, double{at[1]}, double{at[2]});
    }
    volume += p[0].dot(p[1].cross(p[2])) / 6;
  }
  for (const auto& [a, b] : edges) EXPECT_TRUE(edges.contains({b, a}));
  EXPECT_NEAR(volume / (4 * M_PI / 3), 0.99, 0.01);
}

TEST(TreeGlb, ShowsTheSpheresOfEachLevelSetInMetres) {
  const SphereTree tree = test::threeLevelTree();
  for (const SphereKind kind : {SphereKind::Cover, SphereKind::Bound}) {
    const Glb glb(encodeGlb(tree, kind));
    const nlohmann::json &all = glb.document["nodes"], &scenes = glb.document["scenes"];
    ASSERT_EQ(glb.document["meshes"].size(), 3u) << "one icosphere for each level";
    for (std::size_t level = 0; level < 3; ++level) {
      EXPECT_EQ(glb.document["meshes"][level]["name"], "level_" + std::to_string(level));
      expectUnitBall(glb, glb.document["meshes"][level]);
      const std::vector<std::uint32_t> nodes = levelSet(tree, static_cast<int>(level));
      const nlohmann::json& children = nodeNamed(glb.document, "level_" + std::to_string(level))["children"];
      ASSERT_EQ(children.size(), nodes.size());
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        const nlohmann::json& node = all[children[i].get<std::size_t>()];
        const Sphere& s = sphereOf(tree, nodes[i], kind);
        EXPECT_EQ(node["name"], "sphere_" + std::to_string(nodes[i]));
        EXPECT_EQ(node["mesh"], level);
        const std::array<double, 3> centre{s.x, s.y, s.z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          EXPECT_NEAR(node.contains("translation") ? node["translation"][axis].get<double>() : 0, centre[axis] * 0.001, 1e-12);
          EXPECT_NEAR(node["scale"][axis].get<double>(), double{s.radius} * 0.001, 1e-12);
        }
      }
    }
    // One scene for each level, the leaves first: the root's sphere would hide all others.
    ASSERT_EQ(scenes.size(), 3u);
    const std::array<int, 3> level_of_scene{2, 0, 1};
    for (std::size_t scene = 0; scene < 3; ++scene) {
      const nlohmann::json& root = all[scenes[scene]["nodes"][0].get<std::size_t>()];
      ASSERT_EQ(root["children"].size(), 1u);
      EXPECT_EQ(all[root["children"][0].get<std::size_t>()]["name"], "level_" + std::to_string(level_of_scene[scene]));
      for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(root["translation"][axis].get<double>(), tree.origin_mm[axis] * 0.001);
    }
    const Glb one(encodeGlb(tree, kind, 1));
    ASSERT_EQ(one.document["meshes"].size(), 1u);
    EXPECT_EQ(one.document["meshes"][0]["name"], "level_1");
  }
}

TEST(TreeGlb, ShowsThePatchesOfTheSkinBesideTheLevels) {
  SphereTree tree = test::threeLevelTree();
  const std::size_t bare = Glb(encodeGlb(tree, SphereKind::Cover)).document["nodes"].size();
  tree.skin = test::roundSkin(3, 5);  // 512 triangles about the origin
  const Glb glb(encodeGlb(tree, SphereKind::Cover));
  ASSERT_EQ(glb.document["nodes"].size(), bare + 1);
  const nlohmann::json& node = nodeNamed(glb.document, "skin");
  const nlohmann::json& shown = nodeNamed(glb.document, "sphere_tree")["children"];
  ASSERT_EQ(shown.size(), 2u) << "beside the leaves";
  EXPECT_EQ(glb.document["nodes"][shown[0].get<std::size_t>()]["name"], "level_2");
  EXPECT_EQ(glb.document["nodes"][shown[1].get<std::size_t>()]["name"], "skin");
  const nlohmann::json& mesh = glb.document["meshes"][node["mesh"].get<std::size_t>()];
  EXPECT_EQ(mesh["name"], "skin");
  const nlohmann::json& primitive = mesh["primitives"][0];
  EXPECT_EQ(glb.document["materials"][primitive["material"].get<std::size_t>()]["name"], "skin");
  const auto positions = glb.read<std::array<float, 3>>(primitive["attributes"]["POSITION"]),
             normals = glb.read<std::array<float, 3>>(primitive["attributes"]["NORMAL"]);
  const auto corners = glb.read<std::uint32_t>(primitive["indices"]);
  ASSERT_EQ(positions.size(), 15 * tree.skin.triangles.size());
  ASSERT_EQ(normals.size(), positions.size());
  ASSERT_EQ(corners.size(), 3 * 16 * tree.skin.triangles.size());

  const auto vector = [](const std::array<float, 3>& p) { return Eigen::Vector3d(double{p[0]}, double{p[1]}, double{p[2]}); };
  for (std::size_t i = 0; i < positions.size(); ++i) {  // the patches follow the sphere to 0.0005 mm, the flat triangles only to 0.03
    EXPECT_NEAR(vector(positions[i]).norm(), 0.005, 1e-6);
    EXPECT_NEAR(vector(normals[i]).norm(), 1, 1e-6);
    EXPECT_GT(vector(normals[i]).dot(vector(positions[i]).normalized()), std::cos(0.002));
  }
  // Closed and facing outward: equal places are one point, every directed edge has its opposite, and the volume is that
  // of the sphere.
  const auto place = [&](std::uint32_t corner) {
    const Eigen::Vector3d p = vector(positions[corner]) * 1e8;  // 10 nm: far above the rounding of a float here, far below an edge
    return std::array<long, 3>{std::lround(p.x()), std::lround(p.y()), std::lround(p.z())};
  };
  std::set<std::pair<std::array<long, 3>, std::array<long, 3>>> edges;
  double volume = 0;
  for (std::size_t t = 0; t < corners.size(); t += 3) {
    for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(edges.emplace(place(corners[t + k]), place(corners[t + (k + 1) % 3])).second);
    volume += vector(positions[corners[t]]).dot(vector(positions[corners[t + 1]]).cross(vector(positions[corners[t + 2]]))) / 6;
  }
  for (const auto& [a, b] : edges) EXPECT_TRUE(edges.contains({b, a}));
  EXPECT_NEAR(volume / (4 * M_PI / 3 * std::pow(0.005, 3)), 0.999, 0.001);
}

TEST(TreeGlb, ShowsSkinsOfAnyNormals) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Glb glb(encodeGlb(test::withSkin(test::treeOf({0}), test::randomSkin(seed)), SphereKind::Cover));
    const nlohmann::json& primitive = glb.document["meshes"][1]["primitives"][0];
    for (const auto& n : glb.read<std::array<float, 3>>(primitive["attributes"]["NORMAL"]))
      EXPECT_NEAR(std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), 1, 1e-6);
  }
}

TEST(TreeGlb, StaysModestForAFullTree) {
  std::vector<std::uint8_t> counts(4681, 8);
  counts.resize(37449, 0);
  SphereTree tree;
  tree.cover.assign(counts.size(), Sphere{0, 0, 0, 1});
  tree.child_count = counts;
  ASSERT_TRUE(linkNodes(tree));
  const std::vector<std::byte> bytes = encodeGlb(tree, SphereKind::Cover);
  EXPECT_LT(bytes.size(), 10'000'000u);
}

// Points of balls, of the sides of cones and of the faces of slabs are on the boundary of the part. In the direction
// of the normal the part ends there: no ball of it reaches farther than the plane through the point.
TEST(TreeGlb, ShowsHullsInASceneOfTheirOwn) {
  SphereTree tree = test::toolOf(test::rodHulls({0, 0, 0}, 1, {4, 0, 1}, 0.5, 1));
  tree.hulls = test::hullsOf({test::ballAt({0, 0, 0}, 1), test::ballAt({4, 0, 1}, 0.5), test::ballAt({1, 3, 0}, 0.75)}, {{0, 1, 2}}, 1);
  const Glb glb(encodeGlb(tree, SphereKind::Cover));
  const auto& scenes = glb.document["scenes"];
  ASSERT_TRUE(std::any_of(scenes.begin(), scenes.end(), [](const nlohmann::json& scene) { return scene["name"] == "scene_of_hulls"; }));
  const nlohmann::json& mesh = glb.document["meshes"][nodeNamed(glb.document, "hulls")["mesh"].get<std::size_t>()];
  const nlohmann::json& primitive = mesh["primitives"][0];
  const auto positions = glb.read<std::array<float, 3>>(primitive["attributes"]["POSITION"]),
             normals = glb.read<std::array<float, 3>>(primitive["attributes"]["NORMAL"]);
  ASSERT_EQ(positions.size(), 6u) << "two faces";
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const auto vector = [](const std::array<float, 3>& v) { return Eigen::Vector3d(double{v[0]}, double{v[1]}, double{v[2]}); };
    const Eigen::Vector3d p = 1000 * vector(positions[i]), n = vector(normals[i]);
    EXPECT_NEAR(n.norm(), 1, 1e-6);
    for (const Sphere& ball : tree.hulls.balls)
      EXPECT_NEAR(n.dot(p - centreOf(ball)), double{ball.radius}, 1e-5) << "all balls touch a face";
  }
  EXPECT_FALSE(Glb(encodeGlb(tree, SphereKind::Cover, 0)).document.dump().find("scene_of_hulls") != std::string::npos);
}

TEST(TreeGlb, TheSideOfAConeTouchesBothBalls) {
  const SphereTree tree = test::toolOf(test::rodHulls({0, 0, 0}, 1, {4, 0, 1}, 0.5, 1));
  const Glb glb(encodeGlb(tree, SphereKind::Cover));
  const nlohmann::json& primitive = glb.document["meshes"][nodeNamed(glb.document, "hulls")["mesh"].get<std::size_t>()]["primitives"][0];
  const auto positions = glb.read<std::array<float, 3>>(primitive["attributes"]["POSITION"]),
             normals = glb.read<std::array<float, 3>>(primitive["attributes"]["NORMAL"]);
  ASSERT_GT(positions.size(), 64u);
  // The side of the cone comes last: 32 lines with two points each, where a plane touches both balls.
  for (std::size_t i = positions.size() - 64; i < positions.size(); ++i) {
    const auto vector = [](const std::array<float, 3>& v) { return Eigen::Vector3d(double{v[0]}, double{v[1]}, double{v[2]}); };
    for (const Sphere& ball : tree.hulls.balls)
      EXPECT_NEAR(vector(normals[i]).dot(1000 * vector(positions[i]) - centreOf(ball)), double{ball.radius}, 1e-5);
  }
}

}  // namespace
}  // namespace spheretree::formats
