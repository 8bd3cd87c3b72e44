// SPDX-License-Identifier: Apache-2.0
#include "tooth_forms.h"

#include <cmath>
#include <span>

#include "implicit_surface.h"
#include "molar.h"
#include "simplify.h"

namespace spheretree::samples {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kQuarter = 10, kSectionCorners = 4 * kQuarter;  // of a section
constexpr int kRings = 50;                                    // 2 * 40 * 50 = 4,000 triangles with the fans at both ends
constexpr int kTopRings = 14;                                 // of them, on the biting edge or chewing surface

// One height of a tooth: half-widths to the front and back, to the cheek and to the tongue [mm].
struct Section {
  double z, half_x, cheek, tongue;
};

struct Cusp {
  double x, y, height, width;  // [mm]
};

struct Shape {
  std::span<const Section> sections;  // from the tip of the root to the rim of the crown
  std::span<const Cusp> cusps;
  double dome;  // height of the middle of the top above the rim [mm]
};

// A smooth line through a, b at t = 0, 1 whose slopes agree with those of the neighbours o and c (Catmull and Rom).
double through(double o, double a, double b, double c, double t) {
  return a + 0.5 * t * (b - o + t * (2 * o - 5 * a + 4 * b - c + t * (3 * (a - b) + c - o)));
}

Section sectionAt(std::span<const Section> all, double place) {
  const auto i = std::min(static_cast<std::size_t>(place), all.size() - 2);
  const double t = place - static_cast<double>(i);
  const Section &o = all[i > 0 ? i - 1 : 0], &a = all[i], &b = all[i + 1], &c = all[std::min(i + 2, all.size() - 1)];
  return {through(o.z, a.z, b.z, c.z, t), through(o.half_x, a.half_x, b.half_x, c.half_x, t),
          through(o.cheek, a.cheek, b.cheek, c.cheek, t), through(o.tongue, a.tongue, b.tongue, c.tongue, t)};
}

Vector3d onSection(const Section& s, const Vector2d& direction, double share) {
  const double y = direction.y() * (direction.y() > 0 ? s.cheek : s.tongue);
  return {direction.x() * s.half_x * share, y * share, s.z};
}

TriangleMesh loft(const Shape& shape) {
  const std::vector<Vector2d> circle = circleCorners(kQuarter);
  TriangleMesh mesh;
  const Section rim = shape.sections.back();
  const auto risenTop = [&](Vector3d p, double share) {
    double cusps = 0;
    for (const Cusp& cusp : shape.cusps)
      cusps += cusp.height / squared(1 + (squared(p.x() - cusp.x) + squared(p.y() - cusp.y)) / squared(cusp.width));
    p.z() += (shape.dome + cusps) * smoothStep((1 - share) / 0.35) + 0.25 * smoothStep((1 - share) / 0.12);
    return p;
  };
  mesh.positions.push_back({0, 0, shape.sections.front().z - 0.25});
  for (int ring = 0; ring < kRings - kTopRings; ++ring) {
    const double place = static_cast<double>(shape.sections.size() - 1) * ring / (kRings - kTopRings - 1);
    const Section section = sectionAt(shape.sections, place);
    for (const Vector2d& direction : circle) mesh.positions.push_back(onSection(section, direction, 1));
  }
  for (int ring = 1; ring <= kTopRings; ++ring) {
    const double share = 1 - static_cast<double>(ring) / (kTopRings + 1);
    for (const Vector2d& direction : circle) mesh.positions.push_back(risenTop(onSection(rim, direction, share), share));
  }
  mesh.positions.push_back(risenTop({0, 0, rim.z}, 0));

  const auto at = [](int ring, int corner) { return static_cast<std::uint32_t>(1 + ring * kSectionCorners + corner % kSectionCorners); };
  const auto top = static_cast<std::uint32_t>(mesh.positions.size() - 1);
  for (int k = 0; k < kSectionCorners; ++k) {
    mesh.triangles.push_back({0, at(0, k + 1), at(0, k)});
    for (int ring = 0; ring + 1 < kRings; ++ring) {
      mesh.triangles.push_back({at(ring, k), at(ring, k + 1), at(ring + 1, k + 1)});
      mesh.triangles.push_back({at(ring, k), at(ring + 1, k + 1), at(ring + 1, k)});
    }
    mesh.triangles.push_back({at(kRings - 1, k), at(kRings - 1, k + 1), top});
  }
  return mesh;
}

constexpr Section kIncisor[] = {{-13, 0.7, 0.8, 0.8},  {-11.5, 1.4, 1.6, 1.6}, {-8, 2.1, 2.4, 2.4},   {-4, 2.7, 2.9, 2.8},
                                {-1, 3.05, 3.1, 3.1},  {0.2, 3.15, 3.2, 3.3},  {1.2, 3.5, 3.45, 3.6}, {3, 3.9, 3.2, 3.0},
                                {5.5, 4.15, 2.6, 1.6}, {8, 4.25, 1.8, 0.5},    {9.6, 4.1, 1.2, 0.05}};
constexpr Section kCanine[] = {{-16, 0.7, 0.8, 0.8},  {-14.5, 1.4, 1.8, 1.8}, {-10, 2.2, 2.9, 2.9}, {-5, 2.6, 3.5, 3.5},
                               {-1, 2.8, 3.8, 3.8},   {0.2, 2.9, 3.9, 3.9},   {1.2, 3.2, 4.1, 4.2}, {3, 3.6, 3.9, 3.9},
                               {5.5, 3.75, 3.1, 2.6}, {7.2, 3.4, 2.2, 1.4}};
constexpr Section kPremolar[] = {{-14, 0.7, 1.0, 1.0}, {-12.5, 1.3, 1.9, 1.9}, {-8, 2.0, 3.0, 3.0},   {-4, 2.4, 3.6, 3.6},
                                 {-1, 2.6, 4.0, 4.0},  {0.2, 2.7, 4.1, 4.1},   {1.2, 3.0, 4.35, 4.3}, {3, 3.4, 4.6, 4.5},
                                 {5, 3.5, 4.2, 4.2},   {6.2, 3.2, 3.6, 3.6}};
constexpr Cusp kCanineTip[] = {{0.1, 0.3, 2.6, 2.2}};
constexpr Cusp kPremolarCusps[] = {{0.1, 2.1, 3.0, 2.1}, {0.2, -2.2, 2.2, 2.0}};

}  // namespace

