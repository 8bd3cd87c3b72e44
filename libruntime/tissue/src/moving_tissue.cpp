// SPDX-License-Identifier: Apache-2.0
#include "spheretree/tissue/moving_tissue.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace spheretree::tissue {

using Eigen::Vector3d;

namespace {

constexpr double kLeastPart = 0.05;  // of a way, that is gone at least
constexpr double kRounding = 1e-6;   // of an extent: what floats lose on the way from here to a leaf in a step
constexpr double kSmallMove = 0.02;  // of the node that moves most: how leaves move over it is a derivative [mm]

using Face = std::array<std::uint32_t, 3>;

/// The faces of one tetrahedron alone.
std::vector<Face> outerFaces(const Tissue& tissue) {
  std::vector<Face> faces;
  for (const auto& c : tissue.tetrahedra)
    for (std::size_t k = 0; k < 4; ++k) {
      Face face{c[(k + 1) % 4], c[(k + 2) % 4], c[(k + 3) % 4]};
      std::sort(face.begin(), face.end());
      faces.push_back(face);
    }
  std::sort(faces.begin(), faces.end());
  std::vector<Face> outer;
  for (std::size_t i = 0; i < faces.size(); ++i)
    if ((i == 0 || faces[i - 1] != faces[i]) && (i + 1 == faces.size() || faces[i + 1] != faces[i])) outer.push_back(faces[i]);
  return outer;
}

}  // namespace

MovingTissue::MovingTissue(const Tissue& tissue, std::unique_ptr<TissueSolver> solver)
    : tissue_(tissue),
      solver_(std::move(solver)),
      forces_(tissue.nodes.size()),
      positions_(tissue.surface.size()),
      response_(3 * tissue.response.pressed.size()) {
  // A traction that is largest at the node and zero at its neighbours, over the triangles round it: of each triangle's
  // share a half is on the node itself, and a quarter on either other corner.
  const std::vector<std::uint32_t>& pressed = tissue.response.pressed;
  const auto at = [&](std::uint32_t node) { return Vector3d(tissue.nodes[node].data()); };
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> weights;
  std::vector<double> area(tissue.nodes.size(), 0);
  for (const Face& f : outerFaces(tissue)) {
    const double a = (at(f[1]) - at(f[0])).cross(at(f[2]) - at(f[0])).norm();
    for (const std::uint32_t on : f) {
      area[on] += a;
      for (const std::uint32_t to : f) weights[{on, to}] += (on == to ? 0.5 : 0.25) * a;
    }
  }
  for (const auto& [pair, weight] : weights) {
    const auto found = std::lower_bound(pressed.begin(), pressed.end(), pair.first);
    if (found != pressed.end() && *found == pair.first && area[pair.first] > 0)
      shares_.push_back({static_cast<std::uint32_t>(found - pressed.begin()), pair.second, weight / area[pair.first]});
  }
  moved_ = shifted_ = averaged_ = forces_;
  shifted_leaves_.resize(tissue.leaves.anchors.size());
  const TissueState rest = restState();
  tangent_ = rest.tangent;
  rest_ = last_ = rest.leaves;
  ways_.assign(rest_.size(), Eigen::Vector4f::Zero());
}

std::unique_ptr<MovingTissue> MovingTissue::make(const Tissue& tissue, std::string& fault) {
  std::unique_ptr<TissueSolver> solver = TissueSolver::make(tissue, fault);
  if (fault.empty() && tissue.response.empty()) fault = "the tissue has no response to forces";
  if (!fault.empty()) return nullptr;
  return std::unique_ptr<MovingTissue>(new MovingTissue(tissue, std::move(solver)));
}

TissueState MovingTissue::restState() const {
  TissueState state;
  state.displacements.assign(tissue_.nodes.size(), Vector3d::Zero());
  state.leaves.resize(tissue_.leaves.anchors.size());
  std::vector<Vector3d> positions(tissue_.surface.size());
  moveSurface(tissue_, state.displacements, positions);
  moveLeaves(tissue_, state.displacements, positions, state.leaves);
  state.tangent.load.assign(response_.size(), 0.0f);
  state.tangent.rates.assign(state.leaves.size(), Sphere{0, 0, 0, 0});
  return state;
}

void MovingTissue::reset() noexcept {
  solver_->reset();
  std::fill(moved_.begin(), moved_.end(), Vector3d::Zero());
  last_ = rest_;
  std::fill(ways_.begin(), ways_.end(), Eigen::Vector4f::Zero());
  part_ = 1;
  std::fill(response_.begin(), response_.end(), 0.0f);
  std::fill(tangent_.load.begin(), tangent_.load.end(), 0.0f);
  std::fill(tangent_.rates.begin(), tangent_.rates.end(), Sphere{0, 0, 0, 0});
}

void MovingTissue::advance(std::span<const float> forces, TissueState& state) noexcept {
  std::fill(forces_.begin(), forces_.end(), Vector3d::Zero());
  for (const Share& s : shares_) {
    const float* const f = forces.data() + 3 * std::size_t{s.pressed};
    forces_[s.node] += s.weight * Vector3d(f[0], f[1], f[2]);
  }
  state.is_frozen = !solver_->advance(forces_, kIterations);
  makeState(forces, state);
}

// The leaves when the solver's nodes have moved by `nodes`; those of the surface move by the mean that C is made for.
void MovingTissue::place(std::span<const Vector3d> nodes, std::vector<Vector3d>& displacements, std::vector<Sphere>& leaves) noexcept {
  std::copy(nodes.begin(), nodes.end(), displacements.begin());
  for (const std::uint32_t node : tissue_.response.pressed) displacements[node].setZero();
  for (const Share& s : shares_) displacements[tissue_.response.pressed[s.pressed]] += s.weight * nodes[s.node];
  moveSurface(tissue_, displacements, positions_);
  moveLeaves(tissue_, displacements, positions_, leaves);
}

