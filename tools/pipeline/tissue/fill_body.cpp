// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/tissue/fill_body.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "geometry/distance_field.h"
#include "mesh/simplify_mesh.h"
#include "pipeline/tissue/run_tetrahedra.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/mesh_checks.h"

namespace spheretree::pipeline {
namespace {

constexpr int kMaxRuns = 6;                 // largest number of runs of TetGen
constexpr double kNear = 1.5;               // a number of tetrahedra within this factor of the requested one is accepted
constexpr double kTetrahedraATriangle = 3;  // approximately what TetGen makes for each surface triangle of a compact body

/// About `triangles`, or more if fewer would cross or fold.
TriangleMesh simplified(const TriangleMesh& mesh, std::size_t triangles, builder::Progress& progress) {
  for (; triangles < mesh.triangles.size(); triangles *= 2) {
    TriangleMesh coarse = builder::simplifyMesh(mesh, triangles, progress);
    if (builder::checkMesh(coarse).clean()) return coarse;
    progress.check();
  }
  return mesh;
}

double ratioOf(std::size_t found, int wanted) { return static_cast<double>(found) / wanted; }

}  // namespace

FilledBody fillBody(const TriangleMesh& mesh, int tetrahedra, double seconds, builder::Progress& progress) {
  progress.stage("tetrahedra");
  const builder::DistanceField field(mesh);
  double triangles = tetrahedra / kTetrahedraATriangle;
  double volume = 3 * field.volume() / tetrahedra;  // largest volume; the mean of TetGen is about a third of it
  std::optional<FilledBody> best;
  std::string reason;
  std::size_t simplified_for = 0;
  TriangleMesh boundary;
  for (int run = 0; run < kMaxRuns; ++run) {
    const auto wanted = static_cast<std::size_t>(triangles);
    if (wanted != simplified_for) boundary = simplified(mesh, wanted, progress), simplified_for = wanted;
    double ratio = 0;
    try {
      FilledBody body{boundary, runTetrahedra(boundary, volume, seconds, progress), 0};
      ratio = ratioOf(body.tetrahedra.corners.size(), tetrahedra);
      if (!best || std::abs(std::log(ratio)) < std::abs(std::log(ratioOf(best->tetrahedra.corners.size(), tetrahedra))))
        best = std::move(body);
    } catch (const builder::BuildError& error) {  // another surface may succeed
      reason = error.what();
      if (boundary.triangles.size() == mesh.triangles.size()) break;
      triangles *= 2;
      continue;
    }
    if (ratio <= kNear && ratio >= 1 / kNear) break;
    if (ratio < 1) {
      volume *= std::max(ratio, 0.2);
    } else if (boundary.triangles.size() > wanted * 2) {
      break;  // the surface cannot be simplified further
    } else {
      triangles /= ratio;
      volume *= ratio;
    }
  }
  if (!best) throw builder::BuildError(reason);
  if (best->boundary.triangles.size() != mesh.triangles.size())
    best->boundary_distance_mm = builder::distanceBound(mesh, builder::DistanceField(best->boundary), progress);
  return *best;
}

}  // namespace spheretree::pipeline
