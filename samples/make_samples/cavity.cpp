// SPDX-License-Identifier: Apache-2.0
#include "cavity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "implicit_surface.h"
#include "molar.h"
#include "spheretree/formats/scene_file.h"
#include "tooth_forms.h"

namespace spheretree::samples {
namespace {

using Eigen::Vector3d;

/// Negative inside an ellipsoid, approximately a distance near its surface.
double ellipsoid(const Vector3d& p, const Vector3d& centre, const Vector3d& half) {
  const Vector3d scaled = (p - centre).cwiseQuotient(half);
  return (scaled.norm() - 1) * half.minCoeff();
}

double canal(const Vector3d& p, const Vector3d& a, const Vector3d& b, double radius) {
  const Vector3d along = b - a;
  const double t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - a - t * along).norm() - radius;
}

/// Enamel is 1.5 mm thick over the cusps and thin at the neck; below it, 0.3 mm stand for the cementum.
double dentineField(const Vector3d& p) { return molarField(p) + 0.3 + 1.2 * smoothStep((p.z() + 0.5) / 5); }

/// A chamber with a canal into each root, 0.3 mm within the dentine.
double pulpField(const Vector3d& p) {
  const double chamber = ellipsoid(p, {0, 0, 0}, {2.4, 1.8, 1.7});
  const double mesial = smoothMin(canal(p, {1.6, 0, -0.8}, {3.1, -0.2, -6}, 0.4), canal(p, {3.1, -0.2, -6}, {2.5, -0.3, -10.5}, 0.35), 0.3);
  const double distal = smoothMin(canal(p, {-1.6, 0, -0.8}, {-3.2, 0.1, -6}, 0.4), canal(p, {-3.2, 0.1, -6}, {-3.9, 0.4, -10}, 0.35), 0.3);
  return smoothMax(smoothMin(chamber, smoothMin(mesial, distal, 0.3), 0.6), dentineField(p) + 0.3, 0.1);
}

/// Below the fissure it spreads along the border of enamel and dentine. It stays 0.15 mm below the surface.
double lesionField(const Vector3d& p) { return smoothMax(ellipsoid(p, {0.2, 0, 4.1}, {1.5, 1.1, 0.9}), molarField(p) + 0.15, 0.2); }

constexpr double kTravel = 20, kFeed = 4;  // of the hand [mm/s]

class Driller {
 public:
  explicit Driller(const Vector3d& start) { add(start, false); }
  void moveTo(const Vector3d& goal, double speed, bool spins) {
    const Vector3d from = path_.poses.back().position;
    const int steps = 1 + static_cast<int>(1000 * (goal - from).norm() / speed);
    for (int i = 1; i <= steps; ++i) add(from + (goal - from) * i / steps, spins);
  }
  DrillPath path() && { return std::move(path_); }

 private:
  void add(const Vector3d& p, bool spins) {
    path_.poses.push_back({p, {1, 0, 0, 0}});
    path_.spins.push_back(spins);
  }
  DrillPath path_;
};

}  // namespace

CariousMolar makeCariousMolar() {
  return {makeMolar(), polygonise(dentineField, {-7, -7, -15}, {7, 7, 10}, 0.6),
          polygonise(lesionField, {-2.5, -2.5, 2}, {2.9, 2.5, 6}, 0.3), polygonise(pulpField, {-5.5, -3, -12}, {5.5, 3, 3}, 0.35)};
}

