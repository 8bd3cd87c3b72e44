// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/skin.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "support/sample_skins.h"

namespace spheretree {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// Barycentric coordinates, evenly spread over the triangle.
Vector3d place(test::Random& random) {
  double u = random.unit(), v = random.unit();
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return {1 - u - v, u, v};
}

/// By the formula in skin.h, in double.
Vector3d evaluate(const std::array<Vector3f, 6>& nodes, const Vector3d& w) {
  Vector3d sum = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    sum += w[k] * (2 * w[k] - 1) * nodes[static_cast<std::size_t>(k)].cast<double>();
    sum += 4 * w[k] * w[(k + 1) % 3] * nodes[static_cast<std::size_t>(3 + k)].cast<double>();
  }
  return sum;
}

double angleBetween(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

std::vector<Skin> sampleSkins() {
  std::vector<Skin> skins{test::roundSkin(0), test::roundSkin(2), test::gridSkin(5), test::boxSkin({1, 2, 3})};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) skins.push_back(test::randomSkin(seed));
  return skins;
}

TEST(PackedNormal, ErrsByLessThanItsBound) {
  test::Random random(1);
  std::vector<Vector3d> directions;
  for (int i = 0; i < 200000; ++i) directions.push_back(random.direction());
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z)  // axes, diagonals, and points next to them, where the octahedron is folded
        for (const double aside : {0.0, 1e-9, 1e-5, 3e-5})
          if (x != 0 || y != 0 || z != 0) directions.push_back((Vector3d(x, y, z) + aside * random.direction()).normalized());
  double worst = 0;
  for (const Vector3d& n : directions) {
    const PackedNormal packed = packNormal(n);
    for (const std::int16_t coordinate : packed) ASSERT_GE(coordinate, -32767);
    const Vector3d again = unpackNormal(packed).cast<double>();
    EXPECT_NEAR(again.norm(), 1, 3e-7);
    worst = std::max(worst, angleBetween(n, again));
  }
  EXPECT_LT(worst, kNormalError);
  EXPECT_GT(worst, 0.5 * kNormalError) << "the stated bound is not tight";
}

TEST(PackedNormal, OfAxesAreExact) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) {
      const Vector3d n = sign * Vector3d::Unit(axis);
      EXPECT_EQ(unpackNormal(packNormal(n)).cast<double>(), n);
    }
}

TEST(PackedNormal, EveryPairOfCoordinatesIsAUnitVector) {
  for (int u = -32767; u <= 32767; u += 257)
    for (int v = -32767; v <= 32767; v += 257) {
      const Vector3f n = unpackNormal({static_cast<std::int16_t>(u), static_cast<std::int16_t>(v)});
      ASSERT_NEAR(n.norm(), 1, 3e-7) << u << ", " << v;
    }
}

TEST(SkinPatch, InterpolatesItsNodes) {
  const std::array<Vector3d, 6> at{Vector3d(1, 0, 0),     Vector3d(0, 1, 0),     Vector3d(0, 0, 1),
                                   Vector3d(0.5, 0.5, 0), Vector3d(0, 0.5, 0.5), Vector3d(0.5, 0, 0.5)};
  for (const Skin& skin : sampleSkins())
    for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
      const SkinPatch patch = patchOf(skin, t);
      for (std::size_t k = 0; k < 6; ++k) {
        EXPECT_EQ(evaluate(patch.position, at[k]).cast<float>(), patch.position[k]);
        EXPECT_EQ(evaluate(patch.normal, at[k]).cast<float>(), patch.normal[k]);
      }
    }
}

