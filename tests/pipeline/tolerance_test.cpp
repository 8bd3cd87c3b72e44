// SPDX-License-Identifier: GPL-3.0-or-later
// `--tolerance`: the bound is kept, with hardly more nodes than the best tree that a full search over all shapes of tree finds, and no leaf
// is there for nothing. SPHERETREE_LONG=1: all builders and more meshes (about 20 minutes of one core in place of half a minute).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "probe.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/certify_cover.h"
#include "spheretree/formats/mesh_file.h"
#include "support/shapes.h"

namespace spheretree {
namespace {

using builder::BuilderKind;
using builder::BuildResult;
using builder::BuildSettings;

bool isLong() { return std::getenv("SPHERETREE_LONG") != nullptr; }

std::vector<BuilderKind> someBuilders() {
  if (!isLong()) return {BuilderKind::Cover, BuilderKind::Grid};
  return {BuilderKind::Cover, BuilderKind::Merge,   BuilderKind::Burst,  BuilderKind::Expand,  BuilderKind::Spawn,
          BuilderKind::Grid,  BuilderKind::Hubbard, BuilderKind::Octree, BuilderKind::Combined};
}

struct NamedMesh {
  std::string name;
  TriangleMesh mesh;
};
std::vector<NamedMesh> someMeshes() {
  std::vector<NamedMesh> meshes{{"box", test::boxMesh({0, 0, 0}, {3, 2, 1})}};
  if (!isLong()) return meshes;
  meshes.push_back({"torus", test::torusMesh(5, 1, 24, 10)});
  meshes.push_back({"probe", samples::makeProbe()});
  const std::filesystem::path folder = std::filesystem::path(SPHERETREE_SHARED_DIR) / "meshes/toolkit";
  for (const char* name : {"tooth", "plate"})
    if (std::filesystem::exists(folder / (std::string(name) + ".obj")))
      meshes.push_back({name, formats::readMesh(folder / (std::string(name) + ".obj")).mesh});
  return meshes;
}

BuildResult build(const TriangleMesh& mesh, BuilderKind kind, int levels, int branching, double tolerance) {
  BuildSettings settings;
  settings.builder = kind;
  settings.quality = builder::Quality::Quick;
  settings.levels = levels;
  settings.branching = branching;
  settings.tolerance_mm = tolerance;
  builder::Progress progress;
  return builder::buildSphereTree(mesh, settings, progress);
}

// The cells of an octree with fewer children are others, not fewer: a tree of them is no answer to a tolerance for one with eight.
int leastBranching(BuilderKind kind) { return kind == BuilderKind::Octree ? 8 : 2; }

double boundOf(const BuildResult& result) { return result.statistics.levels.back().overhang_bound_mm; }

struct Shape {
  std::size_t nodes;
  double bound;
};

TEST(Tolerance, KeptWithHardlyMoreNodesThanAFullSearchNeeds) {
  for (const NamedMesh& named : someMeshes())
    for (const BuilderKind kind : someBuilders()) {
      SCOPED_TRACE(named.name + ", " + std::string(name(kind)));
      std::vector<Shape> shapes;  // every tree of up to 4 levels
      for (int levels = isLong() ? 2 : 3; levels <= 4; ++levels)
        for (int branching = leastBranching(kind); branching <= 8; branching += isLong() ? 1 : 3) {
          const BuildResult result = build(named.mesh, kind, levels, branching, 0);
          shapes.push_back({result.tree.nodeCount(), boundOf(result)});
        }
      double least = std::numeric_limits<double>::infinity(), most = 0;
      for (const Shape& s : shapes) least = std::min(least, s.bound), most = std::max(most, s.bound);
      for (const double share : isLong() ? std::vector<double>{0.1, 0.3, 0.6} : std::vector<double>{0.4}) {
        const double tolerance = std::exp(std::log(1.2 * least) + share * (std::log(most) - std::log(1.2 * least)));
        std::size_t fewest = std::numeric_limits<std::size_t>::max();
        for (const Shape& s : shapes)
          if (s.bound <= tolerance) fewest = std::min(fewest, s.nodes);
        const BuildResult result = build(named.mesh, kind, 4, 8, tolerance);
        EXPECT_TRUE(result.statistics.tolerance_met) << tolerance;
        EXPECT_LE(boundOf(result), tolerance);
        // One node more where 1.2 times a handful is less than one.
        EXPECT_LE(static_cast<double>(result.tree.nodeCount()),
                  std::max(1.2 * static_cast<double>(fewest), static_cast<double>(fewest) + 1))
            << "tolerance " << tolerance;
        std::printf("%-6s %-9s tolerance %8.5f mm: %4zu nodes, full search %4zu\n", named.name.c_str(), std::string(name(kind)).c_str(),
                    tolerance, result.tree.nodeCount(), fewest);
      }
    }
}

TEST(Tolerance, NoLeafAddsNothing) {
  for (const NamedMesh& named : someMeshes())
    for (const BuilderKind kind : someBuilders()) {
      SCOPED_TRACE(named.name + ", " + std::string(name(kind)));
      const BuildResult result = build(named.mesh, kind, 3, 8, 0);
      const SphereTree& tree = result.tree;
      const Eigen::Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
      const std::vector<std::uint32_t> leaves = levelSet(tree, tree.levelCount() - 1);
      builder::Progress progress;
      std::size_t needless = 0;
      for (const std::uint32_t left_out : leaves) {
        if (leaves.size() == 1) break;
        std::vector<builder::Ball> others;
        for (const std::uint32_t leaf : leaves)
          if (leaf != left_out) {
            const Sphere& s = tree.cover[leaf];
            others.push_back({Eigen::Vector3d(s.x, s.y, s.z) + origin, s.radius});
          }
        needless += builder::certifyCover(named.mesh, others, origin, 1e-4 * boundOf(result), progress).largest_growth == 0;
      }
      EXPECT_EQ(needless, 0u);
    }
}

}  // namespace
}  // namespace spheretree
