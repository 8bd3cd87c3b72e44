// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/surface_with_sheets.h"

#include <tbb/parallel_for.h>

#include <vector>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kBeside = 1e-5;  // as a share of the diagonal: a sheet this near to the solid needs no search of its own

}  // namespace

SurfaceWithSheets surfaceWithSheets(const TriangleMesh& solid, const TriangleMesh& cover_too) {
  SurfaceWithSheets out{{}, DistanceField(solid)};
  const double smallest = kBeside * out.field.diagonal();
  std::vector<char> reaches_out(cover_too.triangles.size(), 0);
  tbb::parallel_for(std::size_t{0}, reaches_out.size(), [&](std::size_t t) {
    const Vector3d a = cover_too.corner(t, 0), b = cover_too.corner(t, 1), c = cover_too.corner(t, 2);
    for (const Vector3d& p : {a, b, c, Vector3d((a + b + c) / 3)}) reaches_out[t] |= out.field.signedDistance(p) > smallest;
  });
  for (std::size_t t = 0; t < reaches_out.size(); ++t)
    if (reaches_out[t]) out.sheets.triangles.push_back(cover_too.triangles[t]);
  if (out.sheets.triangles.empty()) return out;
  out.sheets.positions = cover_too.positions;
  out.field = DistanceField(solid, {}, out.sheets);
  return out;
}

}  // namespace spheretree::builder
