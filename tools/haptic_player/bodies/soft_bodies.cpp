// SPDX-License-Identifier: GPL-3.0-or-later
// Boxes of soft tissue for the scenarios: tetrahedra by formula, so that no mesher is needed.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "bodies/scenario_shapes.h"
#include "spheretree/builder/soften_tree.h"

namespace spheretree::player {
namespace {

using Eigen::Vector3d;

struct SoftRecipe {
  Eigen::AlignedBox3d box;
  std::array<std::uint32_t, 3> cells;
  double young;                                  // [kPa]
  std::function<bool(const Vector3d&)> is_held;  // the fixed part
};

const std::map<std::string, SoftRecipe>& softRecipes() {
  static const std::map<std::string, SoftRecipe> all{
      {"soft_block", {{Vector3d(-12, -10, -12), Vector3d(12, 10, 0)}, {8, 6, 4}, 15, [](const Vector3d& p) { return p.z() < -11.9; }}},
      {"cheek",
       {{Vector3d(-15, -15, -1), Vector3d(15, 15, 1)},
        {10, 10, 2},
        30,
        [](const Vector3d& p) { return std::max(std::abs(p.x()), std::abs(p.y())) > 14.9; }}},
  };
  return all;
}

/// The box in cells of six tetrahedra each, around their diagonal (H. Freudenthal, Annals of Mathematics 43, 1942):
/// from corner to corner along the axes, in each order of the axes. Diagonals of adjacent cells match.
TetrahedronList fill(const Eigen::AlignedBox3d& box, const std::array<std::uint32_t, 3>& cells) {
  TetrahedronList solid;
  const auto at = [&](const std::array<std::uint32_t, 3>& p) { return (p[2] * (cells[1] + 1) + p[1]) * (cells[0] + 1) + p[0]; };
  const auto forAll = [](const std::array<std::uint32_t, 3>& count, const auto& visit) {
    for (std::uint32_t z = 0; z < count[2]; ++z)
      for (std::uint32_t y = 0; y < count[1]; ++y)
        for (std::uint32_t x = 0; x < count[0]; ++x) visit(std::array<std::uint32_t, 3>{x, y, z});
  };
  forAll({cells[0] + 1, cells[1] + 1, cells[2] + 1}, [&](const std::array<std::uint32_t, 3>& p) {
    Vector3d node = box.min();
    for (int k = 0; k < 3; ++k) node[k] += box.sizes()[k] * p[static_cast<std::size_t>(k)] / cells[static_cast<std::size_t>(k)];
    solid.nodes.push_back(node);
  });
  forAll(cells, [&](const std::array<std::uint32_t, 3>& low) {
    std::array<std::size_t, 3> order{0, 1, 2};
    do {
      std::array<std::uint32_t, 3> p = low;
      std::array<std::uint32_t, 4> corner{at(p)};
      for (std::size_t i = 0; i < 3; ++i) ++p[order[i]], corner[i + 1] = at(p);
      if ((order[1] + 3 - order[0]) % 3 == 2) std::swap(corner[2], corner[3]);  // odd orders have negative volume
      solid.corners.push_back(corner);
    } while (std::next_permutation(order.begin(), order.end()));
  });
  return solid;
}

}  // namespace

const Body& BodyLibrary::getSoft(const std::string& name) {
  const std::lock_guard lock(made_->mutex);
  const std::string known = variant_ == 0 ? name : name + " " + std::to_string(variant_);
  if (const auto found = made_->bodies.find(known); found != made_->bodies.end()) return *found->second;
  const SoftRecipe& recipe = softRecipes().at(name);
  const BodyFrame frame = frameOf(name);
  const auto put = [&](std::vector<Vector3d>& points) {
    for (Vector3d& p : points) p = frame.scale * (frame.turn * p);
  };
  TriangleMesh boundary = box(recipe.box.min(), recipe.box.max());
  TriangleMesh mesh = refined(boundary, [](const Vector3d&) { return 2.5; });
  TetrahedronList solid = fill(recipe.box, recipe.cells);
  put(boundary.positions), put(mesh.positions), put(solid.nodes);

  builder::BuildSettings settings;
  settings.quality = quality_;
  settings.levels = 4;
  settings.soft_share = 0.5;
  settings.seed += variant_;
  make(known, mesh, settings, frame);
  Body& body = *made_->bodies.at(known);
  // The same force causes `scale` times the displacement.
  const TissueMaterial material{recipe.young / (frame.scale * frame.scale), 0.45, 1040};
  const auto is_held = [&](const Vector3d& p) { return recipe.is_held(frame.turn.conjugate() * p / frame.scale); };
  const auto tissue =
      std::make_shared<const Tissue>(builder::softenTree(body.mesh, body.tree, boundary, solid, material, is_held, progress_));
  SoftPart soft{body.tree, nullptr};
  std::string fault;
  soft.model = runtime::tissueModel(soft.tree, tissue, fault);
  if (!soft.model) throw std::runtime_error(fault);
  body.soft = std::move(soft);
  return body;
}

}  // namespace spheretree::player
