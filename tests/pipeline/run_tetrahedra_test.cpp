// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/tissue/run_tetrahedra.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "pipeline/tissue/fill_body.h"
#include "pipeline/tissue/fixed_regions.h"
#include "spheretree/builder/build_settings.h"
#include "support/scratch_folder.h"
#include "support/shapes.h"
#include "tissue/tetrahedra.h"

namespace spheretree::pipeline {
namespace {

using Eigen::Vector3d;

/// During its lifetime, a shell script replaces the child process.
class StandIn {
 public:
  explicit StandIn(const std::string& script) {
    const std::filesystem::path path = folder_.path() / "child";
    std::ofstream(path) << "#!/bin/sh\n" << script << "\n";
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    before_ = std::getenv("SPHERETREE_TETRAHEDRA");
    ::setenv("SPHERETREE_TETRAHEDRA", path.c_str(), 1);
  }
  ~StandIn() { ::setenv("SPHERETREE_TETRAHEDRA", before_.c_str(), 1); }

 private:
  test::ScratchFolder folder_;
  std::string before_;
};

std::string faultOf(const std::string& script, double seconds = 20) {
  const StandIn child(script);
  builder::Progress progress;
  try {
    runTetrahedra(test::boxMesh(Vector3d::Zero(), Vector3d::Ones()), 0, seconds, progress);
  } catch (const builder::BuildError& error) {
    return error.what();
  }
  return "";
}

TEST(RunTetrahedra, FillsABoxWithoutChangingItsSurface) {
  const TriangleMesh box = test::quartered(test::boxMesh(Vector3d(1, 2, 3), Vector3d(5, 5, 8)));
  builder::Progress progress;
  const builder::Tetrahedra solid = builder::solidOf(runTetrahedra(box, 0.2, 60, progress), box);
  EXPECT_NEAR(builder::volumeOf(solid), 60, 1e-9);
  EXPECT_EQ(builder::boundaryOf(solid).triangles.size(), box.triangles.size());
  EXPECT_GT(solid.corners.size(), runTetrahedra(box, 0, 60, progress).corners.size()) << "smaller ones are more";
}

TEST(RunTetrahedra, ABadSurfaceEndsInAReason) {
  TriangleMesh crossing = test::boxMesh(Vector3d::Zero(), Vector3d::Ones());
  const TriangleMesh other = test::boxMesh(Vector3d::Constant(0.5), Vector3d::Constant(1.5));
  for (const Triangle& t : other.triangles) crossing.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  crossing.positions.insert(crossing.positions.end(), other.positions.begin(), other.positions.end());
  builder::Progress progress;
  EXPECT_THROW(runTetrahedra(crossing, 0, 60, progress), builder::BuildError);
}

TEST(RunTetrahedra, AnyFailureOfTheChildBecomesAnError) {
  EXPECT_NE(faultOf("sleep 60", 0.2).find("did not end"), std::string::npos);
  EXPECT_NE(faultOf("kill -SEGV $$").find("crashed"), std::string::npos);
  EXPECT_NE(faultOf("echo 'child: it hurts.' >&2; exit 4").find("it hurts"), std::string::npos);
  EXPECT_NE(faultOf("echo '4000000000 1' > $2"), "");
  EXPECT_NE(faultOf("echo '4 1 0 0 0 nonsense' > $2"), "");
  EXPECT_NE(faultOf(": > $2"), "");
}

TEST(RunTetrahedra, CancellingEndsTheChild) {
  const StandIn child("sleep 60");
  builder::Progress progress;
  progress.cancel();
  EXPECT_THROW(runTetrahedra(test::boxMesh(Vector3d::Zero(), Vector3d::Ones()), 0, 60, progress), builder::Cancelled);
}

TEST(FillBody, MeetsTheNumberOnFineAndCoarseMeshes) {
  builder::Progress progress;
  for (const int rounds : {2, 5}) {  // 128 and 8192 triangles
    const TriangleMesh ball = test::sphereMesh(20, rounds);
    const FilledBody body = fillBody(ball, 2000, 60, progress);
    EXPECT_GE(body.tetrahedra.corners.size(), 2000 / 1.6) << rounds;
    EXPECT_LE(body.tetrahedra.corners.size(), 2000 * 1.6) << rounds;
    EXPECT_NO_THROW(builder::solidOf(body.tetrahedra, body.boundary));
    EXPECT_LT(body.boundary_distance_mm, 1.5);
  }
}

TEST(FixedRegions, ContainThePointsOfTheirText) {
  FixedRegions regions;
  EXPECT_TRUE(addFixedRegion("sphere:1,2,3,0.5", regions));
  EXPECT_TRUE(addFixedRegion("box:-1,-1,-1,0,0,0", regions));
  EXPECT_TRUE(regions.holds({1, 2, 3.49}));
  EXPECT_FALSE(regions.holds({1, 2, 3.51}));
  EXPECT_TRUE(regions.holds({-0.5, -1, 0}));
  for (const char* text :
       {"", "box:1,2,3", "sphere:1,2,3,0", "sphere:1,2,3,4,5", "box:0,0,0,-1,1,1", "sphere:1,2,3,nan", "ball:1,2,3,4", "box:0,0,0,1,1,1x"})
    EXPECT_FALSE(addFixedRegion(text, regions)) << text;
}

}  // namespace
}  // namespace spheretree::pipeline
