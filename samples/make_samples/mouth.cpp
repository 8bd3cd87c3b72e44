// SPDX-License-Identifier: Apache-2.0
#include "mouth.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "implicit_surface.h"
#include "simplify.h"

namespace spheretree::samples {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kOpening = 42;                                          // between the cervical lines of the two arches [mm]
constexpr double kFloorGap = 0.45, kRimGap = 0.8;                        // of the sulcus, beside the tooth [mm]
constexpr double kFloor = -2.0, kRim = 0.2;                              // heights of the sulcus in the frame of the tooth [mm]
constexpr std::array<double, 2> kLowerArch{23, 44}, kUpperArch{25, 48};  // half-width and depth of the ellipse of tooth centres [mm]

struct Placed {
  ToothForm form;
  double scale;
};
constexpr std::array<Placed, 7> kUpperTeeth{{{ToothForm::Incisor, 1.0},
                                             {ToothForm::Incisor, 0.78},
                                             {ToothForm::Canine, 1.0},
                                             {ToothForm::Premolar, 1.0},
                                             {ToothForm::Premolar, 0.96},
                                             {ToothForm::Molar, 0.96},
                                             {ToothForm::Molar, 0.9}}};
constexpr std::array<Placed, 7> kLowerTeeth{{{ToothForm::Incisor, 0.7},
                                             {ToothForm::Incisor, 0.74},
                                             {ToothForm::Canine, 0.92},
                                             {ToothForm::Premolar, 1.0},
                                             {ToothForm::Premolar, 1.02},
                                             {ToothForm::Molar, 1.0},
                                             {ToothForm::Molar, 0.95}}};

// Half an ellipse, front at 0, by arc length from the front; the right side of the patient is negative.
class Arch {
 public:
  explicit Arch(const std::array<double, 2>& axes) : axes_(axes) {
    constexpr int kSteps = 4000;
    for (int i = 0; i <= kSteps; ++i) {
      points_.push_back(at(1.05 * i / kSteps));
      length_.push_back(i == 0 ? 0 : length_.back() + (points_[points_.size() - 1] - points_[points_.size() - 2]).norm());
    }
  }
  struct Frame {
    Vector2d point, along, outward;  // `along` to the patient's left
  };
  Frame frame(double s) const {
    const double distance = std::abs(s), side = s < 0 ? -1 : 1;
    const auto i = static_cast<std::size_t>(
        std::clamp<std::ptrdiff_t>(std::upper_bound(length_.begin(), length_.end(), distance) - length_.begin() - 1, 0,
                                   static_cast<std::ptrdiff_t>(length_.size()) - 2));
    const double t = (distance - length_[i]) / (length_[i + 1] - length_[i]);
    const Vector2d p = points_[i] + t * (points_[i + 1] - points_[i]);
    const Vector2d d = (points_[i + 1] - points_[i]).normalized();
    // At the front the two halves meet in one direction.
    const Vector2d along = i == 0 ? Vector2d(1, 0) : Vector2d(d.x(), side * d.y());
    return {{side * p.x(), p.y()}, along, {-along.y(), along.x()}};
  }

 private:
  Vector2d at(double t) const { return {axes_[0] * 2 * t / (1 + t * t), axes_[1] * (1 - t * t) / (1 + t * t)}; }
  std::array<double, 2> axes_;
  std::vector<Vector2d> points_;
  std::vector<double> length_;
};

// Extent of the tooth in direction `d` of its frame at the height of the sulcus.
double neckReach(const MouthTooth& tooth, const Vector2d& d) {
  double reach = 0;
  for (const Vector3d& p : tooth.mesh.positions) {
    const Vector3d local = p - tooth.centre;
    const double z = local.dot(tooth.occlusal);
    if (z < kFloor - 0.4 || z > kRim + 0.1) continue;
    reach = std::max(reach, local.dot(tooth.mesial) * d.x() + local.dot(tooth.buccal) * d.y());
  }
  return reach;
}

// The convex outline of a tooth at the height of the sulcus, in the frame of the tooth.
class NeckOutline {
 public:
  explicit NeckOutline(const MouthTooth& tooth) : normals_(circleCorners(8)) {
    for (const Vector2d& n : normals_) reach_.push_back(neckReach(tooth, n));
  }
  /// Distance from the centre, in direction `d`, to the outline widened by `gap`: the nearest of its bounding lines.
  double distance(const Vector2d& d, double gap) const {
    double nearest = 1e9;
    for (std::size_t i = 0; i < normals_.size(); ++i) {
      const double across = normals_[i].dot(d);
      if (across > 0.2) nearest = std::min(nearest, (reach_[i] + gap) / across);
    }
    return nearest;
  }

