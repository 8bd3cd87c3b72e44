// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/moved_skin.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

#include "scene/compiled_scene.h"
#include "support/random.h"
#include "support/soft_block.h"
#include "tissue/soft_model.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// The block of soft tissue, its shape in a scene, and a skin of it that moves.
struct SoftSkin {
  const test::SoftBlock& block = test::fineBlock();
  const SoftModel& model = static_cast<const SoftModel&>(*block.model);
  Vector3d origin{block.tree.origin_mm.data()};
  CompiledShape shape;
  std::vector<float> shift;

  SoftSkin() {
    shape.centre = Vector3d(12, 10, 6);
    shape.skin = compileSkin(block.tree.skin, origin - shape.centre);
    shape.radius = 20;
    shift.assign(3 * model.node_count, 0.0f);
  }
  /// Moves every pressed node by `map`; frame of the mesh.
  void moveTo(const std::function<Vector3d(const Vector3d&)>& map) {
    for (std::size_t i = 0; i < model.node_count; ++i) {
      const Vector3d rest = model.node_places[i].cast<double>() + origin;
      Eigen::Map<Vector3f>(shift.data() + 3 * i) = (map(rest) - rest).cast<float>();
    }
  }
  std::vector<std::uint32_t> allPairs() const {
    std::vector<std::uint32_t> pairs;
    for (std::uint32_t slot = 0; slot < shape.skin.tree.item.size(); ++slot)
      if (shape.skin.tree.item[slot] != kNoItem) pairs.push_back(slot);
    return pairs;
  }
  /// Frame of the mesh.
  Vector3d pointOf(const CompiledPatch& p, double u, double v) const {
    const double w = 1 - u - v, weights[6] = {w * (2 * w - 1), u * (2 * u - 1), v * (2 * v - 1), 4 * w * u, 4 * u * v, 4 * v * w};
    Vector3d sum = shape.centre;
    for (int k = 0; k < 6; ++k) sum += weights[k] * Vector3d(p.position[k][0], p.position[k][1], p.position[k][2]);
    return sum;
  }
};

/// A ball of the search.
struct Ball {
  Vector3f centre;
  float radius;

  Ball(const runtime::Block* bound, std::uint32_t slot) {
    const runtime::Block& b = bound[slot / 8];
    centre = {b.x[slot % 8], b.y[slot % 8], b.z[slot % 8]};
    radius = b.r[slot % 8];
  }
  double beyond(const Vector3f& p, float r = 0) const { return static_cast<double>((p - centre).norm() + r - radius); }
};

Vector3d normalOf(const CompiledPatch& p, int node) {
  Vector3d n;
  for (int k = 0; k < 3; ++k) n[k] = static_cast<std::int16_t>(p.normal[node][k]) / static_cast<double>(kNormalScale);
  return n;
}

TEST(MovedSkin, AtRestItIsTheSkin) {
  SoftSkin b;
  MovedSkin skin(b.model, b.shape);
  skin.bend(b.shift);
  skin.put(b.allPairs(), b.shift);
  for (std::size_t t = 0; t < b.shape.skin.patch.size(); ++t)
    for (int k = 0; k < 6; ++k) {
      EXPECT_LT((normalOf(skin.patches()[t], k) - normalOf(b.shape.skin.patch[t], k)).norm(), 1e-3);
      for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(skin.patches()[t].position[k][axis], b.shape.skin.patch[t].position[k][axis], 1e-4);
    }
}

// The fixed nodes stay below; the triangles examined move as a whole.
TEST(MovedSkin, TurnedWithItsTissueItIsTheSameSkinTurned) {
  SoftSkin b;
  const Vector3d pivot(12, 10, 6);
  const Eigen::Matrix3d turn = rotationOf({0.4, -0.3, 0.8}).toRotationMatrix();
  b.moveTo([&](const Vector3d& p) { return Vector3d(turn * (p - pivot) + pivot + Vector3d(3, -2, 5)); });
  MovedSkin skin(b.model, b.shape);
  skin.bend(b.shift);
  skin.put(b.allPairs(), b.shift);
  std::size_t seen = 0;
  for (std::size_t t = 0; t < b.shape.skin.patch.size(); ++t) {
    const CompiledPatch &rest = b.shape.skin.patch[t], &now = skin.patches()[t];
    bool is_high = true;
    for (int k = 0; k < 3; ++k) is_high = is_high && rest.position[k][2] > 0;  // the middle of the block is its centre
    if (!is_high) continue;
    ++seen;
    for (int k = 0; k < 6; ++k) {
      const Vector3d p(rest.position[k][0], rest.position[k][1], rest.position[k][2]);
      const Vector3d wanted = turn * (p + b.shape.centre - pivot) + pivot + Vector3d(3, -2, 5) - b.shape.centre;
      EXPECT_LT((Vector3d(now.position[k][0], now.position[k][1], now.position[k][2]) - wanted).norm(), 1e-3);
      EXPECT_LT((normalOf(now, k) - turn * normalOf(rest, k)).norm(), 2e-3);
    }
  }
  EXPECT_GT(seen, 300u);
}

