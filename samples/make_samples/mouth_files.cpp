// SPDX-License-Identifier: Apache-2.0
#include "mouth_files.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>

#include "spheretree/formats/scene_file.h"

namespace spheretree::samples {
namespace {

using Eigen::Vector3d;

template <class... Values>
void print(std::string& text, const char* format, Values... values) {
  char line[256];
  text.append(line, static_cast<std::size_t>(std::snprintf(line, sizeof line, format, values...)));
}

void put32(std::string& bytes, std::uint32_t value) {
  static_assert(std::endian::native == std::endian::little, "GLB is little-endian");
  char raw[4];
  std::memcpy(raw, &value, 4);
  bytes.append(raw, 4);
}

// The tip points down and 30 degrees forward; the shaft leaves the mouth forward, 30 degrees upward.
Quaternion holdDown() {
  const double half = std::sqrt(0.5);
  return Quaternion(half, 0, 0, -half) * Quaternion(std::sqrt(0.75), 0, -0.5, 0);
}
Quaternion holdUp() { return Quaternion(0, 0, 1, 0) * holdDown(); }

// A hand that moves the tip along straight lines, one row each millisecond.
class Hand {
 public:
  explicit Hand(const Configuration& start) : path_{start} {}
  /// `speed` in mm/s; a rotation by one radian takes as long as 20 mm.
  void moveTo(const Configuration& goal, double speed) {
    const Configuration from = path_.back();
    const Displacement way = displacementBetween(from, goal);
    const int steps = 1 + static_cast<int>(1000 * (way.translation.norm() + 20 * way.rotation.norm()) / speed);
    for (int i = 1; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      path_.push_back(moved(from, {t * way.translation, t * way.rotation}));
    }
  }
  void rest(int milliseconds) { path_.insert(path_.end(), static_cast<std::size_t>(milliseconds), path_.back()); }
  Path path() && { return std::move(path_); }

