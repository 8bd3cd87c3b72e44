// SPDX-License-Identifier: GPL-3.0-or-later
#include "bodies/scenario_shapes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <stdexcept>

#include "cavity.h"
#include "molar.h"
#include "mouth.h"
#include "probe.h"
#include "spheretree/builder/graded_tolerance.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::player {
namespace {

using Profile = std::vector<Eigen::Vector2d>;

/// Adds an arc about (0, z) from angle `from` to `to`, measured from -z, in `steps` steps; end points on the axis are
/// exact.
void addArc(Profile& profile, double radius, double z, double from, double to, int steps) {
  for (int i = 0; i <= steps; ++i) {
    const double a = from + (to - from) * i / steps, r = radius * std::sin(a);
    profile.emplace_back(std::abs(r) < 1e-12 ? 0 : r, z - radius * std::cos(a));
  }
}

/// Divides segments away from the axis into pieces of at most `longest`, since the builder is slow on long slivers.
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

TriangleMesh capsule(double radius, double length, std::uint32_t around = 20, int steps = 5) {  // tip at the origin, axis +z
  Profile profile;
  addArc(profile, radius, radius, 0, std::numbers::pi / 2, steps);
  addArc(profile, radius, length - radius, std::numbers::pi / 2, std::numbers::pi, steps);
  return lathe(cut(profile, 2 * radius), around);
}

TriangleMesh ball(double radius) {
  Profile profile;
  addArc(profile, radius, 0, 0, std::numbers::pi, 32);
  return lathe(profile, 64);
}

TriangleMesh cylinder(double radius, double low, double high, std::uint32_t around) {
  return lathe(cut({{0, low}, {radius, low}, {radius, high}, {0, high}}, 2 * radius), around);
}

TriangleMesh bowl() {  // a ball of radius 15 subtracted from a cylinder, rim at z = 0, floor at z = -8
  Profile profile{{0, -12}, {16, -12}, {16, 0}};
  const double open = std::acos(7.0 / 15);  // angle of the rim from the lowest point
  addArc(profile, 15, 7, open, 0, 24);
  return lathe(profile, 96);
}

/// A block with a blind hole of diameter 10.2, 5 deep, chamfered at its rim at z = 0.
TriangleMesh bore() { return lathe({{0, -10}, {12, -10}, {12, 0}, {5.6, 0}, {5.1, -0.5}, {5.1, -5}, {0, -5}}, 64); }

/// Only the inside of the hole has to be accurate.
std::vector<double> boreTolerances(const TriangleMesh& mesh) {
  std::vector<double> tolerances;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    bool inside = true;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& p = mesh.corner(t, k);
      inside = inside && p.head<2>().norm() > 5 && p.head<2>().norm() < 5.7 && p.z() > -5.1;
    }
    tolerances.push_back(inside ? 0.05 : 0.6);
  }
  return tolerances;
}

/// A box in which a body has to be accurate to `tolerance`, its tolerance elsewhere, and the longest side of triangles
/// in the box [mm].
struct Work {
  Eigen::AlignedBox3d box;
  double tolerance, elsewhere, side;
};

/// Tolerances are given for each triangle, so triangles have to be small in the box.
TriangleMesh cutFor(const Work& work, const TriangleMesh& mesh) {
  return refined(mesh, [&](const Eigen::Vector3d& p) { return work.side + work.box.exteriorDistance(p) / 2; });
}

std::vector<double> tolerancesFor(const Work& work, const TriangleMesh& mesh) {
  builder::ToleranceRegion region;
  region.box = work.box;
  region.tolerance = work.tolerance;
  return builder::gradedTolerance(mesh, work.elsewhere, {&region, 1}, {}, 0);
}

TriangleMesh cube() { return box({-10, -10, -10}, {10, 10, 10}); }
TriangleMesh slab() { return box({-50, -50, -10}, {50, 50, 0}); }

TriangleMesh fineHandpiece() {
  TriangleMesh mesh = samples::makeHandpiece();
  for (Eigen::Vector3d& p : mesh.positions) p *= 0.7;
  return mesh;
}

/// 60 degrees, 10 deep, along y, bottom at the origin.
TriangleMesh groove() {
  const double half = 10 * std::tan(std::numbers::pi / 6);
  return extrude({{-10, -4}, {10, -4}, {10, 10}, {half, 10}, {0, 0}, {-half, 10}, {-10, 10}}, 20);
}

// The boxes are slightly wider than what the tool touches.
/// Where F3's ball of radius 5 moves over the edge of the cube.
const Work kEdgeWork{{Eigen::Vector3d(1, -2.5, 1), Eigen::Vector3d(11, 2.5, 11)}, 0.04, 1, 1};
/// Where F3's ball of radius 1 slides along the groove.
const Work kGrooveWork{{Eigen::Vector3d(-2, -8, 0), Eigen::Vector3d(2, 8, 3)}, 0.045, 1, 1};
/// The top of the slab without its rim: F2's paths of 60 mm cross its middle.
const Work kSlabWork{{Eigen::Vector3d(-42, -42, -1), Eigen::Vector3d(42, 42, 1)}, 0.4, 10, 4};

