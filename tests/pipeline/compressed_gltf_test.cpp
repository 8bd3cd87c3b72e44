// SPDX-License-Identifier: GPL-3.0-or-later
// A compressed GLB gives the tree of the uncompressed one, byte for byte.
#include <gtest/gtest.h>

#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/formats/gltf.h"
#include "support/compressed_gltf.h"
#include "support/random.h"
#include "support/shapes.h"
#include "support/texts.h"

namespace spheretree {
namespace {

SphereTree treeOf(const std::string& glb) {
  builder::BuildSettings settings;
  settings.max_leaves = 24;
  settings.quality = builder::Quality::Quick;
  builder::Progress progress;
  return builder::buildSphereTree(formats::readGltf(test::charsOf(glb), "test.glb").mesh, settings, progress).tree;
}

TEST(CompressedGltf, GivesTheTreeOfTheUncompressedFile) {
  TriangleMesh bumpy = test::torusMesh(20, 6, 36, 16);
  test::Random random(9);
  for (Eigen::Vector3d& p : bumpy.positions) p *= random.between(0.98, 1.02);
  const SphereTree plain = treeOf(test::plainGlb(bumpy));
  const std::vector<std::byte> expected = encodeSphereTree(plain);
  EXPECT_EQ(encodeSphereTree(treeOf(test::meshoptGlb(bumpy, "TRIANGLES"))), expected);
  EXPECT_EQ(encodeSphereTree(treeOf(test::meshoptGlb(bumpy, "INDICES"))), expected);
  EXPECT_EQ(encodeSphereTree(treeOf(test::dracoGlb(bumpy, draco::MESH_SEQUENTIAL_ENCODING))), expected);
  // The edgebreaker stores the triangles in another order. The tree contains a hash of its mesh, which depends on the
  // order; everything else is equal.
  SphereTree reordered = treeOf(test::dracoGlb(bumpy, draco::MESH_EDGEBREAKER_ENCODING));
  EXPECT_NE(reordered.provenance.mesh_hash, plain.provenance.mesh_hash);
  reordered.provenance.mesh_hash = plain.provenance.mesh_hash;
  EXPECT_EQ(encodeSphereTree(reordered), expected);
  bumpy.positions[0] *= 1.01;
  EXPECT_NE(encodeSphereTree(treeOf(test::meshoptGlb(bumpy))), expected);
}

}  // namespace
}  // namespace spheretree
