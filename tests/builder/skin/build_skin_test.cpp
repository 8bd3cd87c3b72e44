// SPDX-License-Identifier: GPL-3.0-or-later
#include "skin/build_skin.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "geometry/distance_field.h"
#include "measure/evaluate_skin.h"
#include "spheretree/core/mesh_edit.h"
#include "support/random.h"
#include "support/smooth_shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

using test::kDegree;

Skin skinOf(const TriangleMesh& mesh, double tolerance, const Vector3d& origin = Vector3d::Zero(), const TriangleMesh& sheets = {}) {
  Progress silent;
  const SkinSettings settings{tolerance, {}, 50 * kDegree};
  return buildSkin(mesh, sheets, DistanceField(mesh, {}, sheets), origin, settings, silent);
}

std::vector<TriangleMesh> sampleMeshes() {
  TriangleMesh rough = test::sphereMesh(4, 3);
  test::Random random(2);
  for (Vector3d& p : rough.positions) p += random.inCube(0.1);
  return {test::boxMesh({0, 0, 0}, {1, 2, 3}), test::sphereMesh(5, 3),
          test::torusMesh(6, 2, 32, 16),       test::cylinderMesh(3, 8, 32, 4),
          test::filletedSlab(20, 10, 8, 2, 6), rough};
}

std::size_t flatCount(const Skin& skin) {
  std::size_t flat = 0;
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) flat += allowanceOf(patchOf(skin, t), 1) == 0;
  return flat;
}

std::size_t sharpCount(const Skin& skin) {
  return static_cast<std::size_t>(std::count_if(skin.edges.begin(), skin.edges.end(), [](const SkinEdge& e) { return e.is_sharp != 0; }));
}

/// A row of the table of docs/algorithms/skin/skin.md.
test::SkinErrors printed(const char* what, std::size_t triangles, const test::SkinErrors& errors) {
  std::printf("skin of a %s; %zu; %.6f mm flat, %.6f mm, %.4f degrees\n", what, triangles, errors.flat, errors.position,
              errors.normal / kDegree);
  return errors;
}

TEST(BuildSkin, IsSound) {
  for (const TriangleMesh& mesh : sampleMeshes()) {
    const Skin skin = skinOf(mesh, 0.2);
    EXPECT_EQ(findFault(skin), "");
    EXPECT_EQ(skin.triangles.size(), mesh.triangles.size());
    EXPECT_FLOAT_EQ(skin.crease_angle, static_cast<float>(50 * kDegree));
  }
}

/// The largest angle between the normals of the two patches at random places on edges that are not sharp [rad].
double largestTurn(const Skin& skin, int places) {
  std::map<std::pair<SkinPosition, SkinPosition>, std::vector<std::pair<std::size_t, std::size_t>>> sides;  // triangle, side
  for (std::size_t t = 0; t < skin.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const SkinTriangle& corners = skin.triangles[t];
      if (skin.edges[corners.edge[k]].is_sharp != 0) continue;
      const SkinPosition &a = skin.vertices[corners.vertex[k]].position, &b = skin.vertices[corners.vertex[(k + 1) % 3]].position;
      sides[std::minmax(a, b)].emplace_back(t, k);
    }
  test::Random random(5);
  double largest = 0;
  for (const auto& [edge, both] : sides) {
    EXPECT_EQ(both.size(), 2u);
    for (int i = 0; i < places; ++i) {
      const double share = random.unit();
      std::array<Vector3d, 2> normal;
      for (std::size_t j = 0; j < 2; ++j) {
        const auto [t, k] = both[j];
        const bool is_forward = skin.vertices[skin.triangles[t].vertex[k]].position == edge.first;
        Vector3d w = Vector3d::Zero();
        w[static_cast<Eigen::Index>(k)] = is_forward ? share : 1 - share;
        w[static_cast<Eigen::Index>((k + 1) % 3)] = is_forward ? 1 - share : share;
        normal[j] = test::pointOf(patchOf(skin, t), w).normal;
      }
      largest = std::max(largest, std::atan2(normal[0].cross(normal[1]).norm(), normal[0].dot(normal[1])));
    }
  }
  return largest;
}

