// SPDX-License-Identifier: Apache-2.0
#include "molar.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "implicit_surface.h"

namespace spheretree::samples {
namespace {

using Eigen::Vector3d;

// A root: an elliptic section that tapers and closes at the apex, along a curved axis.
struct Root {
  Vector3d top, bend, apex;       // the axis: a parabola from `top` to `apex` with the control point `bend` [mm]
  double half_x, half_y;          // half-widths at the top [mm]
  double taper;                   // share of the half-width lost towards the apex
  double furrow_x, furrow_depth;  // the furrow between its two canals: side and depth [mm]
};

double rootField(const Root& root, const Vector3d& p) {
  const double t = (root.top.z() - p.z()) / (root.top.z() - root.apex.z()), s = 1 - t;
  const double axis_x = s * s * root.top.x() + 2 * s * t * root.bend.x() + t * t * root.apex.x();
  const double axis_y = s * s * root.top.y() + 2 * s * t * root.bend.y() + t * t * root.apex.y();
  const double width = 1 - root.taper * std::clamp(t, -0.2, 1.2);
  const double u = (p.x() - axis_x) / (root.half_x * width), v = (p.y() - axis_y) / (root.half_y * width);
  const double closing = t > 0 ? squared(t * t) : squared(6 * t);  // above, it ends within the crown
  const double furrow = root.furrow_depth * smoothStep((t - 0.15) / 0.3) * smoothStep((0.95 - t) / 0.3) * smoothStep(u * root.furrow_x) /
                        (1 + squared((p.y() - axis_y) / 0.9));
  return (std::sqrt(u * u + v * v + closing) - 1) * root.half_x * width + furrow;
}

double polylineDistance(const Vector3d& p, std::span<const Vector3d> line) {
  double nearest = 1e9;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Vector3d along = line[i + 1] - line[i], to_p = p - line[i];
    const double t = std::clamp(to_p.dot(along) / along.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (to_p - t * along).norm());
  }
  return nearest;
}

// The chewing surface as a height over x and y: five cones with rounded tips, their valleys deepened by fissures, and a
// rim at both ends.
double chewingHeight(double x, double y) {
  struct Cusp {
    double x, y, height;
  };
  constexpr std::array<Cusp, 5> kCusps{{{2.35, 2.55, 7.5}, {-0.75, 2.75, 7.4}, {-3.35, 1.35, 7.0}, {2.25, -2.6, 7.9}, {-1.85, -2.65, 7.7}}};
  double height = -1e9;
  for (const Cusp& cusp : kCusps) {
    const double cone = cusp.height + 0.42 - 0.72 * std::sqrt(squared(x - cusp.x) + squared(y - cusp.y) + 0.35);
    height = smoothMax(height, cone, 1.2);
  }
  const double mesial_rim = 6.35 - 0.55 * squared(x - 4.0) - 0.04 * y * y;
  const double distal_rim = 6.15 - 0.55 * squared(x + 4.1) - 0.05 * y * y;
  height = smoothMax(smoothMax(height, mesial_rim, 0.8), distal_rim, 0.8);
  static const std::array<Vector3d, 6> kCentral{Vector3d(3.0, 0.0, 0),   Vector3d(1.6, 0.25, 0),  Vector3d(0.55, -0.1, 0),
                                                Vector3d(-0.5, 0.05, 0), Vector3d(-1.6, -0.2, 0), Vector3d(-3.0, -0.45, 0)};
  static const std::array<Vector3d, 3> kMesioBuccal{Vector3d(0.55, -0.1, 0), Vector3d(0.75, 2.2, 0), Vector3d(0.8, 6, 0)};
  static const std::array<Vector3d, 3> kDistoBuccal{Vector3d(-1.6, -0.2, 0), Vector3d(-2.25, 1.9, 0), Vector3d(-3.3, 6, 0)};
  static const std::array<Vector3d, 3> kLingual{Vector3d(-0.5, 0.05, 0), Vector3d(0.2, -2.2, 0), Vector3d(0.2, -6, 0)};
  const Vector3d at(x, y, 0);
  double to_fissure = polylineDistance(at, kCentral);
  for (const auto& branch : {std::span(kMesioBuccal), std::span(kDistoBuccal), std::span(kLingual)}) {
    to_fissure = std::min(to_fissure, polylineDistance(at, branch));
  }
  return height - 0.62 / squared(1 + squared(to_fissure / 1.15));
}

double crown(const Vector3d& p) {
  const double x = p.x(), y = p.y(), z = p.z();
  // Half-widths: narrow neck, a small step outward at the cervical line, widest at half the height, narrower towards
  // the cusps.
  const double cervical = 0.2 + 0.75 * squared(x / 4.5) * (1 - 0.3 * squared(y / 4.5)) - 0.35 * squared(y / 4.5);
  const double enamel = smoothStep((z - cervical + 0.35) / 0.8);
  const double belly = smoothStep((z - cervical + 0.8) / 4.4);
  const double drawn_in = 0.06 * squared(std::max(z - 3.8, 0.0));
  const double half_x = 4.1 + 0.3 * enamel + 1.05 * belly - 0.6 * drawn_in;
  const double half_y = 3.85 + 0.3 * enamel + 0.95 * belly - drawn_in;
  // Grooves from the fissures down the cheek side and the tongue side.
  const double on_wall = smoothStep((z - 1.6) / 3.5);
  const double cheek = y > 0 ? 0.45 / (1 + squared((x - 0.8) / 0.55)) + 0.32 / (1 + squared((x + 2.7) / 0.5)) : 0.0;
  const double tongue = y < 0 ? 0.4 / (1 + squared((x - 0.2) / 0.55)) : 0.0;
  const double groove = on_wall * (cheek + tongue) * smoothStep(std::abs(y) / 3.0);
  // The outline narrows to the back; its form is between a circle and a rounded square.
  const double u = x / half_x, v = y / (half_y * (1 + 0.035 * x / 4.5));
  const double outline = std::sqrt(std::sqrt(squared(u * u) + squared(v * v) + 0.75 * u * u * v * v));
  const double wall = (outline - 1) * std::min(half_x, half_y) + groove;
  const double top = (z - chewingHeight(x, y)) * 0.8;
  const double floor = -2.6 - z;
  return smoothMax(smoothMax(wall, top, 1.1), floor, 2.0);
}

}  // namespace

double molarField(const Vector3d& p) {
  static const Root kMesial{{2.15, 0, -0.5}, {4.3, -0.2, -7.5}, {2.1, -0.4, -13.3}, 1.95, 3.5, 0.42, 1, 0.45};
  static const Root kDistal{{-2.1, 0, -0.5}, {-3.6, 0.2, -7.5}, {-4.3, 0.5, -12.6}, 1.9, 3.1, 0.42, -1, 0.3};
  const double roots = smoothMin(rootField(kMesial, p), rootField(kDistal, p), 0.8);
  return smoothMin(crown(p), roots, 1.3);
}

TriangleMesh makeMolar() { return polygonise(molarField, Vector3d(-7, -7, -15), Vector3d(7, 7, 10), 0.645); }

}  // namespace spheretree::samples
