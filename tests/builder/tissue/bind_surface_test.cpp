// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/bind_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "support/random.h"
#include "support/shapes.h"
#include "support/tetrahedra.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

Tissue tissueOf(const TriangleMesh& mesh, const Tetrahedra& solid, const Vector3d& origin) {
  Progress progress;
  Tissue tissue;
  tissue.material = {15, 0.45, 1040};
  for (const Vector3d& p : solid.nodes) tissue.nodes.push_back({p.x() - origin.x(), p.y() - origin.y(), p.z() - origin.z()});
  tissue.tetrahedra = solid.corners;
  tissue.surface = bindSurface(mesh, solid, origin, progress);
  EXPECT_EQ(findFault(tissue), "");
  return tissue;
}

TEST(BindSurface, VerticesFollowEveryAffineMap) {  // those inside, on and a little outside of the tetrahedra
  const Tetrahedra solid = test::boxTetrahedra({4, 3, 5}, {4, 2, 3});
  test::Random random(5);
  TriangleMesh mesh = test::quartered(test::boxMesh(Vector3d::Zero(), Vector3d(4, 3, 5)));
  for (int i = 0; i < 200; ++i) mesh.positions.push_back(random.inBox(Vector3d::Constant(-0.1), Vector3d(4.1, 3.1, 5.1)));
  const Vector3d origin(10, 20, 30);
  const Tissue tissue = tissueOf(mesh, solid, origin);
  Eigen::Matrix3d gradient;
  for (int k = 0; k < 3; ++k) gradient.col(k) = random.inCube(0.5);
  std::vector<Vector3d> displacements, moved(mesh.positions.size());
  for (const Vector3d& p : solid.nodes) displacements.push_back(gradient * p + Vector3d(1, 2, 3));
  moveSurface(tissue, displacements, moved);
  for (std::size_t v = 0; v < moved.size(); ++v) {
    const Vector3d wanted = mesh.positions[v] - origin + gradient * mesh.positions[v] + Vector3d(1, 2, 3);
    EXPECT_LT((moved[v] - wanted).norm(), 3e-6) << "vertex " << v;  // weights are floats
  }
}

TEST(BindSurface, AtRestVerticesAreWhereTheyWere) {
  const Tetrahedra solid = test::boxTetrahedra({4, 3, 5}, {4, 2, 3});
  const TriangleMesh mesh = test::quartered(test::boxMesh(Vector3d::Zero(), Vector3d(4, 3, 5)));
  const Tissue tissue = tissueOf(mesh, solid, Vector3d::Zero());
  std::vector<Vector3d> moved(mesh.positions.size());
  moveSurface(tissue, std::vector<Vector3d>(solid.nodes.size(), Vector3d::Zero()), moved);
  EXPECT_EQ(moved, mesh.positions);
}

TEST(BindSurface, AVertexBelongsToATetrahedronThatHoldsIt) {
  const Tetrahedra solid = test::boxTetrahedra({4, 3, 5}, {4, 2, 3});
  test::Random random(6);
  TriangleMesh mesh;
  for (int i = 0; i < 500; ++i) mesh.positions.push_back(random.inBox(Vector3d::Zero(), Vector3d(4, 3, 5)));
  Progress progress;
  for (const TissueVertex& v : bindSurface(mesh, solid, Vector3d::Zero(), progress)) {
    const float last = 1 - v.weight[0] - v.weight[1] - v.weight[2];
    EXPECT_GE(std::min({v.weight[0], v.weight[1], v.weight[2], last}), -1e-6f);
  }
}

}  // namespace
}  // namespace spheretree::builder