TEST(SkinPatch, HasItsNodesWhereTheNumbersSay) {
  for (const Skin& skin : sampleSkins())
    for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
      const SkinPatch patch = patchOf(skin, t);
      std::array<Vector3d, 3> corner;
      for (std::size_t k = 0; k < 3; ++k) {
        const SkinVertex& v = skin.vertices[skin.triangles[t].vertex[k]];
        for (int axis = 0; axis < 3; ++axis)
          corner[k][axis] =
              double{skin.low[static_cast<std::size_t>(axis)]} + double{skin.step} * v.position[static_cast<std::size_t>(axis)];
        EXPECT_LT((corner[k] - patch.position[k].cast<double>()).norm(), 2e-6);
      }
      for (std::size_t k = 0; k < 3; ++k) {
        const SkinEdge& e = skin.edges[skin.triangles[t].edge[k]];
        const Vector3d offset = double{skin.offset_step} * Vector3d(e.offset[0], e.offset[1], e.offset[2]);
        EXPECT_LT((0.5 * (corner[k] + corner[(k + 1) % 3]) + offset - patch.position[3 + k].cast<double>()).norm(), 3e-6);
        EXPECT_EQ(patch.is_sharp[k], e.is_sharp == 1);
      }
    }
}

TEST(SkinPatch, AgreesWithItsNeighbourAlongASharedSide) {
  for (const Skin& skin : sampleSkins()) {
    struct Side {
      std::size_t triangle, side;
    };
    std::map<std::uint16_t, Side> met;
    for (std::size_t t = 0; t < skin.triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [other, is_new] = met.try_emplace(skin.triangles[t].edge[k], Side{t, k});
        if (is_new) continue;
        const SkinPatch a = patchOf(skin, t), b = patchOf(skin, other->second.triangle);
        for (const double along : {0.0, 0.1, 0.35, 0.5, 0.8, 1.0}) {  // the neighbour goes along its side the other way
          Vector3d w = Vector3d::Zero(), v = w;
          w[static_cast<int>(k)] = v[static_cast<int>((other->second.side + 1) % 3)] = 1 - along;
          w[static_cast<int>((k + 1) % 3)] = v[static_cast<int>(other->second.side)] = along;
          EXPECT_LT((evaluate(a.position, w) - evaluate(b.position, v)).norm(), 1e-6);
          EXPECT_LT((evaluate(a.normal, w) - evaluate(b.normal, v)).norm(), 1e-6);
        }
      }
  }
}

TEST(SkinPatch, FollowsASphereThatItStandsFor) {
  const Skin skin = test::roundSkin(3, 5);  // 512 triangles, edges of about 8 degrees
  test::Random random(3);
  for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
    const SkinPatch patch = patchOf(skin, t);
    for (int i = 0; i < 10; ++i) {
      const Vector3d w = place(random), p = evaluate(patch.position, w);
      EXPECT_NEAR(p.norm(), 5, 5e-4);  // flat triangles are 0.03 inside
      EXPECT_LT(angleBetween(evaluate(patch.normal, w), p), 1e-3);
    }
  }
}

TEST(SwingOf, BoundsHowFarAPatchIsFromItsFlatTriangle) {
  test::Random random(7);
  double closest = 0;
  for (const Skin& skin : sampleSkins())
    for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
      const SkinPatch patch = patchOf(skin, t);
      double swing = 0;
      for (const std::uint16_t e : skin.triangles[t].edge) swing = std::max(swing, double{swingOf(skin, skin.edges[e])});
      for (int i = 0; i < 40; ++i) {
        const Vector3d w = i == 0 ? Vector3d::Constant(1.0 / 3) : place(random);
        Vector3d flat = Vector3d::Zero();
        for (int k = 0; k < 3; ++k) flat += w[k] * patch.position[static_cast<std::size_t>(k)].cast<double>();
        const double moved = (evaluate(patch.position, w) - flat).norm();
        EXPECT_LE(moved, swing + 2e-6);
        if (swing > 1e-3) closest = std::max(closest, moved / swing);
      }
    }
  EXPECT_GT(closest, 0.95) << "the middle of a patch with three equal offsets reaches the bound";
}

TEST(SwingOf, IsFourThirdsOfTheOffset) {
  Skin skin;
  skin.offset_step = 0.25f;
  EXPECT_NEAR(swingOf(skin, {{2, -3, 6}, 0, {}}), 7.0 / 3, 1e-5);
  EXPECT_EQ(swingOf(skin, {{0, 0, 0}, 1, {}}), 0);
}

