// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenario_shapes.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>

#include "molar.h"
#include "probe.h"

namespace spheretree::player {
namespace {

using Profile = std::vector<Eigen::Vector2d>;

/// Adds an arc about (0, z) from angle `from` to `to`, measured from -z, in `steps` steps; end points on the axis are exact.
void addArc(Profile& profile, double radius, double z, double from, double to, int steps) {
  for (int i = 0; i <= steps; ++i) {
    const double a = from + (to - from) * i / steps, r = radius * std::sin(a);
    profile.emplace_back(std::abs(r) < 1e-12 ? 0 : r, z - radius * std::cos(a));
  }
}

/// Cuts segments off the axis into pieces of at most `longest`: the builder is slow on long slivers.
Profile cut(const Profile& profile, double longest) {
  Profile out{profile.front()};
  for (std::size_t i = 1; i < profile.size(); ++i) {
    const Eigen::Vector2d &a = profile[i - 1], &b = profile[i];
    const int pieces = a.x() > 0 && b.x() > 0 ? static_cast<int>(std::ceil((b - a).norm() / longest)) : 1;
    for (int k = 1; k <= pieces; ++k) out.push_back(k == pieces ? b : a + (b - a) * (double(k) / pieces));
  }
  return out;
}

double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

/// Ear clipping of a simple counter-clockwise polygon.
std::vector<Triangle> triangulate(const Profile& polygon) {
  std::vector<std::uint32_t> left;
  for (std::uint32_t i = 0; i < polygon.size(); ++i) left.push_back(i);
  std::vector<Triangle> triangles;
  while (left.size() > 2) {
    const std::size_t before = left.size();
    for (std::size_t i = 0; i < left.size(); ++i) {
      const std::uint32_t a = left[(i + left.size() - 1) % left.size()], b = left[i], c = left[(i + 1) % left.size()];
      if (turn(polygon[a], polygon[b], polygon[c]) <= 0) continue;
      bool is_ear = true;
      for (const std::uint32_t p : left)
        is_ear = is_ear && (p == a || p == b || p == c || turn(polygon[a], polygon[b], polygon[p]) < 0 ||
                            turn(polygon[b], polygon[c], polygon[p]) < 0 || turn(polygon[c], polygon[a], polygon[p]) < 0);
      if (!is_ear) continue;
      triangles.push_back({a, b, c});
      left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
      break;
    }
    if (left.size() == before) throw std::invalid_argument("the polygon is not simple or not counter-clockwise");
  }
  return triangles;
}

TriangleMesh capsule(double radius, double length) {  // tip at the origin, axis +z
  constexpr int kSteps = 5;
  Profile profile;
  addArc(profile, radius, radius, 0, std::numbers::pi / 2, kSteps);
  addArc(profile, radius, length - radius, std::numbers::pi / 2, std::numbers::pi, kSteps);
  return lathe(cut(profile, 2 * radius), 20);
}

TriangleMesh ball(double radius) {
  Profile profile;
  addArc(profile, radius, 0, 0, std::numbers::pi, 32);
  return lathe(profile, 64);
}

TriangleMesh cylinder(double radius, double low, double high, std::uint32_t around) {
  return lathe(cut({{0, low}, {radius, low}, {radius, high}, {0, high}}, 2 * radius), around);
}

TriangleMesh bowl() {  // a ball of radius 15 taken out of a cylinder, rim at z = 0, floor at z = -8
  Profile profile{{0, -12}, {16, -12}, {16, 0}};
  const double open = std::acos(7.0 / 15);  // the rim stands at this angle from the lowest point
  addArc(profile, 15, 7, open, 0, 24);
  return lathe(profile, 96);
}

struct Recipe {
  std::function<TriangleMesh()> mesh;
  int levels = 4;
  double tolerance = 0;
};

const std::map<std::string, Recipe>& recipes() {
  static const std::map<std::string, Recipe> all{
      // Tools.
      {"ball", {[] { return ball(5); }, 2, 0.05}},
      {"small_ball", {[] { return ball(1); }, 2, 0.05}},
      {"probe", {[] { return capsule(1, 100); }}},
      {"fine_probe", {[] { return capsule(0.3, 40); }}},
      {"cube", {[] {
         return box({-10, -10, -10}, {10, 10, 10});
       }}},
      {"cylinder", {[] { return cylinder(5, -30, 30, 32); }}},
      {"dental_probe", {[] { return samples::makeProbe(); }}},
      // Objects; surfaces at z = 0 unless said.
      {"slab", {[] {
         return box({-50, -50, -10}, {50, 50, 0});
       }}},
      {"block", {[] {
         return box({-30, -30, -60}, {30, 30, 0});
       }}},
      {"plate_2", {[] {
         return box({-20, -20, -1}, {20, 20, 1});
       }}},  // middle at z = 0
      {"plate_1", {[] {
         return box({-20, -20, -0.5}, {20, 20, 0.5});
       }}},
      {"plate_0.5", {[] {
         return box({-20, -20, -0.25}, {20, 20, 0.25});
       }}},
      {"plate_0.2", {[] {
         return box({-20, -20, -0.1}, {20, 20, 0.1});
       }}},
      {"wire", {[] { return cylinder(0.25, -20, 20, 16); }}},  // about the z axis
      {"groove", {[] {                                         // 60 degrees, 10 deep, along y, bottom at the origin
         const double half = 10 * std::tan(std::numbers::pi / 6);
         return extrude({{-10, -4}, {10, -4}, {10, 10}, {half, 10}, {0, 0}, {-half, 10}, {-10, 10}}, 20);
       }}},
      {"sulcus", {[] {  // two walls 1.5 apart, 4 deep, along y
         return extrude({{-6, -8}, {6, -8}, {6, 0}, {0.75, 0}, {0.75, -4}, {-0.75, -4}, {-0.75, 0}, {-6, 0}}, 10);
       }}},
      {"ridge", {[] {
         return extrude({{-8, -8}, {8, -8}, {0, 0}}, 20);
       }}},  // 90 degrees, crest at the origin
      {"corner", {[] {
         return extrude({{-4, -4}, {20, -4}, {20, 0}, {0, 0}, {0, 20}, {-4, 20}}, 24);
       }}},  // opens to +x, +z
      {"blind_hole", {[] {
         return lathe(cut({{0, -9}, {4, -9}, {4, 0}, {1.2, 0}, {1.2, -5}, {0, -5}}, 0.8), 32);
       }}},
      {"bowl", {bowl}},
      {"wall", {[] {
         return box({-4, -15, -35}, {0, 15, 35});
       }}},  // face at x = 0
      {"molar", {[] { return samples::makeMolar(); }}},
  };
  return all;
}

}  // namespace

TriangleMesh lathe(const Profile& profile, std::uint32_t around) {
  TriangleMesh mesh;
  const auto rings = static_cast<std::uint32_t>(profile.size() - 2);
  mesh.positions.emplace_back(0, 0, profile.front().y());
  for (std::uint32_t ring = 1; ring <= rings; ++ring)
    for (std::uint32_t k = 0; k < around; ++k) {
      const double a = 2 * std::numbers::pi * k / around;
      mesh.positions.emplace_back(profile[ring].x() * std::cos(a), profile[ring].x() * std::sin(a), profile[ring].y());
    }
  mesh.positions.emplace_back(0, 0, profile.back().y());
  const auto at = [&](std::uint32_t ring, std::uint32_t k) { return 1 + (ring - 1) * around + k % around; };
  const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
  for (std::uint32_t k = 0; k < around; ++k) {
    mesh.triangles.push_back({0, at(1, k + 1), at(1, k)});
    for (std::uint32_t ring = 1; ring < rings; ++ring) {
      mesh.triangles.push_back({at(ring, k), at(ring, k + 1), at(ring + 1, k + 1)});
      mesh.triangles.push_back({at(ring, k), at(ring + 1, k + 1), at(ring + 1, k)});
    }
    mesh.triangles.push_back({last, at(rings, k), at(rings, k + 1)});
  }
  return mesh;
}

TriangleMesh extrude(const Profile& polygon, double length) {
  TriangleMesh mesh;
  const auto count = static_cast<std::uint32_t>(polygon.size());
  for (const double y : {-length / 2, length / 2})
    for (const Eigen::Vector2d& p : polygon) mesh.positions.emplace_back(p.x(), y, p.y());
  for (const auto& [a, b, c] : triangulate(polygon)) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a + count, c + count, b + count});
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t next = (i + 1) % count;
    mesh.triangles.push_back({i, i + count, next + count});
    mesh.triangles.push_back({i, next + count, next});
  }
  return mesh;
}

TriangleMesh box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  TriangleMesh mesh = extrude({{low.x(), low.z()}, {high.x(), low.z()}, {high.x(), high.z()}, {low.x(), high.z()}}, high.y() - low.y());
  for (Eigen::Vector3d& p : mesh.positions) p.y() += (low.y() + high.y()) / 2;
  return mesh;
}

const Body& BodyLibrary::get(const std::string& name) {
  if (const auto found = bodies_.find(name); found != bodies_.end()) return *found->second;
  const auto recipe = recipes().find(name);
  if (recipe == recipes().end()) throw std::invalid_argument("no body is called " + name);
  builder::BuildSettings settings;
  settings.levels = recipe->second.levels;
  settings.tolerance_mm = recipe->second.tolerance;
  settings.quality = quality_;
  TriangleMesh mesh = recipe->second.mesh();
  SphereTree tree = builder::buildSphereTree(mesh, settings, progress_).tree;
  builder::DistanceField field(mesh);
  return *bodies_.emplace(name, new Body{name, std::move(mesh), std::move(tree), std::move(field), bridges_}).first->second;
}

}  // namespace spheretree::player
