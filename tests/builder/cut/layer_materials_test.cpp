// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/layer_materials.h"

#include <gtest/gtest.h>

#include <array>

#include "geometry/distance_field.h"
#include "spheretree/builder/mesh_checks.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

TEST(LayerMaterials, HaveTheirVolumes) {
  // The third sticks out of the second, the fourth out of the object.
  const std::array layers{test::boxMesh({0, 0, 0}, {4, 4, 4}), test::boxMesh({1, 1, 1}, {3, 3, 3}),
                          test::boxMesh({1.5, 1.5, 2}, {2.5, 2.5, 3.5}), test::boxMesh({-1, 0.1, 0.1}, {0.5, 0.3, 0.4})};
  Progress progress;
  const std::vector<LayerMaterial> found = layerMaterials(layers, progress);
  const std::array truth{64 - 8 - 0.5 - 0.03, 8 - 1.0, 1.5, 0.03};
  ASSERT_EQ(found.size(), truth.size());
  for (std::size_t k = 0; k < truth.size(); ++k) {
    EXPECT_LE(found[k].volume.low, truth[k]) << k;
    EXPECT_GE(found[k].volume.high, truth[k]) << k;
    EXPECT_LE(found[k].volume.width(), 1e-8) << k;
    EXPECT_TRUE(checkMesh(found[k].mesh, 10, progress).clean()) << k;
  }
}

TEST(LayerMaterials, OfALayerWithinAnotherIsNothing) {
  const std::array layers{test::boxMesh({0, 0, 0}, {4, 4, 4}), test::boxMesh({1, 1, 1}, {2, 2, 2}),
                          test::boxMesh({0.5, 0.5, 0.5}, {3, 3, 3})};
  Progress progress;
  const std::vector<LayerMaterial> found = layerMaterials(layers, progress);
  EXPECT_TRUE(found[1].mesh.triangles.empty());
  EXPECT_EQ(found[1].volume.high, 0);
}

}  // namespace
}  // namespace spheretree::builder
