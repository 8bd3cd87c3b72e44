// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/start_pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "pipeline/split/tooth_numbers.h"

namespace spheretree::player {
namespace {

using Eigen::Vector3d;
constexpr double kAbove = 2, kFree = 0.5;  // of the reference point over the crown; of the tool from everything [mm]

std::string toothName(int fdi) {
  constexpr std::array<const char*, 8> kPermanent{"central incisor", "lateral incisor", "canine",       "first premolar",
                                                  "second premolar", "first molar",     "second molar", "third molar"};
  constexpr std::array<const char*, 5> kDeciduous{"central incisor", "lateral incisor", "canine", "first molar", "second molar"};
  const int quadrant = fdi / 10;
  const auto tooth = static_cast<std::size_t>(fdi % 10 - 1);
  const bool is_right = quadrant % 4 == 1 || quadrant % 4 == 0;
  return std::string(pipeline::isUpperFdi(fdi) ? "upper " : "lower ") + (is_right ? "right " : "left ") +
         (quadrant > 4 ? std::string("deciduous ") + kDeciduous[tooth] : kPermanent[tooth]);
}

Vector3d centreOf(const view::Ball& ball) { return {ball.x, ball.y, ball.z}; }

/// The point of the tool, relative to its reference point, that is to be over the tooth, at this orientation: the
/// reference point, or the point that is lowest towards -`out` where the reference point lies beside the tool.
Vector3d touchingPoint(const view::Stage& stage, const Quaternion& orientation, const Vector3d& out) {
  Vector3d lowest = Vector3d::Zero();
  if (stage.toolMark() == lowest) return lowest;
  double height = std::numeric_limits<double>::infinity();
  for (const view::Ball& leaf : stage.bodies[*stage.tool].levels.back()) {
    const Vector3d at = orientation * (centreOf(leaf) - stage.reference_point) - static_cast<double>(leaf.radius) * out;
    if (at.dot(out) < height) height = at.dot(out), lowest = at;
  }
  return lowest;
}

/// Whether the tool at this pose of its reference point is at least kFree from all leaves.
bool isFree(const view::Stage& stage, const Configuration& pose) {
  for (const view::PlacedObject& object : stage.objects) {
    const view::Body& body = stage.bodies[object.body];
    if (body.levels.empty()) continue;
    const Quaternion back = object.pose.orientation.conjugate();
    const Vector3d middle = body.box.center();
    const double radius = 0.6 * body.box.sizes().norm();  // leaves reach a little beyond the box
    for (const view::Ball& leaf : stage.bodies[*stage.tool].levels.back()) {
      const Vector3d at = back * (pose.position + pose.orientation * (centreOf(leaf) - stage.reference_point) - object.pose.position);
      const double reach = static_cast<double>(leaf.radius) + kFree;
      if ((at - middle).norm() > radius + reach) continue;
      for (const view::Ball& ball : body.levels.back())
        if ((at - centreOf(ball)).norm() < reach + static_cast<double>(ball.radius)) return false;
    }
  }
  return true;
}

}  // namespace

void readTooth(view::Body& body) {
  std::string name;
  for (const char c : body.name) name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const char* word : {"tooth", "molar", "incisor", "canine", "fdi"})
    body.is_tooth = body.is_tooth || name.find(word) != std::string::npos;
  if (!body.is_tooth) return;
  const int number = pipeline::labelOfName(body.name, "fdi").value_or(0);
  if (!pipeline::isFdi(number)) return;
  body.fdi = number;
  body.meaning = "FDI " + std::to_string(number) + ": " + toothName(number);
}

std::optional<StartOverTooth> startOverTooth(const view::Stage& stage) {
  if (!stage.tool || stage.bodies[*stage.tool].levels.empty()) return std::nullopt;
  std::vector<const view::PlacedObject*> teeth;
  for (const view::PlacedObject& object : stage.objects)
    if (stage.bodies[object.body].is_tooth && !stage.bodies[object.body].levels.empty()) teeth.push_back(&object);
  const auto isUpper = [&](const view::PlacedObject* tooth) { return pipeline::isUpperFdi(stage.bodies[tooth->body].fdi); };
  const auto rank = [&](const view::PlacedObject* tooth) {  // lower first molars, upper ones, the others
    return stage.bodies[tooth->body].fdi % 10 == 6 ? (isUpper(tooth) ? 1 : 0) : 2;
  };
  std::stable_sort(teeth.begin(), teeth.end(), [&](const auto* a, const auto* b) { return rank(a) < rank(b); });
  constexpr std::size_t kTried = 8;  // teeth: if the tool fits over none of these, the scene leaves it no room
  if (teeth.size() > kTried) teeth.resize(kTried);
  const Vector3d up = stage.y_up ? Vector3d::UnitY() : Vector3d::UnitZ();
  for (const view::PlacedObject* tooth : teeth) {
    const view::Body& body = stage.bodies[tooth->body];
    const Vector3d out = isUpper(tooth) ? Vector3d(-up) : up;  // from the roots to the crown
    Vector3d crown = Vector3d::Zero();
    double highest = -std::numeric_limits<double>::infinity();
    for (const view::Ball& ball : body.levels.back()) {
      const Vector3d top = tooth->pose.position + tooth->pose.orientation * centreOf(ball) + static_cast<double>(ball.radius) * out;
      if (top.dot(out) > highest) highest = top.dot(out), crown = top;
    }
    const Quaternion upright = Quaternion::FromTwoVectors(Vector3d::UnitZ(), out);
    for (int tilt = 0; tilt <= 8; ++tilt)  // 0: none
      for (int roll = 0; roll < 4; ++roll) {
        constexpr double kQuarter = std::numbers::pi / 2;
        const double azimuth = kQuarter / 2 * (tilt - 1);
        const Vector3d axis(std::cos(azimuth), std::sin(azimuth), 0);
        const Quaternion inclined = tilt == 0 ? Quaternion(1, 0, 0, 0) : rotationOf(std::numbers::pi / 3 * axis);
        const Quaternion orientation = upright * inclined * rotationOf({0, 0, kQuarter * roll});
        const Configuration pose{crown + kAbove * out - touchingPoint(stage, orientation, out), orientation};
        if (isFree(stage, pose)) return StartOverTooth{pose, crown};
      }
  }
  return std::nullopt;
}

}  // namespace spheretree::player
