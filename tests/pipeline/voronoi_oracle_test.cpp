// SPDX-License-Identifier: GPL-3.0-or-later
// The balls of the medial axis (CGAL) against TetGen's Voronoi vertices of the same points. TetGen is a program of its
// own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "geometry/surface_samples.h"
#include "medial/adaptive_medial_axis.h"
#include "support/random.h"
#include "support/scratch_folder.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> verticesByTetGen(const std::vector<Vector3d>& points) {
  const test::ScratchFolder folder;
  const std::filesystem::path in = folder.path() / "points", out = folder.path() / "vertices";
  std::FILE* file = std::fopen(in.c_str(), "w");
  for (const Vector3d& p : points) std::fprintf(file, "%.17g %.17g %.17g\n", p.x(), p.y(), p.z());
  std::fclose(file);
  const std::string command = std::string("'") + VORONOI_ORACLE + "' '" + in.string() + "' >'" + out.string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  std::vector<Vector3d> vertices;
  std::ifstream text(out);
  for (double x, y, z; text >> x >> y >> z;) vertices.emplace_back(x, y, z);
  return vertices;
}

double nearest(const Vector3d& p, const std::vector<Vector3d>& all) {
  double smallest = 1e300;
  for (const Vector3d& q : all) smallest = std::min(smallest, (p - q).squaredNorm());
  return std::sqrt(smallest);
}

TEST(VoronoiOracle, TheSameVerticesAsTetGen) {
  constexpr double kSame = 1e-7;  // for solids about 10 wide: the rounding error of nearly flat tetrahedra
  for (const TriangleMesh& mesh : {test::torusMesh(5, 2, 48, 24), test::sphereMesh(5, 3), test::boxMesh({0, 0, 0}, {7, 5, 3})}) {
    const DistanceField field(mesh);
    // Moved slightly off the surface, because cospherical points would leave the choice of tetrahedra open.
    test::Random random(17);
    std::vector<Vector3d> points;
    for (const SurfaceSample& s : sampleSurface(mesh, {1500, 0.5235987756, 1})) points.push_back(s.point + 0.02 * random.direction());
    const std::vector<Vector3d> theirs = verticesByTetGen(points);
    ASSERT_GT(theirs.size(), points.size());
    std::vector<Vector3d> ours;
    AdaptiveMedialAxis axis(field, points);
    Progress progress;
    const AdaptiveMedialAxis::Target as_it_is[] = {{.overhang = kInfinity}};
    // Balls at vertices come first; then those of sites without one.
    const std::vector<FittedBall> balls = axis.refine([](const Vector3d&) { return 0u; }, as_it_is, progress)[0];
    for (std::size_t i = 0; i < std::min(balls.size(), axis.ballCount()); ++i) ours.push_back(balls[i].centre);
    ASSERT_GT(ours.size(), points.size());
    for (const Vector3d& c : ours) EXPECT_LT(nearest(c, theirs), kSame);
    std::size_t inside = 0;
    for (const Vector3d& c : theirs) {
      if (!(field.signedDistance(c) < -1e-4)) continue;
      ++inside;
      EXPECT_LT(nearest(c, ours), kSame);
    }
    EXPECT_GT(inside, points.size());
  }
}

}  // namespace
}  // namespace spheretree::builder
