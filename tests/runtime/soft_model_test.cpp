// SPDX-License-Identifier: Apache-2.0
#include "tissue/soft_model.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "support/octahedron_tissue.h"
#include "support/random.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr float kSharp = 0.5f, kRound = 1.3f;  // the faces of an octahedron meet at acos(1/3) = 1.23 rad

std::shared_ptr<SoftModel> modelOf(float crease_angle, std::uint32_t pressed = 6) {
  const test::OctahedronTissue made = test::octahedronTissue(crease_angle, pressed);
  return softModel(made.tree, made.tissue);
}

TEST(SoftModel, FansEndAtSharpSides) {
  const auto sharp = modelOf(kSharp), round = modelOf(kRound);
  ASSERT_EQ(sharp->faces.size(), 8u);
  ASSERT_EQ(sharp->fans.size(), 24u) << "each face on its own at each of its nodes";
  for (const SoftModel::Fan& fan : sharp->fans) {
    EXPECT_EQ(fan.count, 1u);
    const auto& [from, to] = sharp->fan_sides[fan.first];
    const Vector3f middle = sharp->node_places[fan.node] + sharp->node_places[from] + sharp->node_places[to];
    EXPECT_LT((fan.normal - middle.normalized()).norm(), 1e-6f) << "outward from the face";
  }
  ASSERT_EQ(round->fans.size(), 6u);
  for (std::uint32_t node = 0; node < 6; ++node) {
    EXPECT_EQ(round->fans[node].node, node);
    EXPECT_EQ(round->fans[node].count, 4u);
    EXPECT_LT((round->fans[node].normal - round->node_places[node].normalized()).norm(), 1e-6f);
  }
}

// N. Max 1999: exact if all nodes lie on a ball, for faces of any shapes.
TEST(SoftModel, TheNormalOfAFanIsThatOfTheBallOnWhichItsNodesLie) {
  const auto model = modelOf(kRound);
  test::Random random(1);
  for (int n = 0; n < 100; ++n) {
    const Vector3d middle = random.inCube(10);
    std::vector<Vector3f> places;
    for (const Vector3f& rest : model->node_places)
      places.push_back((middle + 3 * (rest.cast<double>().normalized() + random.inCube(0.4)).normalized()).cast<float>());
    for (const SoftModel::Fan& fan : model->fans) {
      const Vector3d outward = (places[fan.node].cast<double>() - middle).normalized();
      EXPECT_LT((normalOf(*model, fan, places).normalized().cast<double>() - outward).norm(), 1e-5);
    }
  }
}

// On a circle of radius R, the middle of an arc of angle a is R (1 - cos(a / 2)) from its chord.
TEST(SoftModel, TheBendOfAChordIsTheHeightOfItsArc) {
  for (const float angle : {0.2f, 0.5f, 1.0f}) {
    const Vector3f from(0, 0, 1), to(std::sin(angle), 0, std::cos(angle));
    const float height = 7 * (1 - std::cos(angle / 2));
    EXPECT_NEAR(bendOf(7 * (to - from), from, to), height, height * angle * angle / 12) << "the series differ by a share of angle^2 / 16";
    EXPECT_NEAR(bendOf(7 * (from - to), to, from), height, height * angle * angle / 12);
    EXPECT_LT(bendOf(7 * (from - to), from, to), 0) << "hollow";
  }
  EXPECT_EQ(bendOf({1, 2, 3}, {0, 0, 1}, {0, 0, 1}), 0);
}

TEST(SoftModel, APointYieldsByAtMostHalfOfItsWayToAFixedNode) {
  const auto model = modelOf(kRound);
  ASSERT_EQ(model->vertices.size(), 66u);
  for (const SoftModel::Vertex& vertex : model->vertices) {
    const Vector3f direction = vertex.rest.position.normalized();
    EXPECT_NEAR(vertex.max_give, 0.5f * 5 / direction.cwiseAbs().sum(), 1e-3f) << "the middle of the octahedron is fixed";
  }
}

TEST(SoftModel, VerticesTakeTheFansThatFaceLikeThem) {
  const auto sharp = modelOf(kSharp), round = modelOf(kRound);
  for (std::size_t v = 0; v < sharp->vertices.size(); ++v) {
    const SoftModel::Vertex &of_sharp = sharp->vertices[v], &of_round = round->vertices[v];
    for (std::size_t k = 0; k < 3; ++k) {
      const SoftModel::Fan& fan = sharp->fans[of_sharp.fans[k]];
      EXPECT_EQ(fan.node, of_sharp.point.node[k]);
      for (const SoftModel::Fan& other : sharp->fans) {
        if (other.node != fan.node) continue;
        EXPECT_GE(fan.normal.dot(of_sharp.rest.normal), other.normal.dot(of_sharp.rest.normal)) << v;
      }
      EXPECT_EQ(of_round.fans[k], of_round.point.node[k]);
      EXPECT_NEAR(of_round.sides[k].length, 5 * std::sqrt(2.0f), 1e-5f);
      EXPECT_NEAR(of_round.sides[k].bend, 5.0f / 4, 1e-5f) << "(5 sqrt 2) (sqrt 2) / 8";
    }
    Vector3f mean = Vector3f::Zero();
    for (std::size_t k = 0; k < 3; ++k) mean += of_round.point.weight[k] * round->node_places[of_round.point.node[k]].normalized();
    EXPECT_LT((of_round.normal - mean).norm(), 1e-5f);
  }
}