 private:
  std::vector<Vector2d> normals_;
  std::vector<double> reach_;
};

Vector3d inWorld(const MouthTooth& tooth, const Vector2d& p, double height) {
  return tooth.centre + p.x() * tooth.mesial + p.y() * tooth.buccal + height * tooth.occlusal;
}

void append(std::vector<MouthTooth>& teeth, const Arch& arch, const std::array<Placed, 7>& forms, bool upper, bool left) {
  double s = 0;
  for (std::size_t i = 0; i < forms.size(); ++i) {
    MouthTooth tooth;
    tooth.width = crownWidth(forms[i].form) * forms[i].scale;
    const Arch::Frame frame = arch.frame((left ? 1 : -1) * (s + tooth.width / 2));
    s += tooth.width;
    const int quadrant = upper ? (left ? 2 : 1) : (left ? 3 : 4);
    tooth.name = "tooth_" + std::to_string(quadrant) + std::to_string(i + 1);
    tooth.centre = {frame.point.x(), frame.point.y(), upper ? kOpening : 0.0};
    tooth.mesial = Vector3d(frame.along.x(), frame.along.y(), 0) * (left ? -1 : 1);
    tooth.buccal = {frame.outward.x(), frame.outward.y(), 0};
    tooth.occlusal = {0, 0, upper ? -1.0 : 1.0};
    tooth.mesh = makeTooth(forms[i].form);
    for (Vector3d& p : tooth.mesh.positions)
      p = tooth.centre + forms[i].scale * (p.x() * tooth.mesial + p.y() * tooth.buccal + p.z() * tooth.occlusal);
    if (tooth.mesial.cross(tooth.buccal).dot(tooth.occlusal) < 0)  // mirrored: the winding is reversed
      for (Triangle& t : tooth.mesh.triangles) std::swap(t[1], t[2]);
    teeth.push_back(std::move(tooth));
  }
}

// A jaw: the ridge with a socket around each tooth, on a band along the arch. Each tooth has a rectangle of the ridge;
// its rim of 16 points is joined to the rim of the sulcus, that rim to the floor of the sulcus, and a fan under the
// tooth closes the floor.
class JawMesh {
 public:
  JawMesh(const Arch& arch, const std::vector<const MouthTooth*>& teeth, bool upper) : arch_(arch), teeth_(teeth), upper_(upper) {}

  TriangleMesh make() {
    double length = 0;
    for (const MouthTooth* tooth : teeth_) length += tooth->width;
    double s = -length / 2;
    for (std::size_t i = 0; i < teeth_.size(); ++i) {
      const bool ends[] = {i == 0, i + 1 == teeth_.size()};
      const double first = s - (ends[0] ? 2.5 : 0), last = s + teeth_[i]->width + (ends[1] ? 2.5 : 0);
      if (i == 0) columns_.push_back(column(first));
      for (int k = 1; k <= kSide; ++k) columns_.push_back(column(first + (last - first) * k / kSide, k != kSide));
      s += teeth_[i]->width;
      addSocket(*teeth_[i], i);
    }
    addSidesAndBase();
    if (upper_)
      for (Triangle& t : mesh_.triangles) std::swap(t[1], t[2]);
    return std::move(mesh_);
  }

 private:
  static constexpr int kSide = 4;  // edges on each side of a rectangle
  static constexpr double kTongueSide = -6.3, kCheekSide = 6.0;

  std::uint32_t add(const Vector2d& at, double height) {
    mesh_.positions.push_back({at.x(), at.y(), (upper_ ? -height : height) + (upper_ ? kOpening : 0)});
    return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
  }
  void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh_.triangles.push_back({a, b, c});
    mesh_.triangles.push_back({a, c, d});
  }

  // The points across the ridge at arc length `s`, from the tongue's side to the cheek's; only the two outermost if
  // `edges_only`.
  std::array<std::uint32_t, kSide + 1> column(double s, bool edges_only = false) {
    const Arch::Frame frame = arch_.frame(s);
    std::array<std::uint32_t, kSide + 1> points{};
    for (int k = 0; k <= kSide; ++k) {
      if (edges_only && k != 0 && k != kSide) continue;
      const double t = static_cast<double>(k) / kSide, v = kTongueSide + (kCheekSide - kTongueSide) * t;
      const double papilla = edges_only ? 0 : 1.2 * 4 * t * (1 - t);  // the gum rises between two teeth
      points[static_cast<std::size_t>(k)] = add(frame.point + v * frame.outward, -0.4 + papilla);
    }
    outer_s_.push_back(s);
    return points;
  }