TEST(BuildSkin, TurnsNowhereAtASmoothEdge) {
  TriangleMesh rough = test::sphereMesh(4, 4);
  test::Random random(2);
  for (Vector3d& p : rough.positions) p += random.inCube(0.2);  // folds, and triangles that lean far from those around them
  EXPECT_LT(largestTurn(skinOf(rough, 0.2), 20), 0.01 * kDegree);
  EXPECT_LT(largestTurn(skinOf(test::irregularTorus(6, 2, 48, 24, 1), 0.2), 20), 0.01 * kDegree);
}

TEST(BuildSkin, OfABoxIsFlatWithSharpEdges) {
  const Skin skin = skinOf(test::boxMesh({-1, -2, -3}, {1, 2, 3}), 0.1);
  EXPECT_EQ(flatCount(skin), 12u);
  EXPECT_EQ(sharpCount(skin), 24u);  // 12 edges, from both sides
  EXPECT_EQ(skin.vertices.size(), 24u);
  EXPECT_EQ(skin.edges.size(), 30u);
  EXPECT_EQ(skin.tolerance, 0);
  EXPECT_LT(skin.mesh_distance, 1e-4f);
}

TEST(BuildSkin, OfASphereIsRound) {
  const Skin skin = skinOf(test::sphereMesh(5, 4), 1);
  EXPECT_EQ(sharpCount(skin), 0u);
  const auto surface = [](const Vector3d& p) { return std::array<Vector3d, 2>{5 * p.normalized(), p.normalized()}; };
  const auto errors_of = [&](const Skin& of) {
    return printed("sphere of radius 5", of.triangles.size(), test::errorsAgainst(of, surface));
  };
  const test::SkinErrors errors = errors_of(skin), coarse = errors_of(skinOf(test::sphereMesh(5, 3), 1));
  EXPECT_LT(errors.position, 5e-4);  // flat triangles are up to 0.05 inside
  EXPECT_LT(errors.normal, 0.2 * kDegree);
  EXPECT_LT(errors.position, 0.3 * coarse.position) << "the second power of the length of the edges";
}

TEST(BuildSkin, OfATorusIsRound) {
  const auto surface = [](const Vector3d& p) {
    const Vector3d c = 6 * Vector3d(p.x(), p.y(), 0).normalized(), n = (p - c).normalized();
    return std::array<Vector3d, 2>{c + 2 * n, n};
  };
  const auto errors_of = [&](const TriangleMesh& mesh) {
    return printed("torus of radii 6 and 2", mesh.triangles.size(), test::errorsAgainst(skinOf(mesh, 1), surface));
  };
  const test::SkinErrors coarse = errors_of(test::torusMesh(6, 2, 32, 16)), fine = errors_of(test::torusMesh(6, 2, 64, 32));
  EXPECT_LT(fine.position, 4e-4);
  EXPECT_LT(fine.normal, 0.02 * kDegree);
  EXPECT_LT(fine.normal, 0.2 * coarse.normal) << "the third power of the length of the edges";
}

TEST(BuildSkin, OfACylinderIsRoundUpToItsFlatCaps) {
  const Skin skin = skinOf(test::cylinderMesh(3, 8, 32, 4), 0.1);
  EXPECT_EQ(flatCount(skin), 64u);
  EXPECT_EQ(sharpCount(skin), 128u);  // 64 edges, from both sides
  const auto surface = [](const Vector3d& p) {
    const Vector3d c(0, 0, p.z()), n = (p - c).normalized();
    return std::array<Vector3d, 2>{c + 3 * n, n};
  };
  const auto is_side = [](const test::PatchPoint& p) { return std::abs(p.normal.z()) < 0.5; };
  const auto is_middle = [&](const test::PatchPoint& p) { return is_side(p) && std::abs(p.position.z() - 4) < 2; };
  EXPECT_LT(test::errorsAgainst(skin, surface, is_side).normal, 0.02 * kDegree);
  EXPECT_LT(test::errorsAgainst(skin, surface, is_side).position, 0.015);  // the sharp edges are straight: 3 (1 - cos 5.6 degrees)
  const test::SkinErrors middle =
      printed("cylinder of radius 3 with caps, away from its ends", skin.triangles.size(), test::errorsAgainst(skin, surface, is_middle));
  EXPECT_LT(middle.position, 2e-4);
}