TEST(SoftModel, EdgesAreTheChordsBetweenTheirEnds) {
  const test::OctahedronTissue made = test::octahedronTissue(kRound);
  const auto model = softModel(made.tree, made.tissue);
  ASSERT_EQ(model->edges.size(), 192u);
  std::vector<int> uses(model->edges.size(), 0);
  for (const SkinTriangle& t : made.tree->skin.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& end = model->edges[t.edge[k]].end;
      const std::uint32_t a = t.vertex[k], b = t.vertex[(k + 1) % 3];
      EXPECT_TRUE((end[0] == a && end[1] == b) || (end[0] == b && end[1] == a));
      ++uses[t.edge[k]];
    }
  const auto placeOnFaces = [&](const PressPoint& point) {
    Vector3f sum = Vector3f::Zero();
    for (std::size_t k = 0; k < 3; ++k) sum += point.weight[k] * model->node_places[point.node[k]];
    return sum;
  };
  for (std::size_t e = 0; e < uses.size(); ++e) {
    const SoftModel::Edge& edge = model->edges[e];
    EXPECT_EQ(uses[e], 2);
    EXPECT_FALSE(edge.is_sharp);
    const SoftModel::Vertex &from = model->vertices[edge.end[0]], &to = model->vertices[edge.end[1]];
    EXPECT_EQ(edge.chord, to.rest.position - from.rest.position);
    EXPECT_FLOAT_EQ(edge.side.length, edge.chord.norm());
    EXPECT_NEAR(edge.side.bend, edge.side.length * edge.side.length / 40, 0.01f) << "on a ball of 5 mm";
    EXPECT_LT((edge.sag - placeOnFaces(edge.point) + 0.5f * (placeOnFaces(from.point) + placeOnFaces(to.point))).norm(), 1e-5f);
  }
}

// The node at -z is fixed.
TEST(SoftModel, WhatHangsOnAFixedNodeKeepsItsOwnNormal) {
  const auto model = modelOf(kRound, 5);
  EXPECT_EQ(model->node_count, 5u);
  ASSERT_EQ(model->node_places.size(), 6u) << "the fixed node is a corner of faces, too";
  EXPECT_EQ(model->node_places[5], Vector3f(0, 0, -5));
  EXPECT_EQ(model->fans.size(), 5u);
  int held = 0, all_held = 0;
  for (const SoftModel::Vertex& vertex : model->vertices) {
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(vertex.fans[k] == kNone, vertex.point.node[k] == kNone);
    if (vertex.point.node[2] != kNone || !(vertex.point.weight[2] > 1e-4f)) continue;
    ++held;
    if (vertex.point.weight[2] < 0.999f) {  // its way to a fixed node starts where its other nodes are
      Vector3f mean = Vector3f::Zero();
      for (std::size_t k = 0; k < 2; ++k) mean += vertex.point.weight[k] * model->node_places[vertex.point.node[k]];
      mean /= vertex.point.weight[0] + vertex.point.weight[1];
      EXPECT_NEAR(vertex.max_give, 0.5f * std::min(mean.norm(), (mean - model->node_places[5]).norm()), 1e-4f);
      continue;
    }
    ++all_held;
    EXPECT_EQ(vertex.max_give, 0);
    EXPECT_LT((vertex.normal - vertex.rest.normal).norm(), 1e-4f);
  }
  EXPECT_EQ(all_held, 1);
  EXPECT_EQ(held, 25) << "the vertices below the equator: 66, of which 16 lie on it";
}

TEST(SoftModel, ReadsTheComplianceByColumns) {
  const test::OctahedronTissue made = test::octahedronTissue(kRound);
  const auto model = softModel(made.tree, made.tissue);
  for (std::size_t node = 0; node < 6; ++node)
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(model->column(3 * node + axis), made.tissue->response.column(node, axis).data());
  EXPECT_EQ(model->tissue, made.tissue);
  EXPECT_GT(model->bytes, 66 * sizeof(SoftModel::Vertex) + 192 * sizeof(SoftModel::Edge));
}

}  // namespace
}  // namespace spheretree::runtime