 private:
  Path path_;
};

constexpr double kFree = 60, kTouching = 12;  // [mm/s]

// Values from the literature: docs/tissue.md. Fixed are the ridges of the gums, and the part of the face that lies on
// bone.
void soften(formats::SceneItem& object) {
  const auto fixedIn = [](const Vector3d& low, const Vector3d& high) {
    formats::FixedRegion fixed;
    fixed.region.shape = formats::WorkRegion::Shape::Box;
    fixed.region.low_mm = low;
    fixed.region.high_mm = high;
    return fixed;
  };
  formats::SoftSettings soft;
  if (object.name == "tongue") {
    soft.young_kpa = 15;
    soft.poisson = 0.49;
    soft.fixed = {fixedIn({-50, -50, -50}, {50, 50, -5}), fixedIn({-50, -50, -50}, {50, -12, 50})};
    object.settings.levels = 5;
  } else if (object.name == "lower_jaw") {
    soft.young_kpa = 3000;
    soft.fixed = {fixedIn({-50, -50, -50}, {50, 80, -4})};
  } else if (object.name == "upper_jaw") {
    soft.young_kpa = 3000;
    soft.fixed = {fixedIn({-50, -50, 46}, {50, 80, 90})};
  } else if (object.name == "face") {
    soft.young_kpa = 30;
    soft.fixed = {fixedIn({-90, 0, 70}, {90, 90, 120}), fixedIn({-90, 0, -60}, {90, 90, -20}), fixedIn({-90, 0, -60}, {90, 32, 120})};
  } else {
    return;
  }
  object.soft = soft;
}

}  // namespace

std::string objText(const std::vector<Mouth::Part>& parts, const std::string& title) {
  std::string text = "# " + title + ", millimetres\n";
  std::size_t first = 1;
  for (const Mouth::Part& part : parts) {
    text += "g " + part.name + "\n";
    for (const Vector3d& p : part.mesh->positions) print(text, "v %.5f %.5f %.5f\n", p.x(), p.y(), p.z());
    for (const Triangle& t : part.mesh->triangles) print(text, "f %zu %zu %zu\n", t[0] + first, t[1] + first, t[2] + first);
    first += part.mesh->positions.size();
  }
  return text;
}

std::string glbBytes(const std::vector<Mouth::Part>& parts) {
  std::string binary, views, accessors, meshes, nodes, roots;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const TriangleMesh& mesh = *parts[i].mesh;
    const char* comma = i == 0 ? "" : ",";
    Vector3d low = Vector3d::Constant(1e9), high = -low;
    const std::size_t begin = binary.size(), points = mesh.positions.size(), corners = 3 * mesh.triangles.size();
    for (const Vector3d& p : mesh.positions) {
      for (int axis = 0; axis < 3; ++axis) {
        const float metres = static_cast<float>(p[axis] / 1000);
        low[axis] = std::min(low[axis], static_cast<double>(metres));
        high[axis] = std::max(high[axis], static_cast<double>(metres));
        put32(binary, std::bit_cast<std::uint32_t>(metres));
      }
    }
    for (const Triangle& t : mesh.triangles)
      for (const std::uint32_t v : t) put32(binary, v);
    print(views, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"target\":34962}", comma, begin, 12 * points);
    print(views, ",{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"target\":34963}", begin + 12 * points, 4 * corners);
    print(accessors, "%s{\"bufferView\":%zu,\"componentType\":5126,\"count\":%zu,\"type\":\"VEC3\",", comma, 2 * i, points);
    print(accessors, "\"min\":[%.9g,%.9g,%.9g],\"max\":[%.9g,%.9g,%.9g]}", low.x(), low.y(), low.z(), high.x(), high.y(), high.z());
    print(accessors, ",{\"bufferView\":%zu,\"componentType\":5125,\"count\":%zu,\"type\":\"SCALAR\"}", 2 * i + 1, corners);
    print(meshes, "%s{\"primitives\":[{\"attributes\":{\"POSITION\":%zu},\"indices\":%zu}]}", comma, 2 * i, 2 * i + 1);
    nodes.append(comma).append("{\"name\":\"").append(parts[i].name).append("\",\"mesh\":").append(std::to_string(i)).append("}");
    roots.append(comma).append(std::to_string(i));
  }
  std::string json = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[)" + roots + "]}],\"nodes\":[" + nodes + "],\"meshes\":[" +
                     meshes + "],\"accessors\":[" + accessors + "],\"bufferViews\":[" + views +
                     "],\"buffers\":[{\"byteLength\":" + std::to_string(binary.size()) + "}]}";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string file = "glTF";
  put32(file, 2);
  put32(file, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + binary.size()));
  put32(file, static_cast<std::uint32_t>(json.size()));
  file += "JSON" + json;
  put32(file, static_cast<std::uint32_t>(binary.size()));
  return file.append("BIN\0", 4) + binary;
}

std::string mouthSceneText(const Mouth& mouth, MouthMotion motion) {
  formats::SceneFile scene;
  scene.tool.name = "probe";
  scene.tool.mesh = "probe.obj";
  // About the line of the two condyles, behind and above the lower jaw; a negative rotation about x opens.
  double back = 1e9;
  for (const Vector3d& p : mouth.lower_jaw.positions) back = std::min(back, p.y());
  formats::Hinge hinge{{0, back - 30, 30}, {1, 0, 0}, {{0, 0}}};
  if (motion == MouthMotion::Opening)
    for (int n = 0; n < 20; ++n) {
      hinge.angles.push_back({4.0 * n + 1, 0});
      hinge.angles.push_back({4.0 * n + 2.5, -8});
      hinge.angles.push_back({4.0 * n + 4, 0});
    }
  scene.bodies.push_back({"mandible", {}, hinge});
  for (const Mouth::Part& part : mouth.parts()) {
    formats::SceneItem object;
    object.name = object.part = part.name;
    object.mesh = "mouth.obj";
    const bool is_lower_tooth = part.name.starts_with("tooth_3") || part.name.starts_with("tooth_4");
    if (is_lower_tooth || part.name == "lower_jaw" || part.name == "tongue") object.body = "mandible";
    if (motion == MouthMotion::Soft) soften(object);
    scene.objects.push_back(std::move(object));
  }
  if (motion == MouthMotion::TwoHands) {
    scene.bodies.push_back({"second_hand", "second_hand.csv", {}});
    formats::SceneItem second;
    second.name = "second_probe";
    second.mesh = "probe.obj";
    second.body = "second_hand";
    scene.objects.push_back(std::move(second));
  }
  return formats::sceneText(scene);
}