  void addSocket(const MouthTooth& tooth, std::size_t index) {
    const std::size_t first = index * kSide, last = first + kSide;
    std::vector<std::uint32_t> rim;  // counter-clockwise seen from the biting side
    for (std::size_t k = first; k < last; ++k) rim.push_back(columns_[k].front());
    for (std::size_t k = 0; k < kSide; ++k) rim.push_back(columns_[last][k]);
    for (std::size_t k = last; k > first; --k) rim.push_back(columns_[k].back());
    for (std::size_t k = kSide; k > 0; --k) rim.push_back(columns_[first][k]);
    const NeckOutline neck(tooth);
    const auto ring = [&](double gap, double height, double largest) {
      std::vector<std::uint32_t> points;
      for (const std::uint32_t v : rim) {
        const Vector3d to = mesh_.positions[v] - tooth.centre;
        const Vector2d at(to.dot(tooth.mesial), to.dot(tooth.buccal)), d = at.normalized();
        const Vector3d world = inWorld(tooth, std::min(neck.distance(d, gap), largest * at.norm()) * d, height);
        points.push_back(add({world.x(), world.y()}, height));
      }
      return points;
    };
    // Where two teeth are close, the gum between them keeps part of its width.
    const std::vector<std::uint32_t> inner = ring(kRimGap, kRim, 0.92), floor = ring(kFloorGap, kFloor, 0.88);
    const std::uint32_t middle = add({tooth.centre.x(), tooth.centre.y()}, kFloor - 0.3);
    for (std::size_t k = 0; k < rim.size(); ++k) {
      const std::size_t n = (k + 1) % rim.size();
      quad(rim[k], rim[n], inner[n], inner[k]);
      quad(inner[k], inner[n], floor[n], floor[k]);
      mesh_.triangles.push_back({floor[k], floor[n], middle});
    }
  }

  void addSidesAndBase() {
    // The outline of the ridge: along the tongue's side, across the far end, back along the cheek's side, across the
    // near end.
    struct Edge {
      std::uint32_t top;
      double s, v;
    };
    std::vector<Edge> outline;
    const std::size_t count = columns_.size();
    const double step = (kCheekSide - kTongueSide) / kSide;
    for (std::size_t k = 0; k + 1 < count; ++k) outline.push_back({columns_[k].front(), outer_s_[k], kTongueSide});
    for (int k = 0; k < kSide; ++k)
      outline.push_back({columns_.back()[static_cast<std::size_t>(k)], outer_s_.back(), kTongueSide + step * k});
    for (std::size_t k = count - 1; k > 0; --k) outline.push_back({columns_[k].back(), outer_s_[k], kCheekSide});
    for (int k = kSide; k > 0; --k)
      outline.push_back({columns_.front()[static_cast<std::size_t>(k)], outer_s_.front(), kTongueSide + step * k});
    std::vector<std::uint32_t> above;
    for (const Edge& e : outline) above.push_back(e.top);
    constexpr std::array<std::array<double, 2>, 4> kStrips{
        {{-2.5, 0.08}, {-6, 0.14}, {-11, 0.15}, {-17, 0.02}}};  // height, additional width
    for (const auto& [height, wider] : kStrips) {
      std::vector<std::uint32_t> below;
      for (const Edge& e : outline) {
        const Arch::Frame frame = arch_.frame(e.s);
        below.push_back(add(frame.point + e.v * (1 + wider) * frame.outward, height));
      }
      for (std::size_t k = 0; k < above.size(); ++k) {
        const std::size_t n = (k + 1) % above.size();
        quad(above[n], above[k], below[k], below[n]);
      }
      above = below;
    }
    addBase(above, count);
  }

