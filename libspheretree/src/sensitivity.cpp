// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/sensitivity.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "base/random.h"
#include "spheretree/builder/mesh_checks.h"
#include "spheretree/core/rounding.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

// Unlike std::shuffle, this is the same in all libraries.
template <class T>
void shuffle(std::vector<T>& list, std::mt19937_64& random) {
  for (std::size_t i = list.size(); i > 1; --i) std::swap(list[i - 1], list[random() % i]);
}

Eigen::AlignedBox3d boxOf(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : mesh.positions) box.extend(p);
  return box;
}

// Uniform over all rotations. Method: K. Shoemake. Uniform random rotations. Graphics Gems III, 1992.
TriangleMesh turned(TriangleMesh mesh, std::mt19937_64& random) {
  const double u = randomUnit(random), a = 2 * std::numbers::pi * randomUnit(random), b = 2 * std::numbers::pi * randomUnit(random);
  const double s = std::sqrt(1 - u), t = std::sqrt(u);
  const Eigen::Matrix3d turn = Eigen::Quaterniond(t * std::cos(b), s * std::sin(a), s * std::cos(a), t * std::sin(b)).toRotationMatrix();
  const Vector3d middle = boxOf(mesh).center();
  for (Vector3d& p : mesh.positions) p = middle + turn * (p - middle);
  return mesh;
}

TriangleMesh scaled(TriangleMesh mesh, double factor) {
  for (Vector3d& p : mesh.positions) p *= factor;
  return mesh;
}

TriangleMesh noisy(const TriangleMesh& mesh, double noise, std::mt19937_64& random) {
  std::vector<Vector3d> shift;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const double x = randomUnit(random), y = randomUnit(random), z = randomUnit(random);
    shift.push_back(2 * Vector3d(x, y, z) - Vector3d::Ones());
  }
  for (double largest = noise * boxOf(mesh).diagonal().norm(); largest > 0; largest *= 0.5) {
    TriangleMesh out = mesh;
    for (std::size_t v = 0; v < shift.size(); ++v) out.positions[v] += largest * shift[v];
    if (checkMesh(out).clean()) return out;
  }
  return mesh;
}

TriangleMesh verticesShuffled(const TriangleMesh& mesh, std::mt19937_64& random) {
  std::vector<std::uint32_t> place(mesh.positions.size());
  for (std::uint32_t v = 0; v < place.size(); ++v) place[v] = v;
  shuffle(place, random);
  TriangleMesh out = mesh;
  for (std::size_t v = 0; v < place.size(); ++v) out.positions[place[v]] = mesh.positions[v];
  for (Triangle& t : out.triangles)
    for (std::uint32_t& v : t) v = place[v];
  return out;
}

TriangleMesh facesShuffled(TriangleMesh mesh, std::mt19937_64& random) {
  shuffle(mesh.triangles, random);
  for (Triangle& t : mesh.triangles) std::rotate(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(random() % 3), t.end());
  return mesh;
}

// Divides each triangle into four, by the middles of its sides: the same surface.
TriangleMesh subdivided(const TriangleMesh& mesh) {
  TriangleMesh out;
  out.positions = mesh.positions;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
  const auto between = [&](std::uint32_t a, std::uint32_t b) {
    const auto [at, is_new] = middle.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(out.positions.size()));
    if (is_new) out.positions.push_back(0.5 * (mesh.positions[a] + mesh.positions[b]));
    return at->second;
  };
  for (const Triangle& t : mesh.triangles) {
    const std::uint32_t a = between(t[0], t[1]), b = between(t[1], t[2]), c = between(t[2], t[0]);
    out.triangles.insert(out.triangles.end(), {Triangle{t[0], a, c}, Triangle{a, t[1], b}, Triangle{c, b, t[2]}, Triangle{a, b, c}});
  }
  return out;
}

class Measurer {
 public:
  Measurer(const TriangleMesh& mesh, const BuildSettings& build, Progress& progress)
      : build_(build), progress_(progress), plain_(buildSphereTree(mesh, build, progress)) {}

  void add(SensitivityRow& row, const TriangleMesh& mesh, double scale = 1) const {
    BuildSettings settings = build_;
    settings.tolerance_mm *= scale;
    const BuildResult other = buildSphereTree(mesh, settings, progress_);
    const double change = boundOf(other) / (scale * boundOf(plain_)) - 1;
    row.largest_change = std::max(row.largest_change, std::abs(change));
    row.same_spheres = (row.cases == 0 || row.same_spheres) && isSame(other.tree, scale);
    ++row.cases;
  }

 private:
  static double boundOf(const BuildResult& result) { return result.statistics.levels.back().overhang_bound_mm; }
  bool isSame(const SphereTree& tree, double scale) const {
    const float f = roundToFloat(scale);
    return std::equal(
        tree.cover.begin(), tree.cover.end(), plain_.tree.cover.begin(), plain_.tree.cover.end(),
        [f](const Sphere& a, const Sphere& b) { return a.x == f * b.x && a.y == f * b.y && a.z == f * b.z && a.radius == f * b.radius; });
  }

  const BuildSettings& build_;
  Progress& progress_;
  BuildResult plain_;
};

}  // namespace

std::vector<SensitivityRow> measureSensitivity(const TriangleMesh& mesh, const BuildSettings& build, const SensitivitySettings& settings,
                                               Progress& progress) {
  const Measurer measurer(mesh, build, progress);
  std::mt19937_64 random(settings.seed);
  std::vector<SensitivityRow> rows;
  const auto row = [&](const char* change) -> SensitivityRow& { return rows.emplace_back(SensitivityRow{change}); };
  SensitivityRow& rotation = row("rotation");
  for (int i = 0; i < settings.rotations; ++i) measurer.add(rotation, turned(mesh, random));
  SensitivityRow& noise = row("noise");
  for (int i = 0; i < settings.others; ++i) measurer.add(noise, noisy(mesh, settings.noise, random));
  SensitivityRow& vertices = row("vertex order");
  for (int i = 0; i < settings.others; ++i) measurer.add(vertices, verticesShuffled(mesh, random));
  SensitivityRow& faces = row("face order");
  for (int i = 0; i < settings.others; ++i) measurer.add(faces, facesShuffled(mesh, random));
  SensitivityRow& powers = row("scale 2^k");
  for (const double scale : {0x1p-8, 0.5, 2.0, 0x1p8}) measurer.add(powers, scaled(mesh, scale), scale);
  measurer.add(row("scale 1.7"), scaled(mesh, 1.7), 1.7);
  measurer.add(row("subdivision"), subdivided(mesh));
  return rows;
}

}  // namespace spheretree::builder
