// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/provenance.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <vector>

namespace spheretree::builder {
namespace {

TriangleMesh smallTetrahedron() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

TEST(MeshHash, ChangesWithEveryNumberOfTheMesh) {
  const TriangleMesh mesh = smallTetrahedron();
  std::set<Hash128> hashes{meshHash(mesh)};
  std::size_t expected = 1;
  for (std::size_t i = 0; i < 4; ++i)
    for (int axis = 0; axis < 3; ++axis, ++expected) {
      TriangleMesh changed = mesh;
      changed.positions[i][axis] += 1e-15;
      hashes.insert(meshHash(changed));
    }
  for (std::size_t t = 0; t < 4; ++t)
    for (std::size_t k = 0; k < 3; ++k, ++expected) {
      TriangleMesh changed = mesh;
      changed.triangles[t][k] ^= 4;
      hashes.insert(meshHash(changed));
    }
  TriangleMesh shorter = mesh;
  shorter.triangles.pop_back();
  hashes.insert(meshHash(shorter)), ++expected;
  hashes.insert(meshHash({})), ++expected;
  EXPECT_EQ(hashes.size(), expected);
}

TEST(MeshHash, LeavesPartsOut) {
  TriangleMesh mesh = smallTetrahedron();
  mesh.part = {0, 0, 0, 0};
  mesh.part_names = {"tooth"};
  EXPECT_EQ(meshHash(mesh), meshHash(smallTetrahedron()));
}

TEST(SettingsHash, ChangesWithWhatChangesTheTreeAndWithNothingElse) {
  const std::vector<std::function<void(BuildSettings&)>> changes{
      [](BuildSettings& s) { s.builder = BuilderKind::Merge; },
      [](BuildSettings& s) { s.combine = {BuilderKind::Merge}; },
      [](BuildSettings& s) {
        s.combine = {BuilderKind::Merge, BuilderKind::Burst};
      },
      [](BuildSettings& s) {
        s.combine = {BuilderKind::Burst, BuilderKind::Merge};
      },
      [](BuildSettings& s) { s.levels = 5; },
      [](BuildSettings& s) { s.branching = 7; },
      [](BuildSettings& s) { s.quality = Quality::Best; },
      [](BuildSettings& s) { s.tolerance_mm = 0.1; },
      [](BuildSettings& s) { s.tolerance_mm = 0.1 + 4e-18; },  // the same double
      [](BuildSettings& s) { s.tolerance_mm = 0.1 + 1e-17; },  // the next one
      [](BuildSettings& s) { s.seed = 2; },
      [](BuildSettings& s) { s.max_leaves = 100; },
      [](BuildSettings& s) { s.skin = false; },
      [](BuildSettings& s) { s.skin_tolerance_mm = 0.1; },
      [](BuildSettings& s) { s.crease_angle_deg = 40; },
  };
  std::set<Hash128> hashes{settingsHash({})};
  for (const auto& change : changes) {
    BuildSettings settings;
    change(settings);
    hashes.insert(settingsHash(settings));
  }
  EXPECT_EQ(hashes.size(), changes.size());  // including the default, without the pair that is one double
  BuildSettings threads;
  threads.threads = 7;
  EXPECT_EQ(settingsHash(threads), settingsHash({}));
}

TEST(SettingsText, IsFixed) {
  EXPECT_EQ(settingsText({}),
            "builder=cover\ncombine=\nlevels=4\nbranching=8\nquality=standard\ntolerance_mm=0\nseed=1\n"
            "skin_tolerance_mm=0\ncrease_angle_deg=50\n");
}

}  // namespace
}  // namespace spheretree::builder