TEST(AllowanceOf, IsZeroExactlyForFlatPatches) {
  for (const Skin& skin : {test::gridSkin(4), test::boxSkin({1, 2, 3})})
    for (std::size_t t = 0; t < skin.triangles.size(); ++t) EXPECT_EQ(allowanceOf(patchOf(skin, t), 0.5f), 0);
  const Skin round = test::roundSkin(2);
  for (std::size_t t = 0; t < round.triangles.size(); ++t) EXPECT_EQ(allowanceOf(patchOf(round, t), 0.5f), 0.5f);
  Skin bent = test::gridSkin(1);
  bent.edges[bent.triangles[0].edge[1]].normal = packNormal(Vector3d(0.001, 0, 1).normalized());
  EXPECT_EQ(allowanceOf(patchOf(bent, 0), 0.5f), 0.5f) << "a normal that differs";
  bent = test::gridSkin(1);
  bent.offset_step = 1e-4f;
  bent.edges[bent.triangles[0].edge[1]].offset = {0, 0, 1};
  EXPECT_EQ(allowanceOf(patchOf(bent, 0), 0.5f), 0.5f) << "a side that is not straight";
}

TEST(Enclose, HoldsThePatchAndItsFlatTriangle) {
  test::Random random(2);
  for (const Skin& skin : sampleSkins())
    for (std::size_t t = 0; t < skin.triangles.size(); ++t) {
      const SkinPatch patch = patchOf(skin, t);
      const Sphere s = enclose(patch);
      const Vector3d centre(s.x, s.y, s.z);
      double size = 0;
      for (const Vector3f& p : patch.position) size = std::max(size, (p.cast<double>() - centre).norm());
      EXPECT_LE(double{s.radius}, 2.5 * size + 1e-5) << "far larger than needed";
      for (int i = 0; i < 40; ++i) {
        const Vector3d w = place(random);
        const Vector3d flat =
            w[0] * patch.position[0].cast<double>() + w[1] * patch.position[1].cast<double>() + w[2] * patch.position[2].cast<double>();
        EXPECT_LE((evaluate(patch.position, w) - centre).norm(), double{s.radius});
        EXPECT_LE((flat - centre).norm(), double{s.radius});
      }
    }
}

// Products of squares of lengths underflow long before the lengths do.
TEST(Enclose, HoldsTrianglesOfAnySize) {
  for (const float size : {1e-30f, 1e-20f, 1e-13f, 1e-11f, 1e-8f, 1e3f, 1e7f})
    for (const float flat : {0.0f, 0.3f, 0.8f, 1.7f}) {
      const Vector3f a(0, 0, 0), b(size, 0, 0), c(0.5f * size, flat * size, 0);
      SkinPatch patch{};
      patch.position = {a, b, c, 0.5f * (a + b), 0.5f * (b + c), 0.5f * (c + a)};
      const Sphere s = enclose(patch);
      ASSERT_TRUE(std::isfinite(s.x) && std::isfinite(s.y) && std::isfinite(s.z) && std::isfinite(s.radius)) << size << ' ' << flat;
      const Vector3d centre(s.x, s.y, s.z);
      for (const Vector3f& p : {a, b, c}) EXPECT_LE((p.cast<double>() - centre).norm(), double{s.radius}) << size << ' ' << flat;
      EXPECT_LE(double{s.radius}, 2 * std::max(1.0, double{flat}) * double{size} + 1e-18);
    }
}

TEST(Enclose, IsTheSmallestCircleOfAFlatTriangle) {
  SkinPatch patch{};
  const auto set = [&](const Vector3f& a, const Vector3f& b, const Vector3f& c) {
    patch.position = {a, b, c, 0.5f * (a + b), 0.5f * (b + c), 0.5f * (c + a)};
    return enclose(patch).radius;
  };
  EXPECT_NEAR(set({0, 0, 0}, {2, 0, 0}, {1, 0.1f, 0}), 1, 1e-5) << "obtuse: half of the longest side";
  EXPECT_NEAR(set({0, 0, 0}, {2, 0, 0}, {1, std::sqrt(3.0f), 0}), 2 / std::sqrt(3.0), 1e-5) << "even sides: the circumcircle";
  EXPECT_NEAR(set({0, 0, 0}, {2, 0, 0}, {1, 0, 0}), 1, 1e-5) << "no area";
  EXPECT_GT(set({3, 4, 5}, {3, 4, 5}, {3, 4, 5}), 0) << "one point";
}