  // One cell for each edge of the tongue's side, up to the cheek's side. The number of triangles determines how many
  // cells get a point in their middle; the cells at both ends always do, since the points of an end are collinear.
  void addBase(const std::vector<std::uint32_t>& outline, std::size_t count) {
    const std::size_t cells = count - 1, ring = outline.size();
    const auto cheek = [&](std::size_t k) { return cells + kSide + (cells - k); };  // place in the outline opposite k
    const std::size_t without = mesh_.triangles.size() + ring - 2;
    std::size_t middles = (kJawTriangles - without) / 2;
    for (std::size_t n = 0; n < cells; ++n) {
      const std::size_t cell = n == 0 ? 0 : n == 1 ? cells - 1 : n - 1;
      std::vector<std::uint32_t> polygon;  // clockwise from above
      for (std::size_t k = cell == 0 ? ring : cheek(cell); k >= cheek(cell); --k) polygon.push_back(outline[k % ring]);
      if (cell + 1 == cells)
        for (std::size_t k = cheek(cells); k > cells; --k) polygon.push_back(outline[k]);
      else
        polygon.push_back(outline[cheek(cell + 1)]);
      polygon.push_back(outline[cell + 1]);
      if (cell != 0) polygon.push_back(outline[cell]);
      if (middles > 0) {
        --middles;
        Vector3d sum = Vector3d::Zero();
        for (const std::uint32_t v : polygon) sum += mesh_.positions[v];
        mesh_.positions.push_back(sum / static_cast<double>(polygon.size()));
        const auto middle = static_cast<std::uint32_t>(mesh_.positions.size() - 1);
        for (std::size_t k = 0; k < polygon.size(); ++k) mesh_.triangles.push_back({polygon[k], polygon[(k + 1) % polygon.size()], middle});
      } else {
        for (std::size_t k = 1; k + 1 < polygon.size(); ++k) mesh_.triangles.push_back({polygon[0], polygon[k], polygon[k + 1]});
      }
    }
  }

  const Arch& arch_;
  const std::vector<const MouthTooth*>& teeth_;
  bool upper_;
  TriangleMesh mesh_;
  std::vector<std::array<std::uint32_t, kSide + 1>> columns_;
  std::vector<double> outer_s_;
};

double sixfoldVolume(const TriangleMesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) sum += mesh.corner(t, 0).dot(mesh.corner(t, 1).cross(mesh.corner(t, 2)));
  return sum;
}

TriangleMesh outward(TriangleMesh mesh) {
  if (sixfoldVolume(mesh) < 0)
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

// Rings of equal size, joined; closed into a torus, or by a point at both ends.
TriangleMesh joinRings(const std::vector<std::vector<Vector3d>>& rings, const Vector3d* first_end, const Vector3d* last_end) {
  TriangleMesh mesh;
  const auto size = static_cast<std::uint32_t>(rings[0].size()), count = static_cast<std::uint32_t>(rings.size());
  for (const auto& ring : rings) mesh.positions.insert(mesh.positions.end(), ring.begin(), ring.end());
  const auto at = [&](std::uint32_t ring, std::uint32_t k) { return ring % count * size + k % size; };
  for (std::uint32_t ring = 0; ring + (first_end ? 1 : 0) < count; ++ring) {
    for (std::uint32_t k = 0; k < size; ++k) {
      mesh.triangles.push_back({at(ring, k), at(ring, k + 1), at(ring + 1, k + 1)});
      mesh.triangles.push_back({at(ring, k), at(ring + 1, k + 1), at(ring + 1, k)});
    }
  }
  if (first_end) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(*first_end);
    mesh.positions.push_back(*last_end);
    for (std::uint32_t k = 0; k < size; ++k) {
      mesh.triangles.push_back({first, at(0, k + 1), at(0, k)});
      mesh.triangles.push_back({first + 1, at(count - 1, k), at(count - 1, k + 1)});
    }
  }
  return outward(std::move(mesh));
}

// From the root to the tip; flat, with a furrow along its middle.
TriangleMesh makeTongue() {
  constexpr int kRings = 22;
  const std::vector<Vector2d> circle = circleCorners(6);
  std::vector<std::vector<Vector3d>> rings;
  const auto axis = [](double t) { return Vector3d(0, -18 + 50 * t, -3 + 10 * t * (1 - t)); };
  for (int i = 1; i <= kRings; ++i) {
    const double t = static_cast<double>(i) / (kRings + 1), bulge = std::sqrt(4 * t * (1 - t));
    std::vector<Vector3d> ring;
    for (const Vector2d& d : circle) {
      const double furrow = d.y() > 0 ? 1.2 * d.y() * bulge / (1 + 12 * d.x() * d.x()) : 0;
      ring.push_back(axis(t) + Vector3d(13.5 * bulge * d.x(), 0, 7 * bulge * d.y() - furrow));
    }
    rings.push_back(std::move(ring));
  }
  const Vector3d root = axis(0), tip = axis(1);
  TriangleMesh mesh = joinRings(rings, &root, &tip);
  collapseTo(mesh, kTongueTriangles);
  return mesh;
}