TriangleMesh makeHandpiece() {
  constexpr int kQuarter = 6;
  // Height and radius of each ring: a burr of 1 mm, its neck and shank, and the handpiece, 4 mm and then 8 mm wide.
  constexpr std::array<std::array<double, 2>, 21> kProfile{
      {{-0.48, 0.14}, {-0.433, 0.25}, {-0.3, 0.4}, {-0.14, 0.48}, {0, 0.5},    {0.14, 0.48}, {0.3, 0.4},
       {0.4, 0.3},    {1.4, 0.3},     {2.4, 0.3},  {3.4, 0.34},   {4.4, 0.55}, {5.4, 0.8},   {7.5, 0.8},
       {9.6, 0.8},    {10.1, 1.6},    {10.8, 2},   {14, 2.3},     {18, 3.4},   {24, 4},      {30, 4}}};
  const std::vector<Eigen::Vector2d> circle = circleCorners(kQuarter);
  const auto corners = static_cast<std::uint32_t>(circle.size()), rings = static_cast<std::uint32_t>(kProfile.size());
  TriangleMesh mesh;
  for (const auto& [z, radius] : kProfile)
    for (const Eigen::Vector2d& c : circle) mesh.positions.push_back({radius * c.x(), radius * c.y(), z});
  const std::uint32_t tip = corners * rings, top = tip + 1;
  mesh.positions.push_back({0, 0, -0.5});
  mesh.positions.push_back({0, 0, kProfile.back()[0] + 0.5});
  for (std::uint32_t k = 0; k < corners; ++k) {
    const std::uint32_t next = (k + 1) % corners, last = (rings - 1) * corners;
    mesh.triangles.push_back({tip, next, k});
    mesh.triangles.push_back({top, last + k, last + next});
    for (std::uint32_t ring = 0; ring + 1 < rings; ++ring) {
      const std::uint32_t lower = ring * corners, upper = lower + corners;
      mesh.triangles.push_back({lower + k, lower + next, upper + next});
      mesh.triangles.push_back({lower + k, upper + next, upper + k});
    }
  }
  return mesh;
}

std::string cavitySceneText() {
  formats::SceneFile scene;
  scene.defaults.tolerance_mm = 0.1;
  scene.tool.name = "handpiece";
  scene.tool.mesh = "handpiece.obj";
  scene.tool.burr = {kBurr};
  formats::SceneItem tooth;
  tooth.name = "tooth_36";
  tooth.mesh = "tooth.obj";
  tooth.cut = formats::CutDescription{
      {{"enamel", "tooth.obj", 1}, {"dentine", "dentine.obj", 3}, {"lesion", "lesion.obj", 9}, {"pulp", "pulp.obj", 30}}, 0.5};
  scene.objects.push_back(std::move(tooth));
  return formats::sceneText(scene);
}

DrillPath prepareCavity() {
  constexpr double kTop = 6, kPass = 0.25, kHalfLength = 1.3;
  constexpr std::array<double, 5> kLanes{-0.6, -0.3, 0, 0.3, 0.6};
  Driller hand({0, 0, 16});
  hand.moveTo({-kHalfLength, 0, 9}, kTravel, false);
  hand.moveTo({-kHalfLength, 0, kTop}, kTravel, true);
  double side = -1;
  for (int pass = 1; pass <= 11; ++pass)
    for (const double lane : kLanes) {
      const double z = kTop - kPass * pass;
      hand.moveTo({side * kHalfLength, pass % 2 == 0 ? -lane : lane, z}, kFeed, true);
      side = -side;
      hand.moveTo({side * kHalfLength, pass % 2 == 0 ? -lane : lane, z}, kFeed, true);
    }
  hand.moveTo({side * kHalfLength, 0, 9}, kTravel, true);
  hand.moveTo({0, 0, 16}, kTravel, false);
  return std::move(hand).path();
}

std::string drillText(const DrillPath& path) {
  std::string text = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,spin\n";
  for (std::size_t i = 0; i < path.poses.size(); ++i) {
    const Vector3d& p = path.poses[i].position;
    char row[128];
    std::snprintf(row, sizeof row, "%.3f,%.6f,%.6f,%.6f,1,0,0,0,%d\n", 0.001 * static_cast<double>(i), p.x(), p.y(), p.z(),
                  path.spins[i] ? 1 : 0);
    text += row;
  }
  return text;
}

}  // namespace spheretree::samples