Path probePocket(const Mouth& mouth) {
  const MouthTooth& tooth = mouth.teeth[26];  // 46
  const Quaternion hold = holdDown();
  // The crown bulges out over the sulcus: the path in and out is oblique.
  const Vector3d out = tooth.buccal, start = sulcusFloor(tooth, {0, 1}) + 4 * out + Vector3d(0, 0, 12);
  Hand hand({start, hold});
  constexpr int kPlaces = 9;
  for (int i = 0; i < kPlaces; ++i) {
    const Eigen::Vector2d direction = Eigen::Vector2d(0.7 * (2.0 * i / (kPlaces - 1) - 1), 1).normalized();
    const Vector3d floor = sulcusFloor(tooth, direction);
    if (i == 0) hand.moveTo({floor + out + Vector3d(0, 0, 4), hold}, kFree);
    hand.moveTo({floor + 0.2 * out + Vector3d(0, 0, 1.2), hold}, kTouching);
    hand.moveTo({floor - Vector3d(0, 0, 0.3), hold}, kTouching);
    hand.moveTo({floor + 0.2 * out + Vector3d(0, 0, 1.2), hold}, kTouching);
  }
  hand.moveTo({start, hold}, kFree);
  return std::move(hand).path();
}

Path inspectTeeth(const Mouth& mouth) {
  // In the open mouth: the handle points outward, below the upper incisors or above the lower ones.
  const auto centre = [](bool upper) { return Vector3d(0, 30, upper ? 21 : 14); };
  Hand hand({centre(false), holdDown()});
  const auto touch = [&](const MouthTooth& tooth, bool from_mesial, bool is_incisor, const Quaternion& hold) {
    for (int i = -2; i <= 2; ++i) {
      const double mesial = (from_mesial ? -1 : 1) * 0.18 * i * tooth.width;
      const double buccal = is_incisor ? 0.07 * tooth.width : 0;  // the middle of its edge
      const double height = crownHeight(tooth, mesial, buccal) - 0.4;
      hand.moveTo({tooth.centre + mesial * tooth.mesial + buccal * tooth.buccal + height * tooth.occlusal, hold}, kTouching);
    }
  };
  for (const bool upper : {false, true}) {
    const Quaternion hold = upper ? holdUp() : holdDown();
    hand.moveTo({centre(upper), hold}, kFree);
    // Lower: 47 to 41, 31 to 37; upper: 27 to 21, 11 to 17. Quadrants are in `teeth` in the order 1, 2, 3, 4.
    const std::size_t first = upper ? 7 : 21, second = upper ? 0 : 14;
    const MouthTooth& start = mouth.teeth[first + 6];
    hand.moveTo({start.centre + (crownHeight(start, 0, 0) + 3) * start.occlusal, hold}, kFree);
    for (std::size_t i = 7; i-- > 0;) touch(mouth.teeth[first + i], false, i < 2, hold);
    for (std::size_t i = 0; i < 7; ++i) touch(mouth.teeth[second + i], true, i < 2, hold);
    hand.moveTo({centre(upper), hold}, kFree);
  }
  return std::move(hand).path();
}

Path pressTongue() {
  const Quaternion hold = holdDown();
  const Vector3d start(-2, 12, 14);
  Hand hand({start, hold});
  hand.moveTo({{-2, 12, 7}, hold}, kFree);
  hand.moveTo({{-2, 12, 2.6}, hold}, kTouching);
  hand.rest(1000);
  hand.moveTo({{-17, 13, 4}, hold}, kTouching);
  hand.rest(500);
  hand.moveTo({{-13, 12, 9}, hold}, kTouching);
  hand.moveTo({start, hold}, kFree);
  return std::move(hand).path();
}

std::string trajectoryText(const Path& path) {
  std::string text = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n";
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vector3d& p = path[i].position;
    const Quaternion& q = path[i].orientation;
    print(text, "%.3f,%.6f,%.6f,%.6f,%.9f,%.9f,%.9f,%.9f\n", 0.001 * static_cast<double>(i), p.x(), p.y(), p.z(), q.w(), q.x(), q.y(),
          q.z());
  }
  return text;
}

}  // namespace spheretree::samples