std::vector<Vector2d> circleCorners(int quarter) {
  std::vector<Vector2d> corners;
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i < quarter; ++i) {
      // Half the angle's tangent, so that cosine and sine are quotients; tan(22.5 degrees) at an eighth of a turn.
      const double t = static_cast<double>(i) / quarter;
      const double tangent = (std::sqrt(2.0) - 1) * (t <= 0.5 ? 2 * t : 2 * (1 - t));
      double c = (1 - tangent * tangent) / (1 + tangent * tangent), s = 2 * tangent / (1 + tangent * tangent);
      if (t > 0.5) std::swap(c, s);
      const Vector2d turned[] = {{c, s}, {-s, c}, {-c, -s}, {s, -c}};
      corners.push_back(turned[side]);
    }
  }
  return corners;
}

TriangleMesh makeTooth(ToothForm form) {
  switch (form) {
    case ToothForm::Incisor:
      return loft({kIncisor, {}, 0.15});
    case ToothForm::Canine:
      return loft({kCanine, kCanineTip, 0.2});
    case ToothForm::Premolar:
      return loft({kPremolar, kPremolarCusps, -1.3});
    case ToothForm::Molar:
      break;
  }
  TriangleMesh mesh = makeMolar();
  collapseTo(mesh, kToothTriangles);
  return mesh;
}

double crownWidth(ToothForm form) {
  switch (form) {
    case ToothForm::Incisor:
      return 8.5;
    case ToothForm::Canine:
      return 7.5;
    case ToothForm::Premolar:
      return 7.0;
    case ToothForm::Molar:
      break;
  }
  return 10.9;
}

}  // namespace spheretree::samples
