// SPDX-License-Identifier: Apache-2.0
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

std::vector<std::byte> treeBytes(const std::string& glb) {
  builder::BuildSettings settings;
  settings.most_leaves = 24;
  settings.quality = builder::Quality::Quick;
  builder::Progress progress;
  return encodeSphereTree(builder::buildSphereTree(formats::readGltf(test::charsOf(glb), "test.glb").mesh, settings, progress).tree);
}

TEST(CompressedGltf, GivesTheTreeOfTheUncompressedFile) {
  TriangleMesh bumpy = test::torusMesh(20, 6, 36, 16);
  test::Random random(9);
  for (Eigen::Vector3d& p : bumpy.positions) p *= random.between(0.98, 1.02);
  const std::vector<std::byte> plain = treeBytes(test::plainGlb(bumpy));
  EXPECT_EQ(treeBytes(test::meshoptGlb(bumpy, "TRIANGLES")), plain);
  EXPECT_EQ(treeBytes(test::meshoptGlb(bumpy, "INDICES")), plain);
  EXPECT_EQ(treeBytes(test::dracoGlb(bumpy, draco::MESH_SEQUENTIAL_ENCODING)), plain);
  EXPECT_EQ(treeBytes(test::dracoGlb(bumpy, draco::MESH_EDGEBREAKER_ENCODING)), plain);
  bumpy.positions[0] *= 1.01;
  EXPECT_NE(treeBytes(test::meshoptGlb(bumpy)), plain);
}

}  // namespace
}  // namespace spheretree
