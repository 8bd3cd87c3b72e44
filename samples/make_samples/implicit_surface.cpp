// SPDX-License-Identifier: Apache-2.0
#include "implicit_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace spheretree::samples {
namespace {

using Eigen::Vector3d;
constexpr std::uint32_t kNoVertex = 0xffffffffu;

Vector3d gradient(const Field& field, const Vector3d& p) {
  constexpr double kStep = 1e-4;  // [mm]
  Vector3d slope;
  for (int axis = 0; axis < 3; ++axis) {
    Vector3d forward = p, backward = p;
    forward[axis] += kStep;
    backward[axis] -= kStep;
    const double ahead = field(forward);
    slope[axis] = (ahead - field(backward)) / (2 * kStep);
  }
  return slope;
}

// Newton's method along the gradient; a step is at most `longest`, since the field approximates a distance only near
// its zero set.
Vector3d projectToSurface(const Field& field, Vector3d p, double longest) {
  for (int i = 0; i < 6; ++i) {
    const double value = field(p);
    const Vector3d slope = gradient(field, p);
    Vector3d step = slope * (-value / std::max(slope.squaredNorm(), 1e-6));
    const double length = step.norm();
    if (length > longest) step *= longest / length;
    p += step;
  }
  return p;
}

Vector3d areaVector(const TriangleMesh& mesh, const Triangle& t) {
  return (mesh.positions[t[1]] - mesh.positions[t[0]]).cross(mesh.positions[t[2]] - mesh.positions[t[0]]) / 2;
}

class Net {
 public:
  Net(const Field& field, const Vector3d& low, const Vector3d& high, double cell) : low_(low), cell_(cell) {
    for (int axis = 0; axis < 3; ++axis) cells_[axis] = static_cast<int>(std::ceil((high[axis] - low[axis]) / cell));
    values_.reserve(corners());
    for (int z = 0; z <= cells_[2]; ++z) {
      for (int y = 0; y <= cells_[1]; ++y) {
        for (int x = 0; x <= cells_[0]; ++x) {
          values_.push_back(field(corner(x, y, z)));
          const bool at_face = x == 0 || y == 0 || z == 0 || x == cells_[0] || y == cells_[1] || z == cells_[2];
          if (at_face && values_.back() < 0) throw std::invalid_argument("polygonise: the solid reaches out of its box.");
        }
      }
    }
  }

  TriangleMesh mesh() {
    placeVertices();
    for (int z = 0; z < cells_[2]; ++z) {
      for (int y = 0; y < cells_[1]; ++y) {
        for (int x = 0; x < cells_[0]; ++x) addFaces({x, y, z});
      }
    }
    return std::move(mesh_);
  }

 private:
  std::size_t corners() const {
    return static_cast<std::size_t>(cells_[0] + 1) * static_cast<std::size_t>(cells_[1] + 1) * static_cast<std::size_t>(cells_[2] + 1);
  }
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(cells_[1] + 1) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(cells_[0] + 1) +
           static_cast<std::size_t>(x);
  }
  Vector3d corner(int x, int y, int z) const { return low_ + cell_ * Vector3d(x, y, z); }
  double value(int x, int y, int z) const { return values_[index(x, y, z)]; }

  // One vertex in each cell that the surface crosses: the mean of the crossings of the cell's edges.
  void placeVertices() {
    vertex_of_cell_.assign(corners(), kNoVertex);
    for (int z = 0; z < cells_[2]; ++z) {
      for (int y = 0; y < cells_[1]; ++y) {
        for (int x = 0; x < cells_[0]; ++x) {
          Vector3d sum = Vector3d::Zero();
          int crossings = 0;
          for (int axis = 0; axis < 3; ++axis) {
            for (int side = 0; side < 4; ++side) {
              std::array<int, 3> a{x, y, z};
              a[static_cast<std::size_t>((axis + 1) % 3)] += side & 1;
              a[static_cast<std::size_t>((axis + 2) % 3)] += side >> 1;
              std::array<int, 3> b = a;
              ++b[static_cast<std::size_t>(axis)];
              const double at_a = value(a[0], a[1], a[2]), at_b = value(b[0], b[1], b[2]);
              if ((at_a < 0) == (at_b < 0)) continue;
              Vector3d crossing = corner(a[0], a[1], a[2]);
              crossing[axis] += cell_ * (at_a / (at_a - at_b));
              sum += crossing;
              ++crossings;
            }
          }
          if (crossings == 0) continue;
          vertex_of_cell_[index(x, y, z)] = static_cast<std::uint32_t>(mesh_.positions.size());
          mesh_.positions.push_back(sum / crossings);
        }
      }
    }
  }