// The front of the face as a shell with the open mouth in it.
TriangleMesh makeFace() {
  constexpr int kOuter = 15, kInner = 14;
  constexpr double kMiddle = 20, kThick = 8;
  const auto relief = [](double x, double z) {
    const auto bump = [&](double at_z, double width, double height, double high) {
      const double r = x * x / (width * width) + (z - at_z) * (z - at_z) / (height * height);
      return high / ((1 + r) * (1 + r));
    };
    return 62 - 0.008 * x * x - 0.0012 * (z - 25) * (z - 25) + bump(62, 11, 15, 19) + bump(-20, 16, 10, 6);
  };
  std::vector<std::vector<Vector3d>> rings;
  for (const Vector2d& d : circleCorners(14)) {
    const Vector2d lip(27 * d.x(), kMiddle + 23 * d.y()), edge(64 * d.x(), kMiddle + (d.y() > 0 ? 78 : 56) * d.y());
    std::vector<Vector3d> ring;
    const auto add = [&](double u, double depth) {
      const Vector2d p = lip + u * (edge - lip);
      const double rounded = u < 0.12 ? 3 * (0.12 - u) / 0.12 : 0;  // the lips curve inward from both sides
      ring.push_back({p.x(), relief(p.x(), p.y()) - depth + (depth > 0 ? rounded : -rounded), p.y()});
    };
    for (int k = 0; k < kOuter; ++k) add(static_cast<double>(k) / (kOuter - 1), 0);
    for (int k = kInner - 1; k >= 0; --k) add(static_cast<double>(k) / (kInner - 1), kThick);
    rings.push_back(std::move(ring));
  }
  TriangleMesh mesh = joinRings(rings, nullptr, nullptr);
  collapseTo(mesh, kFaceTriangles);
  return mesh;
}

}  // namespace

std::vector<Mouth::Part> Mouth::parts() const {
  std::vector<Part> parts;
  for (const MouthTooth& tooth : teeth) parts.push_back({tooth.name, &tooth.mesh});
  parts.insert(parts.end(), {{"lower_jaw", &lower_jaw}, {"upper_jaw", &upper_jaw}, {"tongue", &tongue}, {"face", &face}});
  return parts;
}

Mouth makeMouth() {
  Mouth mouth;
  const Arch lower(kLowerArch), upper(kUpperArch);
  append(mouth.teeth, upper, kUpperTeeth, true, false);
  append(mouth.teeth, upper, kUpperTeeth, true, true);
  append(mouth.teeth, lower, kLowerTeeth, false, true);
  append(mouth.teeth, lower, kLowerTeeth, false, false);
  const auto jaw = [&](const Arch& arch, std::size_t right, std::size_t left, bool is_upper) {
    std::vector<const MouthTooth*> along;  // from the back on the right, round to the back on the left
    for (std::size_t i = 7; i-- > 0;) along.push_back(&mouth.teeth[right + i]);
    for (std::size_t i = 0; i < 7; ++i) along.push_back(&mouth.teeth[left + i]);
    return JawMesh(arch, along, is_upper).make();
  };
  mouth.upper_jaw = jaw(upper, 0, 7, true);
  mouth.lower_jaw = jaw(lower, 21, 14, false);
  mouth.tongue = makeTongue();
  mouth.face = makeFace();
  return mouth;
}

double crownHeight(const MouthTooth& tooth, double mesial, double buccal) {
  double highest = 0;
  for (std::size_t t = 0; t < tooth.mesh.triangles.size(); ++t) {
    std::array<Vector3d, 3> p;
    for (int k = 0; k < 3; ++k) {
      const Vector3d to = tooth.mesh.corner(t, k) - tooth.centre;
      p[static_cast<std::size_t>(k)] = {to.dot(tooth.mesial) - mesial, to.dot(tooth.buccal) - buccal, to.dot(tooth.occlusal)};
    }
    std::array<double, 3> share;  // of each corner in the point above the origin
    for (std::size_t k = 0; k < 3; ++k) share[k] = p[(k + 1) % 3].x() * p[(k + 2) % 3].y() - p[(k + 1) % 3].y() * p[(k + 2) % 3].x();
    const double sum = share[0] + share[1] + share[2];
    if (sum == 0 || share[0] * sum < 0 || share[1] * sum < 0 || share[2] * sum < 0) continue;
    highest = std::max(highest, (share[0] * p[0].z() + share[1] * p[1].z() + share[2] * p[2].z()) / sum);
  }
  return highest;
}

Vector3d sulcusFloor(const MouthTooth& tooth, const Vector2d& direction) {
  return inWorld(tooth, NeckOutline(tooth).distance(direction, kFloorGap / 2) * direction, kFloor);
}

}  // namespace spheretree::samples