/// The expected result of findFault() for the bounds of the search tree, item by item.
bool enclosesEachPatch(const Skin& skin) {
  const SearchTree& tree = skin.search;
  std::vector<std::size_t> parent(tree.inner.size(), 0);
  std::size_t next = 1, item = 0;
  bool all = true;
  for (std::size_t i = 0; i < tree.inner.size(); ++i) {
    for (std::size_t k = 0; k < tree.inner_children[i]; ++k) parent[next++] = i;
    for (std::size_t k = 0; k < tree.item_children[i]; ++k, ++item) {
      const SkinPatch patch = patchOf(skin, item);
      for (std::size_t above = i;; above = parent[above]) {
        const Sphere& s = tree.inner[above];
        const Vector3d centre(s.x, s.y, s.z);
        for (std::size_t n = 0; n < 3; ++n) {
          const Vector3d a = patch.position[n].cast<double>(), b = patch.position[(n + 1) % 3].cast<double>();
          const Vector3d control = 2 * patch.position[3 + n].cast<double>() - 0.5 * (a + b);
          all = all && (a - centre).norm() <= double{s.radius} && (control - centre).norm() <= double{s.radius};
        }
        if (above == 0) break;
      }
    }
  }
  return all;
}

TEST(SkinFindFault, AcceptsSoundSkins) {
  for (const Skin& skin : sampleSkins()) {
    EXPECT_EQ(findFault(skin), "");
    EXPECT_TRUE(enclosesEachPatch(skin));
  }
}

TEST(SkinFindFault, FindsASphereThatMissesAPatchExactlyIfThereIsOne) {
  test::Random random(5);
  int sound = 0, faulty = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Skin skin = test::randomSkin(seed);
    Sphere& sphere = skin.search.inner[random.below(skin.search.inner.size())];
    const auto shift = [&] { return 0.2f * sphere.radius * static_cast<float>(random.unit() - 0.5); };
    sphere.x += shift();
    sphere.y += shift();
    sphere.radius *= static_cast<float>(0.9 + 0.2 * random.unit());
    const bool encloses = enclosesEachPatch(skin);
    EXPECT_EQ(findFault(skin).empty(), encloses) << findFault(skin);
    (encloses ? sound : faulty) += 1;
  }
  EXPECT_GT(sound, 20);
  EXPECT_GT(faulty, 20);
}