TEST(BuildSkin, StaysWithinItsStatedBounds) {
  test::Random random(5);
  for (const TriangleMesh& mesh : sampleMeshes())
    for (const double tolerance : {0.3, 0.05, 0.002}) {
      const Skin skin = skinOf(mesh, tolerance);
      const DistanceField field(mesh), flat(flatTriangles(skin, Vector3d::Zero()));
      EXPECT_LE(double{skin.tolerance} + double{skin.mesh_distance}, std::max(tolerance, 1e-3)) << "rounding alone moves vertices";
      for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
        const SkinPatch patch = patchOf(skin, t);
        for (int i = 0; i < 10; ++i) {
          const test::PatchPoint p = test::pointOf(patch, test::randomPlace(random));
          EXPECT_LE((p.position - p.flat).norm(), double{skin.tolerance} + 1e-6);
          EXPECT_LE(field.distance(p.flat), double{skin.mesh_distance});
        }
      }
      for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const Vector3d w = test::randomPlace(random);
        EXPECT_LE(flat.distance(w[0] * mesh.corner(t, 0) + w[1] * mesh.corner(t, 1) + w[2] * mesh.corner(t, 2)),
                  double{skin.mesh_distance});
      }
    }
}

TEST(BuildSkin, SimplifiesWithinADistanceThatHoldsBothWays) {
  TriangleMesh fine = test::boxMesh({-5, -4, -3}, {5, 4, 3});
  for (int round = 0; round < 5; ++round) fine = test::quartered(std::move(fine));  // 12,288 triangles in six planes
  const Skin box = skinOf(fine, 0.1);
  EXPECT_EQ(findFault(box), "");
  EXPECT_LT(box.triangles.size(), 6000u);
  EXPECT_EQ(flatCount(box), box.triangles.size());
  EXPECT_LT(box.mesh_distance, 0.003f);

  const TriangleMesh torus = test::torusMesh(6, 2, 200, 90);  // 36,000 triangles: more than 16 bits name
  const Skin skin = skinOf(torus, 0.05);
  EXPECT_EQ(findFault(skin), "");
  EXPECT_LT(skin.triangles.size(), 31000u);
  const DistanceField field(torus), flat(flatTriangles(skin, Vector3d::Zero()));
  test::Random random(6);
  double there = 0, back = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3d w = test::randomPlace(random);
    const test::PatchPoint p = test::pointOf(patchOf(skin, random.below(skin.triangles.size())), w);
    there = std::max(there, field.distance(p.flat));
    const std::size_t t = random.below(torus.triangles.size());
    back = std::max(back, flat.distance(w[0] * torus.corner(t, 0) + w[1] * torus.corner(t, 1) + w[2] * torus.corner(t, 2)));
  }
  EXPECT_LE(std::max(there, back), double{skin.mesh_distance});
  EXPECT_GT(std::max(there, back), 0.05 * double{skin.mesh_distance}) << "the bound says little";
  EXPECT_LE(skin.mesh_distance, 0.05f);
}

// The bound of a skin that goes on from a simplified mesh is proven in two steps: it holds, and is hardly looser.
TEST(BuildSkin, ABoundInTwoStepsHolds) {
  const TriangleMesh torus = test::torusMesh(6, 2, 420, 140);
  const DistanceField field(torus);
  Progress silent;
  MeshSimplifier simplifier(torus, silent);
  const TriangleMesh step = simplifier.reduce(60'000);
  ASSERT_GT(step.triangles.size(), 50'000u);
  const double to_step = distanceBound(torus, DistanceField(step), silent);
  const SkinSettings settings{0.8, {}, 50 * kDegree};
  const Skin skin = buildSkin(torus, {}, field, Vector3d::Zero(), settings, silent, &simplifier, to_step);
  EXPECT_LT(to_step, 0.05 * 0.1 * settings.tolerance) << "the first step is too coarse to be used";
  const TriangleMesh flat = flatTriangles(skin, Vector3d::Zero());
  const DistanceField of_skin(flat);
  double farthest = 0;
  for (const Vector3d& p : torus.positions) farthest = std::max(farthest, of_skin.distance(p));
  EXPECT_LE(farthest, double{skin.mesh_distance});
  EXPECT_LE(skin.mesh_distance, 1.05 * std::max(distanceBound(torus, of_skin, silent), distanceBound(flat, field, silent)) + to_step);
}

TEST(BuildSkin, SwingsLessWhereATriangleAllowsLess) {
  const TriangleMesh mesh = test::torusMesh(6, 2, 32, 16);
  std::vector<double> allowed;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) allowed.push_back(mesh.corner(t, 0).x() > 0 ? 0.01 : 0.5);
  Progress silent;
  const Skin skin = buildSkin(mesh, {}, DistanceField(mesh), Vector3d::Zero(), {0.01, allowed, 50 * kDegree}, silent);
  double strict = 0, loose = 0;
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const SkinPatch patch = patchOf(skin, t);
    bool is_strict = true, is_loose = true;
    for (std::size_t k = 0; k < 3; ++k) is_strict &= patch.position[k].x() > 0.5f, is_loose &= patch.position[k].x() < -1.5f;
    for (const std::uint16_t e : skin.triangles[t].edge) {
      if (is_strict) strict = std::max(strict, double{swingOf(skin, skin.edges[e])});
      if (is_loose) loose = std::max(loose, double{swingOf(skin, skin.edges[e])});
    }
  }
  EXPECT_LE(strict, 0.01);
  EXPECT_GT(loose, 0.05);
}

