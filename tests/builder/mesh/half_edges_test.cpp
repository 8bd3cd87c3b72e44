// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/half_edges.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

HalfEdges halfEdgesOf(const TriangleMesh& mesh) { return {mesh.triangles, mesh.positions.size()}; }

// Vertices minus edges plus triangles, and the number of sides without a second triangle.
std::pair<long, std::size_t> topologyOf(const std::vector<Triangle>& triangles) {
  std::set<std::uint32_t> vertices;
  std::set<std::pair<std::uint32_t, std::uint32_t>> sides;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) vertices.insert(t[k]), sides.insert({t[k], t[(k + 1) % 3]});
  std::size_t alone = 0;
  for (const auto& [a, b] : sides) alone += !sides.contains({b, a});
  return {static_cast<long>(vertices.size() + triangles.size()) - static_cast<long>((sides.size() + alone) / 2), alone};
}

TEST(HalfEdges, KnowsTheNeighboursOfEachVertex) {
  TriangleMesh open = test::torusMesh(10, 3, 12, 9);
  open.triangles.erase(open.triangles.begin() + 20, open.triangles.begin() + 22);
  const HalfEdges edges = halfEdgesOf(open);
  for (std::uint32_t v = 0; v < open.positions.size(); ++v) {
    std::set<std::uint32_t> expected, found;
    for (const Triangle& t : open.triangles)
      if (std::find(t.begin(), t.end(), v) != t.end()) expected.insert(t.begin(), t.end());
    expected.erase(v);
    std::size_t count = 0;
    edges.visitFrom(v, [&](std::uint32_t h) { found.insert(edges.to(h)), ++count; });
    EXPECT_EQ(found, expected);
    EXPECT_EQ(count, expected.size()) << "each once";
  }
}

TEST(HalfEdges, CollapsesKeepTheTopology) {
  TriangleMesh open = test::torusMesh(10, 3, 20, 15);
  open.triangles.erase(open.triangles.begin() + 100, open.triangles.begin() + 102);
  for (const TriangleMesh& mesh : {test::sphereMesh(1, 3), test::torusMesh(10, 3, 20, 15), open}) {
    HalfEdges edges = halfEdgesOf(mesh);
    test::Random random(7);
    std::size_t left = mesh.triangles.size();
    for (int tries = 0; tries < 20000; ++tries) {
      const auto h = static_cast<std::uint32_t>(random.below(edges.count()));
      if (edges.isRemoved(h) || edges.isBorder(edges.from(h)) || !edges.canCollapse(h)) continue;
      if (edges.triangles().size() <= 8) break;
      const std::uint32_t gone = edges.from(h);
      edges.collapse(h);
      EXPECT_TRUE(edges.isIsolated(gone));
      left -= 2;
    }
    const std::vector<Triangle> triangles = edges.triangles();
    EXPECT_EQ(triangles.size(), left);
    EXPECT_LT(left, mesh.triangles.size() / 8);
    EXPECT_EQ(topologyOf(triangles), topologyOf(mesh.triangles));
    EXPECT_NO_THROW(HalfEdges(triangles, mesh.positions.size()));
  }
}

// Collapses whose vertices have no neighbour in common do not touch each other: order and threads change nothing.
TEST(HalfEdges, CollapsesApartFromEachOtherAreIndependent) {
  for (const TriangleMesh& mesh : {test::sphereMesh(1, 3), test::torusMesh(10, 3, 20, 15)}) {
    HalfEdges forward = halfEdgesOf(mesh), backward = forward, parallel = forward;
    std::set<std::uint32_t> claimed;
    std::vector<std::uint32_t> chosen;
    for (std::uint32_t h = 0; h < forward.count(); h += 7) {
      std::set<std::uint32_t> around{forward.from(h)};
      forward.visitFrom(forward.from(h), [&](std::uint32_t out) { around.insert(forward.to(out)); });
      if (!forward.canCollapse(h) || std::ranges::any_of(around, [&](std::uint32_t v) { return claimed.contains(v); })) continue;
      claimed.merge(around);
      chosen.push_back(h);
    }
    EXPECT_GT(chosen.size(), mesh.positions.size() / 30);
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      EXPECT_TRUE(forward.canCollapse(chosen[i])) << "also after the others";
      forward.collapse(chosen[i]);
      backward.collapse(chosen[chosen.size() - 1 - i]);
    }
    tbb::parallel_for(std::size_t{0}, chosen.size(), [&](std::size_t i) { parallel.collapse(chosen[i]); });
    EXPECT_EQ(backward.triangles(), forward.triangles());
    EXPECT_EQ(parallel.triangles(), forward.triangles());
    EXPECT_EQ(topologyOf(forward.triangles()), topologyOf(mesh.triangles));
    EXPECT_NO_THROW(HalfEdges(forward.triangles(), mesh.positions.size()));
  }
}

TEST(HalfEdges, DoesNotFlattenATetrahedron) {
  TriangleMesh solid;
  solid.positions.resize(4);
  solid.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
  const HalfEdges edges = halfEdgesOf(solid);
  for (std::uint32_t h = 0; h < edges.count(); ++h) EXPECT_FALSE(edges.canCollapse(h));
}

TEST(HalfEdges, DoesNotCloseATube) {
  TriangleMesh tube = test::torusMesh(10, 3, 12, 3);  // three vertices around
  const HalfEdges edges = halfEdgesOf(tube);
  for (std::uint32_t h = 0; h < edges.count(); ++h)
    EXPECT_FALSE(edges.from(h) / 3 == edges.to(h) / 3 && edges.canCollapse(h)) << "around the tube";
}

TEST(HalfEdges, RefusesWhatIsNotManifold) {
  const TriangleMesh box = test::boxMesh({0, 0, 0}, {1, 1, 1});
  TriangleMesh fin = box, turned = box, repeated = box, touching = box;
  fin.triangles.push_back({0, 3, 6});
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  repeated.triangles[0][1] = repeated.triangles[0][0];
  for (const Triangle& t : box.triangles) {
    Triangle second = t;
    for (std::uint32_t& v : second) v = v == 0 ? 0 : v + 7;
    touching.triangles.push_back(second);
  }
  touching.positions.resize(15);
  for (const TriangleMesh& mesh : {fin, turned, repeated, touching}) EXPECT_THROW(halfEdgesOf(mesh), std::invalid_argument);
}

}  // namespace
}  // namespace spheretree::builder