  // Two triangles for each crossed edge that starts at this corner: the four cells around the edge, cut along the
  // shorter diagonal.
  void addFaces(const std::array<int, 3>& at) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      if (at[u] == 0 || at[v] == 0) continue;
      std::array<int, 3> end = at;
      ++end[axis];
      const bool inside = value(at[0], at[1], at[2]) < 0;
      if (inside == (value(end[0], end[1], end[2]) < 0)) continue;
      std::array<std::uint32_t, 4> quad;
      for (std::size_t k = 0; k < 4; ++k) {
        std::array<int, 3> cell = at;
        cell[u] -= k == 1 || k == 2 ? 0 : 1;
        cell[v] -= k >= 2 ? 0 : 1;
        quad[k] = vertex_of_cell_[index(cell[0], cell[1], cell[2])];
      }
      if (!inside) std::swap(quad[1], quad[3]);
      const auto& p = mesh_.positions;
      if ((p[quad[0]] - p[quad[2]]).squaredNorm() <= (p[quad[1]] - p[quad[3]]).squaredNorm()) {
        mesh_.triangles.push_back({quad[0], quad[1], quad[2]});
        mesh_.triangles.push_back({quad[0], quad[2], quad[3]});
      } else {
        mesh_.triangles.push_back({quad[1], quad[2], quad[3]});
        mesh_.triangles.push_back({quad[1], quad[3], quad[0]});
      }
    }
  }

  Vector3d low_;
  double cell_;
  std::array<int, 3> cells_{};
  std::vector<double> values_;
  std::vector<std::uint32_t> vertex_of_cell_;
  TriangleMesh mesh_;
};

// Cosine of the angle at `apex` of the triangle (apex, a, b).
double cosineAt(const Vector3d& apex, const Vector3d& a, const Vector3d& b) {
  const Vector3d u = a - apex, v = b - apex;
  return u.dot(v) / std::sqrt(std::max(u.squaredNorm() * v.squaredNorm(), 1e-30));
}

/// The triangles at directed edges.
class EdgeTable {
 public:
  struct Edge {
    std::uint32_t end, triangle;
    auto operator<=>(const Edge&) const = default;
  };

  explicit EdgeTable(const TriangleMesh& mesh) : first_(mesh.positions.size() + 1, 0), edges_(3 * mesh.triangles.size()) {
    for (const Triangle& t : mesh.triangles)
      for (const std::uint32_t v : t) ++first_[v + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<std::uint32_t> next(first_);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) edges_[next[mesh.triangles[t][k]]++] = {mesh.triangles[t][(k + 1) % 3], t};
    for (std::size_t v = 0; v + 1 < first_.size(); ++v) std::sort(edges_.begin() + first_[v], edges_.begin() + first_[v + 1]);
  }
  std::span<const Edge> leaving(std::uint32_t v) const { return std::span(edges_).subspan(first_[v], first_[v + 1] - first_[v]); }
  /// Nothing for an edge that the mesh does not have.
  std::optional<std::uint32_t> triangleAt(std::uint32_t from, std::uint32_t to) const {
    for (const Edge& edge : leaving(from))
      if (edge.end == to) return edge.triangle;
    return std::nullopt;
  }

 private:
  std::vector<std::uint32_t> first_;  // (vertex) where its edges begin in edges_
  std::vector<Edge> edges_;           // by the vertex that they leave
};