TEST(BuildSkin, FollowsAMotionOfTheMesh) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.9, Vector3d(1, -2, 3).normalized()).toRotationMatrix();
  for (const TriangleMesh& mesh : sampleMeshes()) {
    TriangleMesh moved = mesh;
    for (Vector3d& p : moved.positions) p = 3 * (turn * p) + Vector3d(50, 60, 70);
    const Vector3d origin(40, 40, 40);
    const Skin one = skinOf(mesh, 0.1), other = skinOf(moved, 0.3, origin);
    const double rounding = 4 * double{one.step + other.step} + 2 * double{one.offset_step + other.offset_step};
    const auto order = [](const Skin& skin) {
      std::vector<std::array<double, 6>> middles;
      for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
        const test::PatchPoint p = test::pointOf(patchOf(skin, t), Vector3d(0.2, 0.3, 0.5));
        middles.push_back({p.position.x(), p.position.y(), p.position.z(), p.normal.x(), p.normal.y(), p.normal.z()});
      }
      return middles;
    };
    // Triangles may have another order: each midpoint has to be looked up.
    const auto ours = order(one), theirs = order(other);
    ASSERT_EQ(ours.size(), theirs.size());
    for (const auto& m : ours) {
      const Vector3d p = 3 * (turn * Vector3d(m[0], m[1], m[2])) + Vector3d(10, 20, 30), n = turn * Vector3d(m[3], m[4], m[5]);
      double best = 1e9, angle = 4;
      for (const auto& o : theirs)
        if (const double d = (Vector3d(o[0], o[1], o[2]) - p).norm(); d < best) best = d, angle = (Vector3d(o[3], o[4], o[5]) - n).norm();
      // The corners of a patch may be rotated: its point is then another one of three.
      if (best > 0.1) continue;
      EXPECT_LT(best, 3 * rounding);
      EXPECT_LT(angle, 1e-3);
    }
  }
}

TEST(BuildSkin, IsTheSameForAnyNumberOfThreads) {
  const TriangleMesh torus = test::torusMesh(6, 2, 190, 80);
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return skinOf(torus, 0.05);
  };
  const Skin one = with(1);
  EXPECT_EQ(one, with(8));
}

TEST(BuildSkin, HoldsSheetsBesideTheSolid) {
  TriangleMesh sheet;
  sheet.positions = {{0, 0, 2}, {3, 0, 2}, {0, 3, 2}, {9, 9, 9}};  // a vertex of no triangle
  sheet.triangles = {{0, 1, 2}, {0, 2, 1}, {1, 1, 2}};             // from both sides; one degenerate triangle
  const TriangleMesh box = test::boxMesh({-1, -1, -1}, {1, 1, 1});
  const Skin skin = skinOf(box, 0.1, Vector3d::Zero(), sheet);
  EXPECT_EQ(findFault(skin), "");
  EXPECT_EQ(skin.triangles.size(), 14u);
  EXPECT_LT(skin.mesh_distance, 1e-3f);
}

TEST(BuildSkin, KeepsToTheOriginOfItsTree) {
  TriangleMesh mesh = test::sphereMesh(5, 3);
  const Vector3d origin(1e6, -2e6, 3e6);
  for (Vector3d& p : mesh.positions) p += origin;
  const Skin skin = skinOf(mesh, 0.1, origin);
  EXPECT_EQ(findFault(skin), "");
  EXPECT_LT(skin.mesh_distance, 1e-3f);
  for (std::size_t t = 0; t < skin.triangles.size(); ++t)
    for (const Eigen::Vector3f& p : patchOf(skin, t).position) EXPECT_LT(p.norm(), 5.1f);
}