// A dent in the form of a ball: between the nodes, which lie on the ball, the patches follow the ball, not its chords.
TEST(MovedSkin, ADentIsAsRoundAsTheBallThatMadeIt) {
  constexpr double kRadius = 15;
  SoftSkin b;
  const Vector3d middle(12, 10, 12 + kRadius);
  b.moveTo([&](const Vector3d& p) {
    const double across2 = (p - middle).head<2>().squaredNorm();
    return Vector3d(p.x(), p.y(), p.z() + kRadius - std::sqrt(kRadius * kRadius - std::min(across2, 200.0)));
  });
  MovedSkin skin(b.model, b.shape);
  skin.bend(b.shift);
  skin.put(b.allPairs(), b.shift);
  double farthest = 0, of_chords = 0;
  test::Random random(7);
  for (std::size_t t = 0; t < b.shape.skin.patch.size(); ++t) {
    const CompiledPatch &rest = b.shape.skin.patch[t], &now = skin.patches()[t];
    const Vector3d c = b.pointOf(rest, 1.0 / 3, 1.0 / 3);
    if (c.z() < 11.99 || (c - middle).head<2>().norm() > 5) continue;  // away from the edges of the top
    for (int n = 0; n < 10; ++n) {
      double u = random.between(0, 1), v = random.between(0, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      farthest = std::max(farthest, std::abs((b.pointOf(now, u, v) - middle).norm() - kRadius));
    }
  }
  for (const std::array<std::uint32_t, 3>& face : b.model.faces)
    for (std::size_t k = 0; k < 3; ++k) {
      const double side = (b.model.node_places[face[(k + 1) % 3]] - b.model.node_places[face[k]]).norm();
      of_chords = std::max(of_chords, side * side / (8 * kRadius));
    }
  EXPECT_GT(of_chords, 0.15);
  EXPECT_LT(farthest, 0.1 * of_chords);
}

TEST(MovedSkin, TrianglesHaveTheCornersOfTheirPatchesWhichSwingNoFartherThanTheBound) {
  SoftSkin b;
  MovedSkin skin(b.model, b.shape), corners_first(b.model, b.shape);
  test::Random random(5);
  const std::vector<std::uint32_t> pairs = b.allPairs();
  for (int round = 0; round < 10; ++round) {
    for (float& x : b.shift)
      if (random.below(4) == 0) x += static_cast<float>(random.between(-1, 1));
    for (MovedSkin* s : {&skin, &corners_first}) s->bend(b.shift), s->refit(b.shift);
    skin.put(pairs, b.shift);
    corners_first.putTriangles(pairs, b.shift);
    double farthest = 0;
    for (const std::uint32_t pair : pairs) {
      const std::uint32_t t = b.shape.skin.tree.item[pair];
      const CompiledPatch &p = skin.patches()[t], &q = corners_first.patches()[t];
      for (int k = 0; k < 3; ++k)
        for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(p.position[k][axis], q.position[k][axis]) << "round " << round;
      for (double u = 0; u <= 1; u += 0.125)
        for (double v = 0; u + v <= 1; v += 0.125) {
          const Vector3d flat = (1 - u - v) * b.pointOf(p, 0, 0) + u * b.pointOf(p, 1, 0) + v * b.pointOf(p, 0, 1);
          farthest = std::max(farthest, (b.pointOf(p, u, v) - flat).norm());
        }
    }
    EXPECT_LT(farthest, static_cast<double>(skin.largestSwing()) + 1e-5) << "round " << round;
    EXPECT_GT(farthest, 0.1 * static_cast<double>(skin.largestSwing()));
  }
}

TEST(MovedSkin, BallsOfTheSearchHoldTheirPatches) {
  SoftSkin b;
  MovedSkin skin(b.model, b.shape);
  test::Random random(3);
  const std::vector<std::uint32_t> pairs = b.allPairs();
  const CompiledTree& tree = b.shape.skin.tree;
  std::vector<std::uint32_t> parent(tree.bound.size());
  for (std::uint32_t slot = 0; slot < tree.item.size(); ++slot)
    if (tree.isInner(slot)) parent[tree.links[slot / 8].first_child + slot % 8] = slot;
  for (int round = 0; round < 20; ++round) {
    const double size = random.between(0.01, 3);
    for (float& x : b.shift)
      if (random.below(4) == 0) x += static_cast<float>(size * random.between(-1, 1));
    skin.bend(b.shift);
    skin.refit(b.shift);
    skin.put(pairs, b.shift);
    for (const std::uint32_t pair : pairs) {
      const CompiledPatch& p = skin.patches()[b.shape.skin.tree.item[pair]];
      for (std::uint32_t slot = pair;; slot = parent[slot / 8]) {  // and all above
        for (const auto& at : p.position) EXPECT_LE(Ball(skin.bound(), slot).beyond({at[0], at[1], at[2]}), kRefitMm) << "round " << round;
        if (slot == 0) break;
      }
    }
    EXPECT_GE(skin.radius() + 1e-4, Ball(skin.bound(), 0).centre.norm() + Ball(skin.bound(), 0).radius);
  }
}

}  // namespace
}  // namespace spheretree::runtime