struct Recipe {
  std::function<TriangleMesh()> mesh;
  int levels = 4;
  double tolerance = 0;                                              // > 0: of the whole body [mm]
  std::function<std::vector<double>(const TriangleMesh&)> graded{};  // of each triangle, none below `tolerance` [mm]
  bool has_budget = false;  // its number of leaves may not suffice for the tolerance: then the quality matters
};

Recipe detailed(TriangleMesh (*mesh)(), const Work& work) {
  return {[=] { return cutFor(work, mesh()); }, 4, work.tolerance, [=](const TriangleMesh& cut) { return tolerancesFor(work, cut); }, true};
}

Recipe boxed(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double tolerance = 0) {
  return {[=] { return box(low, high); }, 4, tolerance};
}

Recipe extruded(const Profile& profile, double half_width) {
  return {[=] { return extrude(profile, half_width); }};
}

const std::map<std::string, Recipe>& recipes() {
  static const std::map<std::string, Recipe> all{
      // Tools. The balls are one sphere: the overhang over the facets of the mesh, 0.0123 for a radius of 5, is an
      // error of every figure that is compared with a ball.
      {"ball", {[] { return ball(5); }, 2, 0.0125}},
      {"small_ball", {[] { return ball(1); }, 2, 0.0025}},
      {"tip", {[] { return ball(3); }, 2, 0.0075}},
      {"probe", {[] { return capsule(1, 100); }}},
      {"fine_probe", {[] { return capsule(0.3, 40); }}},
      {"cube", {cube}},
      {"cube_work", detailed(cube, kEdgeWork)},
      {"cylinder", {[] { return cylinder(5, -30, 30, 32); }}},
      {"peg", {[] { return capsule(5, 40, 64, 12); }, 4, 0.02}},
      // The burr of 0.5 mm and of 0.35 mm radius at the origin, the axis along z.
      {"handpiece", {[] { return samples::makeHandpiece(); }, 4, 0.05}},
      {"fine_handpiece", {fineHandpiece, 4, 0.035}},
      {"dental_probe", {[] { return samples::makeProbe(); }}},
      // Objects; surfaces are at z = 0 unless noted otherwise.
      {"slab", {slab}},
      {"slab_work", detailed(slab, kSlabWork)},
      {"block", boxed({-30, -30, -60}, {30, 30, 0})},
      {"plate_2", boxed({-20, -20, -1}, {20, 20, 1})},  // middle at z = 0
      {"plate_1", boxed({-20, -20, -0.5}, {20, 20, 0.5})},
      {"plate_0.5", boxed({-20, -20, -0.25}, {20, 20, 0.25})},
      {"plate_0.2", boxed({-20, -20, -0.1}, {20, 20, 0.1})},
      {"wire", {[] { return cylinder(0.25, -20, 20, 16); }}},  // around the z axis
      {"groove", {groove}},
      {"groove_work", detailed(groove, kGrooveWork)},
      // Two walls, 1.5 apart, 4 deep, along y.
      {"sulcus", extruded({{-6, -8}, {6, -8}, {6, 0}, {0.75, 0}, {0.75, -4}, {-0.75, -4}, {-0.75, 0}, {-6, 0}}, 10)},
      {"ridge", extruded({{-8, -8}, {8, -8}, {0, 0}}, 20)},                                // 90 degrees, crest at the origin
      {"corner", extruded({{-4, -4}, {20, -4}, {20, 0}, {0, 0}, {0, 20}, {-4, 20}}, 24)},  // extends to +x, +z
      {"blind_hole", {[] {
         return lathe(cut({{0, -9}, {4, -9}, {4, 0}, {1.2, 0}, {1.2, -5}, {0, -5}}, 0.8), 32);
       }}},
      {"bore", {bore, 5, 0.05, boreTolerances}},
      {"bowl", {bowl}},
      {"wall", boxed({-4, -15, -35}, {0, 15, 35})},  // face at x = 0
      {"molar", {[] { return samples::makeMolar(); }}},
      {"small_block", boxed({-3, -4, -6}, {3, 4, 0}, 0.3)},
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

TriangleMesh refined(TriangleMesh mesh, const std::function<double(const Eigen::Vector3d&)>& longest) {
  const auto cutEdge = [&](std::uint32_t a, std::uint32_t b) {  // in both adjacent triangles
    const auto middle = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.emplace_back((mesh.positions[a] + mesh.positions[b]) / 2);
    for (std::size_t t = 0, count = mesh.triangles.size(); t < count; ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        Triangle rest = mesh.triangles[t];
        const std::size_t next = (k + 1) % 3;
        if (std::minmax(rest[k], rest[next]) != std::minmax(a, b)) continue;
        mesh.triangles[t][next] = middle;
        rest[k] = middle;
        mesh.triangles.push_back(rest);
        break;
      }
  };
  for (std::size_t t = 0; t < mesh.triangles.size();) {
    const Triangle corner = mesh.triangles[t];
    const auto length = [&](std::size_t k) { return (mesh.positions[corner[(k + 1) % 3]] - mesh.positions[corner[k]]).norm(); };
    std::size_t k = 0;
    for (const std::size_t other : {1, 2})
      if (length(other) > length(k)) k = other;
    const std::uint32_t a = corner[k], b = corner[(k + 1) % 3];
    if (length(k) <= longest((mesh.positions[a] + mesh.positions[b]) / 2))
      ++t;
    else
      cutEdge(a, b);
  }
  return mesh;
}

TriangleMesh BodyLibrary::mesh(const std::string& name) {
  if (const auto recipe = recipes().find(name); recipe != recipes().end()) return recipe->second.mesh();
  static const samples::Mouth mouth = samples::makeMouth();
  for (const samples::Mouth::Part& part : mouth.parts())
    if (part.name == name) return *part.mesh;
  throw std::invalid_argument("no body is called " + name);
}

builder::BuildSettings BodyLibrary::settingsFor(const std::string& name, const TriangleMesh& mesh) const {
  builder::BuildSettings settings;
  settings.quality = builder::Quality::Quick;  // for the many parts of the mouth, and where a tolerance determines the accuracy
  if (const auto recipe = recipes().find(name); recipe != recipes().end()) {
    settings.levels = recipe->second.levels;
    settings.tolerance_mm = recipe->second.tolerance;
    if (settings.tolerance_mm == 0 || recipe->second.has_budget) settings.quality = quality_;
    if (recipe->second.graded) settings.tolerance_of_triangle_mm = recipe->second.graded(mesh);
  }
  return settings;
}

BodyFrame BodyLibrary::frameOf(const std::string& name) const {
  BodyFrame frame;
  if (variant_ == 0) return frame;
  std::mt19937_64 engine(variant_);
  const auto uniform = [&](double low, double high) { return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53; };
  const auto rotation = [&] {
    Eigen::Vector4d q;
    do {
      for (double& x : q) x = uniform(-1, 1);
    } while (!(q.norm() > 0.1 && q.norm() < 1));
    return Quaternion(q[0], q[1], q[2], q[3]).normalized();
  };
  frame.scale = std::exp2(uniform(std::log2(0.8), std::log2(1.25)));
  frame.world = rotation();
  for (const char c : name) engine.seed(engine() ^ static_cast<unsigned char>(c));
  frame.turn = rotation();
  return frame;
}

const Body& BodyLibrary::get(const std::string& name) {
  const std::lock_guard lock(made_->mutex);
  const std::string known = variant_ == 0 ? name : name + " " + std::to_string(variant_);
  if (const auto found = made_->bodies.find(known); found != made_->bodies.end()) return *found->second;
  TriangleMesh mesh = BodyLibrary::mesh(name);
  builder::BuildSettings settings = settingsFor(name, mesh);
  const BodyFrame frame = frameOf(name);
  if (variant_ > 0)
    for (Eigen::Vector3d& p : mesh.positions) p = frame.scale * (frame.turn * p);
  settings.seed += variant_;
  return make(known, std::move(mesh), settings, frame);
}

const Body& BodyLibrary::make(const std::string& name, TriangleMesh mesh, const builder::BuildSettings& settings, const BodyFrame& frame) {
  const std::lock_guard lock(made_->mutex);
  if (const auto found = made_->bodies.find(name); found != made_->bodies.end()) return *found->second;
  SphereTree tree = this->tree(mesh, settings);
  builder::DistanceField field(mesh);
  return *made_->bodies.emplace(name, new Body{name, std::move(mesh), std::move(tree), std::move(field), contact_, frame}).first->second;
}

const SphereTree& BodyLibrary::tree(const TriangleMesh& mesh, const builder::BuildSettings& settings) {
  const std::lock_guard lock(made_->mutex);
  const Hash128 mesh_hash = builder::meshHash(mesh), settings_hash = builder::settingsHash(settings);
  const std::string key = toHex(mesh_hash) + '-' + toHex(settings_hash);
  if (const auto found = made_->trees.find(key); found != made_->trees.end()) return found->second;
  const std::filesystem::path file = cache_ / (key + ".stree");
  if (!cache_.empty() && std::filesystem::exists(file)) try {
      SphereTree kept =
          formats::parseSphereTree(formats::readFile(file, formats::kMaxFileBytes, formats::FileRole::Working), file.string());
      if (kept.provenance.mesh_hash == mesh_hash && kept.provenance.settings_hash == settings_hash)
        return made_->trees.emplace(key, std::move(kept)).first->second;
    } catch (const formats::FormatError&) {  // damaged, or of another version: built again
    }
  SphereTree built = builder::buildSphereTree(mesh, settings, progress_).tree;
  if (!cache_.empty()) {
    std::error_code error;
    std::filesystem::create_directories(cache_, error);  // an error will be reported when the file is written
    formats::writeWhole(file, encodeSphereTree(built), formats::FileRole::Working);
  }
  return made_->trees.emplace(key, std::move(built)).first->second;
}

}  // namespace spheretree::player
