// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/tetrahedra.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "geometry/winding_number.h"
#include "spheretree/builder/build_settings.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kVolumeError = 1e-6;  // relative error of a volume; the rounding errors of sums of products are far smaller
// A tetrahedron with less than this share of the volume of a cube of its longest edge is flat: it would cost the
// stiffness matrix 12 of its 16 digits.
constexpr double kMinShape = 1e-9;

struct Side {
  std::array<std::uint32_t, 3> key;  // its nodes in ascending order
  std::uint32_t tetrahedron;
  std::uint8_t opposite;
};

std::vector<Side> sortedSides(const Tetrahedra& solid) {
  std::vector<Side> sides;
  sides.reserve(4 * solid.corners.size());
  for (std::uint32_t t = 0; t < solid.corners.size(); ++t)
    for (std::uint8_t k = 0; k < 4; ++k) {
      Side side{{}, t, k};
      for (std::size_t i = 0; i < 3; ++i) side.key[i] = solid.corners[t][kTetrahedronFaces[k][i]];
      std::sort(side.key.begin(), side.key.end());
      sides.push_back(side);
    }
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return a.key != b.key ? a.key < b.key : a.tetrahedron < b.tetrahedron; });
  return sides;
}

double signedVolume(const TriangleMesh& surface) {
  double volume6 = 0;
  const Vector3d about = surface.positions.front();
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    volume6 += (surface.corner(t, 0) - about).cross(surface.corner(t, 1) - about).dot(surface.corner(t, 2) - about);
  return volume6 / 6;
}

// The usable tetrahedra of `found`, oriented to positive volume, in their order.
Tetrahedra turned(const Tetrahedra& found) {
  for (std::size_t i = 0; i < found.nodes.size(); ++i)
    if (!found.nodes[i].allFinite()) throw BuildError("tetrahedra: node " + std::to_string(i) + " is not finite");
  Tetrahedra solid = found;
  for (std::size_t t = 0; t < solid.corners.size(); ++t) {
    std::array<std::uint32_t, 4>& c = solid.corners[t];
    if (std::any_of(c.begin(), c.end(), [&](std::uint32_t node) { return node >= solid.nodes.size(); }))
      throw BuildError("tetrahedra: tetrahedron " + std::to_string(t) + " names a node that does not exist");
    if (volumeOf(solid, t) < 0) std::swap(c[2], c[3]);
  }
  return solid;
}

bool isFlat(const Tetrahedra& solid, std::size_t t) {
  const std::array<std::uint32_t, 4>& c = solid.corners[t];
  double longest = 0;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = a + 1; b < 4; ++b) longest = std::max(longest, (solid.nodes[c[a]] - solid.nodes[c[b]]).norm());
  return !(volumeOf(solid, t) > kMinShape * longest * longest * longest);
}

// Four coplanar vertices of the surface can make a flat tetrahedron along it. Without it the surface is the same up to
// rounding; the other sides of that tetrahedron become its triangles.
void dropFlatAlongSurface(Tetrahedra& solid) {
  for (;;) {
    std::vector<char> flat(solid.corners.size()), drop(flat.size(), 0);
    for (std::size_t t = 0; t < flat.size(); ++t) flat[t] = isFlat(solid, t);
    const auto first = std::find(flat.begin(), flat.end(), 1);
    if (first == flat.end()) return;
    const std::vector<Side> sides = sortedSides(solid);
    for (std::size_t i = 0; i < sides.size(); ++i) {
      const bool is_shared = (i > 0 && sides[i - 1].key == sides[i].key) || (i + 1 < sides.size() && sides[i + 1].key == sides[i].key);
      if (!is_shared) drop[sides[i].tetrahedron] = flat[sides[i].tetrahedron];
    }
    if (std::find(drop.begin(), drop.end(), 1) == drop.end())
      throw BuildError("tetrahedra: tetrahedron " + std::to_string(first - flat.begin()) + ", inside the surface, is flat");
    std::size_t kept = 0;
    for (std::size_t t = 0; t < drop.size(); ++t)
      if (!drop[t]) solid.corners[kept++] = solid.corners[t];
    solid.corners.resize(kept);
  }
}

void dropUnusedNodes(Tetrahedra& solid) {
  std::vector<std::uint32_t> now(solid.nodes.size(), kNone);
  for (const auto& corners : solid.corners)
    for (const std::uint32_t node : corners) now[node] = 0;
  std::uint32_t kept = 0;
  for (std::size_t i = 0; i < now.size(); ++i)
    if (now[i] != kNone) solid.nodes[kept] = solid.nodes[i], now[i] = kept++;
  solid.nodes.resize(kept);
  for (auto& corners : solid.corners)
    for (std::uint32_t& node : corners) node = now[node];
}

}  // namespace

double volumeOf(const Tetrahedra& solid, std::size_t tetrahedron) {
  const auto& c = solid.corners[tetrahedron];
  const Vector3d& a = solid.nodes[c[0]];
  return (solid.nodes[c[1]] - a).cross(solid.nodes[c[2]] - a).dot(solid.nodes[c[3]] - a) / 6;
}

double volumeOf(const Tetrahedra& solid) {
  double sum = 0;
  for (std::size_t t = 0; t < solid.corners.size(); ++t) sum += volumeOf(solid, t);
  return sum;
}

Tetrahedra solidOf(const Tetrahedra& found, const TriangleMesh& surface) {
  Tetrahedra solid = turned(found);
  const WindingNumber winding(surface);
  std::erase_if(solid.corners, [&](const std::array<std::uint32_t, 4>& c) {
    return winding.at((solid.nodes[c[0]] + solid.nodes[c[1]] + solid.nodes[c[2]] + solid.nodes[c[3]]) / 4) < 0.5;
  });
  dropFlatAlongSurface(solid);
  dropUnusedNodes(solid);
  const double volume = volumeOf(solid), wanted = signedVolume(surface);
  if (!(std::abs(volume - wanted) <= kVolumeError * wanted))
    throw BuildError("tetrahedra: they fill " + std::to_string(volume) + " mm^3, and the surface encloses " + std::to_string(wanted) +
                     " mm^3");
  const std::vector<Side> sides = sortedSides(solid);
  for (std::size_t i = 2; i < sides.size(); ++i)
    if (sides[i].key == sides[i - 2].key) throw BuildError("tetrahedra: three of them meet in one face");
  return solid;
}

TriangleMesh boundaryOf(const Tetrahedra& solid, std::vector<std::uint32_t>* owner) {
  std::vector<Side> sides = sortedSides(solid), outer;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const bool is_shared = (i > 0 && sides[i - 1].key == sides[i].key) || (i + 1 < sides.size() && sides[i + 1].key == sides[i].key);
    if (!is_shared) outer.push_back(sides[i]);
  }
  std::sort(outer.begin(), outer.end(), [](const Side& a, const Side& b) {
    return a.tetrahedron != b.tetrahedron ? a.tetrahedron < b.tetrahedron : a.opposite < b.opposite;
  });
  TriangleMesh boundary;
  boundary.positions = solid.nodes;
  if (owner) owner->clear();
  for (const Side& side : outer) {
    const auto& c = solid.corners[side.tetrahedron];
    const auto& k = kTetrahedronFaces[side.opposite];
    boundary.triangles.push_back({c[k[0]], c[k[1]], c[k[2]]});
    if (owner) owner->push_back(side.tetrahedron);
  }
  return boundary;
}

}  // namespace spheretree::builder