TEST(SkinFindFault, FindsEachBrokenRule) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  constexpr std::int16_t kLowest = std::numeric_limits<std::int16_t>::min();
  struct Case {
    const char* words;
    std::function<void(Skin&)> damage;
  };
  const std::vector<Case> cases{
      {"beyond 1e7 mm", [=](Skin& s) { s.low[1] = nan; }},
      {"beyond 1e7 mm", [](Skin& s) { s.low[2] = -1.1e7f; }},
      {"step of positions", [](Skin& s) { s.step = 0; }},
      {"step of positions", [=](Skin& s) { s.step = inf; }},
      {"step of positions", [=](Skin& s) { s.step = nan; }},
      {"a length of the skin", [](Skin& s) { s.offset_step = -1; }},
      {"a length of the skin", [=](Skin& s) { s.tolerance = nan; }},
      {"a length of the skin", [](Skin& s) { s.tolerance = -1e-6f; }},
      {"a length of the skin", [=](Skin& s) { s.mesh_distance = inf; }},
      {"crease angle", [](Skin& s) { s.crease_angle = 3.2f; }},
      {"crease angle", [=](Skin& s) { s.crease_angle = nan; }},
      {"0 triangles", [](Skin& s) { s.triangles.clear(); }},
      {"32769 triangles", [](Skin& s) { s.triangles.resize(32769); }},
      {"more vertices or edges", [](Skin& s) { s.vertices.resize(65537); }},
      {"more vertices or edges", [](Skin& s) { s.edges.resize(65537); }},
      {"vertex 3 of the skin: its normal", [](Skin& s) { s.vertices[3].normal[0] = kLowest; }},
      {"vertex 3 of the skin: its normal", [](Skin& s) { s.vertices[3].normal[1] = kLowest; }},
      {"vertex 3 of the skin: its position", [](Skin& s) { s.vertices[3].position[2] = kMaxSkinCoordinate + 1; }},
      {"edge 2 of the skin: its normal", [](Skin& s) { s.edges[2].normal[1] = kLowest; }},
      {"edge 2 of the skin: its flag", [](Skin& s) { s.edges[2].is_sharp = 2; }},
      {"edge 2 of the skin: its offset", [](Skin& s) { s.edges[2].offset[1] = -128; }},
      {"swings out farther", [](Skin& s) { s.tolerance = 0; }},
      {"edge 2 of the skin: its offset", [](Skin& s) { s.edges[2].is_sharp = 1; }},
      {"triangle 4 of the skin: it names a vertex",
       [](Skin& s) { s.triangles[4].vertex[2] = static_cast<std::uint16_t>(s.vertices.size()); }},
      {"triangle 4 of the skin: it names a vertex", [](Skin& s) { s.triangles[4].edge[0] = 65535; }},
      {"triangle 4 of the skin: it names one twice", [](Skin& s) { s.triangles[4].vertex[2] = s.triangles[4].vertex[0]; }},
      {"triangle 4 of the skin: it names one twice", [](Skin& s) { s.triangles[4].edge[2] = s.triangles[4].edge[1]; }},
      {"list of items", [](Skin& s) { s.search.item.assign(s.triangles.size(), 0); }},
      {"skin: the search tree has no root", [](Skin& s) { s.search = SearchTree(); }},
      {"skin: node 1 of the search tree", [](Skin& s) { s.search.item_children[1] = 0, s.search.inner_children[1] = 0; }},
      {"skin: sphere 1 of the search tree is not finite", [=](Skin& s) { s.search.inner[1].y = nan; }},
      {"skin: sphere 1 of the search tree is not finite", [](Skin& s) { s.search.inner[1].radius = 0; }},
      {"skin: sphere 1 of the search tree does not enclose item", [](Skin& s) { s.search.inner[1].radius *= 0.9f; }},
      {"skin: sphere 0 of the search tree does not enclose item", [](Skin& s) { s.search.inner[0].x += 4; }},
  };
  for (const Case& c : cases) {
    Skin skin = test::roundSkin(1);
    c.damage(skin);
    EXPECT_NE(findFault(skin).find(c.words), std::string::npos) << "expected: " << c.words << "\nfound: " << findFault(skin);
  }
}

TEST(SkinEquality, SeesEveryField) {
  const Skin skin = test::roundSkin(1);
  EXPECT_EQ(skin, skin);
  const std::vector<std::function<void(Skin&)>> changes{
      [](Skin& s) { s.low[0] += 1; },
      [](Skin& s) { s.step *= 2; },
      [](Skin& s) { s.offset_step *= 2; },
      [](Skin& s) { s.tolerance *= 2; },
      [](Skin& s) { s.mesh_distance *= 2; },
      [](Skin& s) { s.crease_angle *= 2; },
      [](Skin& s) { s.vertices.pop_back(); },
      [](Skin& s) { ++s.vertices[1].position[2]; },
      [](Skin& s) { ++s.vertices[1].normal[1]; },
      [](Skin& s) { s.edges.pop_back(); },
      [](Skin& s) { ++s.edges[1].offset[2]; },
      [](Skin& s) { s.edges[1].is_sharp ^= 1; },
      [](Skin& s) { ++s.edges[1].normal[0]; },
      [](Skin& s) { s.triangles.pop_back(); },
      [](Skin& s) { ++s.triangles[1].vertex[0]; },
      [](Skin& s) { ++s.triangles[1].edge[2]; },
      [](Skin& s) { ++s.search.item_children[1]; },
  };
  for (std::size_t i = 0; i < changes.size(); ++i) {
    Skin other = skin;
    changes[i](other);
    EXPECT_FALSE(other == skin) << "change " << i;
  }
}

}  // namespace
}  // namespace spheretree
