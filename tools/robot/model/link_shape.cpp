// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/model/link_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "robot/model/dae_mesh.h"
#include "run_files.h"
#include "spheretree/formats/mesh_file.h"

namespace spheretree::robot {
namespace {

constexpr int kSides = 64;  // sides of the prism that replaces a cylinder: it is within 0.12 % of the radius

TriangleMesh boxMesh(const Eigen::Vector3d& size) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner)
    mesh.positions.push_back(0.5 * size.cwiseProduct(Eigen::Vector3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1)));
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

TriangleMesh cylinderMesh(const Cylinder& c) {
  TriangleMesh mesh;
  for (int side = 0; side < kSides; ++side) {
    const double angle = 2 * std::numbers::pi * side / kSides;
    for (const double z : {-c.length / 2, c.length / 2})
      mesh.positions.emplace_back(c.radius * std::cos(angle), c.radius * std::sin(angle), z);
  }
  const std::uint32_t low = 2 * kSides, high = low + 1;
  mesh.positions.emplace_back(0, 0, -c.length / 2);
  mesh.positions.emplace_back(0, 0, c.length / 2);
  for (std::uint32_t a = 0; a < low; a += 2) {
    const std::uint32_t b = (a + 2) % low;
    mesh.triangles.insert(mesh.triangles.end(), {{a, b, b + 1}, {a, b + 1, a + 1}, {low, b, a}, {high, a + 1, b + 1}});
  }
  return mesh;
}

TriangleMesh fileMesh(const MeshFile& file, double unit_mm, std::vector<std::string>& notes) {
  TriangleMesh mesh;
  if (tool::endingOf(file.path) == ".dae") {
    mesh = readDae(file.path, unit_mm);
  } else {
    formats::MeshFile read = formats::readMesh(file.path, unit_mm, unit_mm);
    mesh = std::move(read.mesh);
    notes = std::move(read.notes);
  }
  mesh.part.clear();
  mesh.part_names.clear();
  for (Eigen::Vector3d& p : mesh.positions) p = p.cwiseProduct(file.scale);
  if (file.scale.prod() < 0)  // a mirroring turns the surface inside out
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

}  // namespace

TriangleMesh capsuleMesh(const LinkCapsule& capsule) {
  constexpr std::uint32_t kRings = kSides / 2;
  const Eigen::Vector3d along = capsule.b - capsule.a;
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), along);
  const bool is_ball = along.isZero(0);
  TriangleMesh mesh;
  std::uint32_t rings = 0;
  const auto addRing = [&](std::uint32_t ring, const Eigen::Vector3d& centre) {
    ++rings;
    for (int side = 0; side < kSides; ++side) {
      const double polar = std::numbers::pi * ring / kRings, around = 2 * std::numbers::pi * side / kSides;
      const Eigen::Vector3d p(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar));
      mesh.positions.push_back(centre + capsule.radius * (turn * p));
    }
  };
  for (std::uint32_t ring = 1; ring <= kRings / 2; ++ring) addRing(ring, capsule.b);
  for (std::uint32_t ring = kRings / 2 + (is_ball ? 1 : 0); ring < kRings; ++ring) addRing(ring, capsule.a);
  const auto top = static_cast<std::uint32_t>(mesh.positions.size()), bottom = top + 1;
  mesh.positions.push_back(capsule.b + capsule.radius * (turn * Eigen::Vector3d::UnitZ()));
  mesh.positions.push_back(capsule.a - capsule.radius * (turn * Eigen::Vector3d::UnitZ()));
  const auto at = [](std::uint32_t ring, std::uint32_t side) { return ring * kSides + side % kSides; };
  for (std::uint32_t side = 0; side < kSides; ++side) {
    mesh.triangles.push_back({top, at(0, side), at(0, side + 1)});
    mesh.triangles.push_back({bottom, at(rings - 1, side + 1), at(rings - 1, side)});
    for (std::uint32_t ring = 0; ring + 1 < rings; ++ring) {
      mesh.triangles.push_back({at(ring, side), at(ring + 1, side), at(ring + 1, side + 1)});
      mesh.triangles.push_back({at(ring, side), at(ring + 1, side + 1), at(ring, side + 1)});
    }
  }
  return mesh;
}

bool LinkShape::hasSurface() const {
  if (capsule) return capsule->radius > 0;
  return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
    const Eigen::Vector3d& a = mesh.positions[t[0]];
    return (mesh.positions[t[1]] - a).cross(mesh.positions[t[2]] - a).squaredNorm() > 0;
  });
}

LinkShape shapeOf(const CollisionElement& element, double unit_mm) {
  LinkShape out;
  if (const Capsule* capsule = std::get_if<Capsule>(&element.shape)) {
    const Eigen::Vector3d half(0, 0, capsule->length / 2);
    out.capsule = LinkCapsule{element.origin * -half, element.origin * half, capsule->radius};
    return out;
  }
  if (const Box* box = std::get_if<Box>(&element.shape)) out.mesh = boxMesh(box->size);
  if (const Cylinder* cylinder = std::get_if<Cylinder>(&element.shape)) {
    out.mesh = cylinderMesh(*cylinder);
    out.padding = cylinder->radius * (1 - std::cos(std::numbers::pi / kSides)) * (1 + 1e-9);
  }
  if (const MeshFile* file = std::get_if<MeshFile>(&element.shape); file && !file->path.empty())
    out.mesh = fileMesh(*file, unit_mm, out.notes);
  for (Eigen::Vector3d& p : out.mesh.positions) p = element.origin * p;
  return out;
}

}  // namespace spheretree::robot
