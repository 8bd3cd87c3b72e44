// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/inner_sheet.h"

#include <tbb/parallel_for.h>

#include "certify/certify_cover.h"
#include "medial/shrinking_balls.h"

namespace spheretree::builder {

using Eigen::Vector3d;

TriangleMesh innerSheet(const TriangleMesh& mesh, const DistanceField& field, double share, double stand_off, double spacing) {
  TriangleMesh sheet = subdivided(mesh, spacing);
  tbb::parallel_for(std::size_t{0}, sheet.positions.size(), [&](std::size_t i) {
    Vector3d& p = sheet.positions[i];
    const NearestPoint here = field.nearest(p);
    const Vector3d inward = -field.pseudonormal(here);
    const Ball below = shrinkingBall(field, here.point, -inward, stand_off);
    const double depth = below.radius > 0 ? (below.centre - here.point).norm() : 0;
    p = here.point + 2 * share * depth * inward;
  });
  return sheet;
}

}  // namespace spheretree::builder