// Of the point of a leaf, by C, under the forces of the last good state.
Vector3d MovingTissue::give(std::size_t leaf) const { return tissue_.response.points[leaf].displacementIn(response_); }

void MovingTissue::makeState(std::span<const float> forces, TissueState& state) noexcept {
  place(solver_->displacements(), state.displacements, state.leaves);
  if (!state.is_frozen) {  // else it is not the state of these forces: what they do is left to the steps
    predict(forces);
    const TissueResponse& response = tissue_.response;
    std::fill(response_.begin(), response_.end(), 0.0f);
    for (std::size_t i = 0; i < forces.size(); ++i) {
      if (forces[i] == 0) continue;
      const std::span<const float> column = response.column(i / 3, i % 3);
      for (std::size_t k = 0; k < column.size(); ++k) response_[k] += forces[i] * column[k];
    }
    findTangent(forces, state.leaves);
    for (std::size_t leaf = 0; leaf < state.leaves.size(); ++leaf) {
      Sphere& s = state.leaves[leaf];
      const Vector3d by_c = give(leaf), centre = Vector3d(s.x, s.y, s.z) - by_c;
      const double extent = centre.cwiseAbs().maxCoeff() + by_c.cwiseAbs().maxCoeff();
      s = {static_cast<float>(centre.x()), static_cast<float>(centre.y()), static_cast<float>(centre.z()),
           s.radius + static_cast<float>(kRounding * extent)};
    }
    relax(state.leaves);
  }
  std::copy(last_.begin(), last_.end(), state.leaves.begin());
  std::copy(tangent_.load.begin(), tangent_.load.end(), state.tangent.load.begin());
  std::copy(tangent_.rates.begin(), tangent_.rates.end(), state.tangent.rates.begin());
}

// Where the steps have the leaves under these forces, by what was given out last.
void MovingTissue::predict(std::span<const float> forces) noexcept {
  float change = -1;
  for (std::size_t i = 0; i < forces.size(); ++i) change += tangent_.load[i] * forces[i];
  for (std::size_t i = 0; i < last_.size(); ++i) {
    const Sphere& rate = tangent_.rates[i];
    Sphere& s = last_[i];
    s = {s.x + change * rate.x, s.y + change * rate.y, s.z + change * rate.z, s.radius + change * rate.radius};
  }
}

// The amount of a load weighs forces by how the rest responds to the load: f . C load / (load . C load).
void MovingTissue::findTangent(std::span<const float> forces, std::span<const Sphere> leaves) noexcept {
  std::fill(tangent_.load.begin(), tangent_.load.end(), 0.0f);
  std::fill(tangent_.rates.begin(), tangent_.rates.end(), Sphere{0, 0, 0, 0});
  double work = 0, largest = 0;
  for (std::size_t i = 0; i < forces.size(); ++i) work += static_cast<double>(forces[i]) * static_cast<double>(response_[i]);
  if (!(work > 0) || !solver_->respond(forces_, kTangentIterations, moved_)) return;
  for (const Vector3d& v : moved_) largest = std::max(largest, v.norm());
  if (!(largest > 0 && std::isfinite(largest))) return;
  const double small = kSmallMove / largest;
  for (std::size_t i = 0; i < moved_.size(); ++i) shifted_[i] = solver_->displacements()[i] + small * moved_[i];
  place(shifted_, averaged_, shifted_leaves_);
  const auto rate = [&](float to, float from) { return (static_cast<double>(to) - static_cast<double>(from)) / small; };
  for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
    const Sphere &to = shifted_leaves_[leaf], &from = leaves[leaf];
    const Vector3d centre = Vector3d(rate(to.x, from.x), rate(to.y, from.y), rate(to.z, from.z)) - give(leaf);
    tangent_.rates[leaf] = {static_cast<float>(centre.x()), static_cast<float>(centre.y()), static_cast<float>(centre.z()),
                            static_cast<float>(rate(to.radius, from.radius))};
  }
  for (std::size_t i = 0; i < forces.size(); ++i) tangent_.load[i] = static_cast<float>(static_cast<double>(response_[i]) / work);
}

// As far towards the new leaves as the last two ways say: where steps and solver would answer each other to and fro,
// less. On the way between two sets of leaves the balls hold the surface on its way between two states.
// Paper: U. Kuettler, W. Wall. Fixed-point fluid-structure interaction solvers with dynamic relaxation. Computational
//        Mechanics 43, 2008 (Aitken's factor).
void MovingTissue::relax(std::span<const Sphere> leaves) noexcept {
  double along = 0, square = 0;
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const Eigen::Vector4f way(leaves[i].x - last_[i].x, leaves[i].y - last_[i].y, leaves[i].z - last_[i].z,
                              leaves[i].radius - last_[i].radius);
    const Eigen::Vector4f change = way - ways_[i];
    along += static_cast<double>(ways_[i].dot(change));
    square += static_cast<double>(change.squaredNorm());
    ways_[i] = way;
  }
  if (square > 0) part_ = std::clamp(-part_ * along / square, kLeastPart, 1.0);
  const auto part = static_cast<float>(part_);
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const Eigen::Vector4f& way = ways_[i];
    Sphere& s = last_[i];
    s = {s.x + part * way[0], s.y + part * way[1], s.z + part * way[2], s.radius + part * way[3]};
  }
}

}  // namespace spheretree::tissue
