// SPDX-License-Identifier: GPL-3.0-or-later
#include "model/stage.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>

namespace spheretree::view {
namespace {

// M. Okabe, K. Ito, Color universal design, 2008; without black and yellow, lightened.
constexpr std::array<Colour, 8> kHues{{{120, 170, 215, 255},
                                       {226, 150, 92, 255},
                                       {116, 190, 160, 255},
                                       {222, 196, 120, 255},
                                       {190, 150, 200, 255},
                                       {130, 200, 214, 255},
                                       {214, 130, 130, 255},
                                       {176, 190, 126, 255}}};

Colour shaded(Colour c, int tone) {
  const double share = 0.84 + 0.08 * tone;
  const auto scaled = [share](std::uint8_t v) { return static_cast<std::uint8_t>(std::clamp(std::lround(share * v), 0L, 255L)); };
  return {scaled(c.r), scaled(c.g), scaled(c.b), c.a};
}

/// (nodes) child of the root from which each node descends.
std::vector<std::uint32_t> families(const SphereTree& tree) {
  std::vector<std::uint32_t> family(tree.nodeCount());
  for (std::uint32_t node = 0; node < tree.nodeCount(); ++node)
    for (std::uint32_t k = 0; k < tree.child_count[node]; ++k) family[tree.first_child[node] + k] = node == 0 ? k : family[node];
  return family;
}

void addSpheres(Body& body, const SphereTree& tree) {
  const std::vector<std::uint32_t> family = families(tree);
  const auto ball = [&](std::uint32_t node, SphereKind kind) {
    const Sphere& s = sphereOf(tree, node, kind);
    return Ball{static_cast<float>(s.x + tree.origin_mm[0]), static_cast<float>(s.y + tree.origin_mm[1]),
                static_cast<float>(s.z + tree.origin_mm[2]), s.radius,
                shaded(kHues[family[node] % kHues.size()], static_cast<int>(2 * node + node / 8) % 5)};
  };
  for (int level = 0; level < tree.levelCount(); ++level) {
    std::vector<Ball>& cover = body.levels.emplace_back();
    std::vector<Ball>& bound = body.bounds.emplace_back();
    for (const std::uint32_t node : levelSet(tree, level)) {
      cover.push_back(ball(node, SphereKind::Cover));
      bound.push_back(ball(node, SphereKind::Bound));
    }
  }
}

}  // namespace

Eigen::Vector3d Stage::centre() const {
  Eigen::AlignedBox3d all;
  for (const PlacedObject& object : objects) {
    const Body& body = bodies[object.body];
    if (body.box.isEmpty()) continue;
    all.extend(object.pose.position + object.pose.orientation * body.box.center());
  }
  return all.isEmpty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(all.center());
}

double Stage::radius() const {
  const Eigen::Vector3d middle = centre();
  double radius = 0;
  for (const PlacedObject& object : objects) {
    const Body& body = bodies[object.body];
    if (body.box.isEmpty()) continue;
    const Eigen::Vector3d at = object.pose.position + object.pose.orientation * body.box.center();
    radius = std::max(radius, (at - middle).norm() + body.box.sizes().norm() / 2);
  }
  return radius > 0 ? radius : 1;
}

double Stage::toolReach() const {
  if (!tool || bodies[*tool].box.isEmpty()) return 0;
  double reach = 0;
  for (int corner = 0; corner < 8; ++corner)
    reach = std::max(reach, (bodies[*tool].box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)) - reference_point).norm());
  return reach;
}

Eigen::Vector3d Stage::toolMark() const {
  Eigen::Vector3d mark = Eigen::Vector3d::Zero();
  if (!tool || bodies[*tool].levels.empty()) return mark;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Ball& ball : bodies[*tool].levels.back()) {
    const Eigen::Vector3d centre = Eigen::Vector3d(ball.x, ball.y, ball.z) - reference_point;
    const double gap = centre.norm() - static_cast<double>(ball.radius);
    if (gap <= 0) return Eigen::Vector3d::Zero();
    if (gap < nearest) nearest = gap, mark = centre;
  }
  return mark;
}

int Stage::levelCount() const {
  std::size_t count = 0;
  for (const Body& body : bodies) count = std::max(count, body.levels.size());
  return static_cast<int>(count);
}

Colour colourOf(const std::string& name, std::size_t index) {
  struct Kind {
    const char* word;
    Colour colour;
  };
  constexpr std::array<Kind, 7> kKinds{{{"tooth", {238, 226, 200, 255}},
                                        {"molar", {238, 226, 200, 255}},
                                        {"jaw", {216, 138, 138, 255}},
                                        {"gum", {216, 138, 138, 255}},
                                        {"tongue", {196, 98, 104, 255}},
                                        {"face", {214, 176, 150, 255}},
                                        {"probe", {176, 188, 204, 255}}}};
  std::string lower;
  for (const char c : name) lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const Kind& kind : kKinds)
    if (lower.find(kind.word) != std::string::npos) return kind.colour;
  return kHues[index % kHues.size()];
}

Colour layerColour(std::size_t index, Colour object) {
  constexpr std::array<Colour, 7> kLayers{{{230, 159, 0, 255},
                                           {0, 114, 178, 255},
                                           {204, 121, 167, 255},
                                           {0, 158, 115, 255},
                                           {240, 228, 66, 255},
                                           {86, 180, 233, 255},
                                           {213, 94, 0, 255}}};
  return index == 0 ? object : kLayers[(index - 1) % kLayers.size()];
}

Configuration poseOf(const PlacedObject& object, std::span<const Configuration> carriers) {
  return object.carrier == 0 || object.carrier > carriers.size() ? object.pose : composed(carriers[object.carrier - 1], object.pose);
}

Colour heat(double share) {
  constexpr std::array<Colour, 6> kStops{
      {{58, 20, 92, 255}, {62, 72, 150, 255}, {38, 124, 150, 255}, {48, 168, 122, 255}, {150, 206, 70, 255}, {250, 230, 60, 255}}};
  const double at = std::clamp(share, 0.0, 1.0) * (kStops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const double t = at - static_cast<double>(i);
  return mixed(kStops[i], kStops[i + 1], t);
}

Body bodyOf(std::string name, const SphereTree* tree, const TriangleMesh* mesh, Colour colour) {
  Body body;
  body.name = std::move(name);
  body.colour = colour;
  if (mesh) {
    body.mesh = surfaceOf(*mesh);
    for (const Eigen::Vector3d& p : mesh->positions) body.box.extend(p);
  }
  if (!tree) return body;
  addSpheres(body, *tree);
  if (!tree->statistics.empty()) body.overhang = static_cast<double>(tree->statistics.back().overhang_bound);
  body.skin = surfaceOf(tree->skin);
  const Eigen::Vector3f origin(static_cast<float>(tree->origin_mm[0]), static_cast<float>(tree->origin_mm[1]),
                               static_cast<float>(tree->origin_mm[2]));
  for (SurfaceCorner& corner : body.skin.corners) corner.position += origin;
  if (body.box.isEmpty())
    for (const Ball& ball : body.levels.back()) {
      const Eigen::Vector3d c(ball.x, ball.y, ball.z);
      body.box.extend(Eigen::AlignedBox3d(c.array() - ball.radius, c.array() + ball.radius));
    }
  return body;
}

}  // namespace spheretree::view