/// A minimal reader for the external meshes: only lines of v and f.
TriangleMesh readObj(const std::filesystem::path& path) {
  TriangleMesh mesh;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      Vector3d& p = mesh.positions.emplace_back();
      words >> p.x() >> p.y() >> p.z();
    } else if (kind == "f") {
      Triangle& t = mesh.triangles.emplace_back();
      std::string corner;
      for (std::uint32_t& v : t) words >> corner, v = static_cast<std::uint32_t>(std::stoul(corner)) - 1;
    }
  }
  return mesh;
}

/// Scaled to 25 mm, as it is and turned.
void expectNoFolds(const std::string& name, const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : mesh.positions) box.extend(p);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vector3d(3, 1, -2).normalized()).toRotationMatrix();
  for (const bool is_turned : {false, true}) {
    TriangleMesh posed = mesh;
    for (Vector3d& p : posed.positions) p = (is_turned ? turn : Eigen::Matrix3d::Identity()) * (25 / box.diagonal().norm() * p);
    const Skin skin = skinOf(posed, 0.05);
    EXPECT_EQ(findFault(skin), "");
    double folded = 0, area = 0;
    for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
      const SkinPatch patch = patchOf(skin, t);
      const Vector3d a = patch.position[0].cast<double>(),
                     n = (patch.position[1].cast<double>() - a).cross(patch.position[2].cast<double>() - a);
      bool leans = false;
      for (const Eigen::Vector3f& normal : patch.normal) leans |= normal.cast<double>().dot(n) < 0.4 * n.norm();
      area += n.norm();
      if (leans) folded += n.norm();
    }
    EXPECT_LT(folded, 1e-6 * area) << name << ": only needles, whose own normals are rounding errors, may lean";
  }
}

// Long thin triangles next to regular ones, where the limit of a subdivision surface leaves its facets and folds over.
TEST(BuildSkin, OfMachinedPartsHasNoFolds) {
  constexpr std::uint32_t kAround = 36, kAcross = 24;
  TriangleMesh torus = test::torusMesh(6, 2, kAround, kAcross);
  for (std::uint32_t ring = 1; ring < kAround; ring += 3)  // nearly as far back as the ring before: needles
    for (std::uint32_t k = 0; k < kAcross; ++k) {
      Vector3d& p = torus.positions[ring * kAcross + k];
      p = Eigen::AngleAxisd(-0.98 * 2 * std::numbers::pi / kAround, Vector3d::UnitZ()) * p;
    }
  expectNoFolds("torus with needles", torus);
  for (const char* name : {"cad_metacarpal_link.obj", "cad_fandisk.obj", "thin_mug.obj"})
    if (const auto path = std::filesystem::path(SPHERETREE_SHARED_DIR) / "meshes/bench" / name; std::filesystem::exists(path))
      expectNoFolds(name, readObj(path));
}

TEST(BuildSkin, RefusesADamagedSkin) {
  const Skin skin = skinOf(test::torusMesh(6, 2, 32, 16), 0.1);
  Skin damaged = skin;
  damaged.tolerance *= 0.9f;
  EXPECT_NE(findFault(damaged).find("swings out"), std::string::npos);
  damaged = skin;
  damaged.search.inner[3].radius *= 0.9f;
  EXPECT_NE(findFault(damaged).find("does not enclose"), std::string::npos);
}

TEST(EvaluateSkin, FindsADisplacement) {
  const TriangleMesh mesh = test::sphereMesh(5, 3);
  const Skin skin = skinOf(mesh, 0.1);
  Progress silent;
  const SkinEvaluation there = evaluateSkin(skin, Vector3d::Zero(), mesh, DistanceField(mesh), silent);
  EXPECT_EQ(there.triangles, mesh.triangles.size());
  EXPECT_EQ(there.sharp_edges, 0u);
  EXPECT_LE(*there.from_mesh, 1.3 * there.mesh_distance);
  EXPECT_LE(*there.of_mesh, 1.3 * there.mesh_distance);
  EXPECT_NEAR(there.edge_angle_max, 0.2, 0.06);  // edges of about 11 degrees
  const SkinEvaluation moved = evaluateSkin(skin, Vector3d(0.5, 0, 0), mesh, DistanceField(mesh), silent);
  EXPECT_NEAR(*moved.from_mesh, 0.5, 0.05);
  EXPECT_NEAR(*moved.of_mesh, 0.5, 0.05);
}

}  // namespace
}  // namespace spheretree::builder