// Flips every edge whose opposite angles sum to more than 180 degrees, unless that folds the surface or duplicates an
// edge.
void flipToDelaunay(TriangleMesh& mesh) {
  for (int round = 0; round < 3; ++round) {
    const EdgeTable edges(mesh);
    std::set<std::pair<std::uint32_t, std::uint32_t>> added;
    const auto exists = [&](std::uint32_t u, std::uint32_t v) { return edges.triangleAt(u, v) || added.contains(std::minmax(u, v)); };
    std::vector<bool> touched(mesh.triangles.size(), false);
    for (std::uint32_t a = 0; a < mesh.positions.size(); ++a) {
      for (const EdgeTable::Edge& edge : edges.leaving(a)) {
        const std::uint32_t b = edge.end, left = edge.triangle;
        const std::optional<std::uint32_t> beyond = a < b ? edges.triangleAt(b, a) : std::nullopt;
        if (!beyond) continue;
        const std::uint32_t right = *beyond;
        if (touched[left] || touched[right]) continue;
        const auto opposite = [&](std::uint32_t t) {
          for (const std::uint32_t v : mesh.triangles[t]) {
            if (v != a && v != b) return v;
          }
          return kNoVertex;
        };
        const std::uint32_t c = opposite(left), d = opposite(right);
        const auto& p = mesh.positions;
        if (cosineAt(p[c], p[a], p[b]) + cosineAt(p[d], p[a], p[b]) > -1e-9) continue;
        if (exists(c, d) || exists(d, c)) continue;
        const Vector3d before = areaVector(mesh, mesh.triangles[left]) + areaVector(mesh, mesh.triangles[right]);
        const Triangle first{a, d, c}, second{d, b, c};
        const Vector3d n1 = areaVector(mesh, first), n2 = areaVector(mesh, second);
        if (n1.dot(before) < 0.5 * n1.norm() * before.norm() || n2.dot(before) < 0.5 * n2.norm() * before.norm()) continue;
        mesh.triangles[left] = first;
        mesh.triangles[right] = second;
        touched[left] = touched[right] = true;
        added.insert(std::minmax(c, d));
      }
    }
  }
}

// Moves each vertex towards the area-weighted mean of its neighbourhood, within its tangent plane, and back to the
// surface.
void relax(TriangleMesh& mesh, const Field& field, double cell) {
  std::vector<Vector3d> sum(mesh.positions.size(), Vector3d::Zero());
  std::vector<double> weight(mesh.positions.size(), 0);
  for (const Triangle& t : mesh.triangles) {
    const double area = areaVector(mesh, t).norm();
    const Vector3d centre = (mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3;
    for (const std::uint32_t v : t) {
      sum[v] += area * centre;
      weight[v] += area;
    }
  }
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (weight[v] <= 0) continue;
    Vector3d& p = mesh.positions[v];
    Vector3d move = sum[v] / weight[v] - p;
    const Vector3d slope = gradient(field, p);
    move -= slope * (slope.dot(move) / std::max(slope.squaredNorm(), 1e-6));
    p = projectToSurface(field, p + 0.7 * move, 0.25 * cell);
  }
}

}  // namespace

double smoothMax(double a, double b, double width) {
  const double blend = std::max(width - std::abs(a - b), 0.0);
  return std::max(a, b) + blend * blend / (4 * width);
}

double smoothMin(double a, double b, double width) { return -smoothMax(-a, -b, width); }

double smoothStep(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

TriangleMesh polygonise(const Field& field, const Vector3d& low, const Vector3d& high, double cell) {
  TriangleMesh mesh = Net(field, low, high, cell).mesh();
  for (Vector3d& p : mesh.positions) p = projectToSurface(field, p, 0.25 * cell);
  for (int round = 0; round < 12; ++round) {
    flipToDelaunay(mesh);
    relax(mesh, field, cell);
  }
  return mesh;
}

}  // namespace spheretree::samples
