// SPDX-License-Identifier: Apache-2.0
#include "spheretree/tissue/tissue_solver.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "smoothed_elements.h"
#include "spheretree/core/rounding.h"

namespace spheretree::tissue {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr std::size_t kMemory = 8;    // pairs of L-BFGS
constexpr int kMaxHalvings = 12;      // of a step along a direction
constexpr double kSufficient = 1e-4;  // Armijo's constant, as in J. Nocedal, S. Wright, Numerical Optimization
constexpr double kMaxInverted = 0.05;

using Field = std::vector<Vector3d>;

double dot(std::span<const Vector3d> a, std::span<const Vector3d> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

/// The L-BFGS memory: the last moves and the changes of the gradient. Older pairs are overwritten.
struct Lessons {
  std::array<Field, kMemory> moves, changes;
  std::array<double, kMemory> curvature{};
  std::size_t next = 0, count = 0;

  std::size_t at(std::size_t age) const { return (next + kMemory - 1 - age) % kMemory; }
  void forget() { next = count = 0; }
  void keep() {
    next = (next + 1) % kMemory;
    count = std::min(count + 1, kMemory);
  }
};

}  // namespace

struct TissueSolver::State {
  SmoothedElements elements;
  std::vector<std::int32_t> row;  // (nodes) first unknown of a free node; -1: fixed
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> at_rest;
  Field displacement;
  double elastic = 0, last_move = 0;
  std::size_t inverted = 0;
  Lessons lessons;

  // Scratch memory, (nodes) each.
  Field now, trial, gradient, trial_gradient, direction;
  Eigen::VectorXd right, solution;

  explicit State(const Tissue& tissue) : elements(tissue) {}
  bool factorise(const Tissue& tissue);
  double total(const Field& u, std::span<const Vector3d> forces, Field& out);
  void solveAtRest(Field& v);
  void precondition(Field& v);
  void findDirection();
  double iterate(std::span<const Vector3d> forces, double& value);
  bool run(std::span<const Vector3d> forces, double tolerance, int max_iterations);
};

// Uses plain linear tetrahedra: they are stiffer than the energy at rest, so that full steps seldom overshoot.
bool TissueSolver::State::factorise(const Tissue& tissue) {
  std::vector<char> fixed(tissue.nodes.size(), 0);
  for (const std::uint32_t node : tissue.fixed) fixed[node] = 1;
  std::int32_t rows = 0;
  for (const char is_fixed : fixed) row.push_back(is_fixed ? -1 : 3 * rows++);
  if (rows == 0) return false;
  const double nu = tissue.material.poisson, mu = elements.mu(), lambda = 2 * mu * nu / (1 - 2 * nu);
  std::vector<Eigen::Triplet<double>> entries;
  for (const Element& e : elements.elements()) {
    Eigen::Matrix<double, 3, 4> g;
    g.rightCols<3>() = e.inverse.transpose();
    g.col(0) = -(g.col(1) + g.col(2) + g.col(3));
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        const std::int32_t i = row[e.corner[static_cast<std::size_t>(a)]], j = row[e.corner[static_cast<std::size_t>(b)]];
        if (i < 0 || j < 0 || j > i) continue;
        const Matrix3d k = e.volume * (lambda * g.col(a) * g.col(b).transpose() + mu * g.col(b) * g.col(a).transpose() +
                                       mu * g.col(a).dot(g.col(b)) * Matrix3d::Identity());
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c)
            if (j + c <= i + r) entries.emplace_back(i + r, j + c, k(r, c));
      }
  }
  Eigen::SparseMatrix<double> matrix(3 * rows, 3 * rows);
  matrix.setFromTriplets(entries.begin(), entries.end());
  at_rest.compute(matrix);
  const Field zero(tissue.nodes.size(), Vector3d::Zero());
  displacement = now = trial = gradient = trial_gradient = direction = zero;
  lessons.moves.fill(zero), lessons.changes.fill(zero);
  right.resize(3 * rows), solution.resize(3 * rows);
  if (at_rest.info() != Eigen::Success) return false;
  // The matrix of a part without fixed nodes has a pivot that is only rounding.
  const Eigen::VectorXd pivots = at_rest.matrixL().nestedExpression().diagonal();
  return pivots.allFinite() && pivots.minCoeff() > 1e-6 * pivots.maxCoeff();
}

// The minimised sum and its gradient.
double TissueSolver::State::total(const Field& u, std::span<const Vector3d> forces, Field& out) {
  double sum = elements.energy(u, out);
  for (std::size_t i = 0; i < u.size(); ++i) {
    if (row[i] < 0) {
      out[i].setZero();
      continue;
    }
    sum -= forces[i].dot(u[i]);
    out[i] -= forces[i];
  }
  return sum;
}

void TissueSolver::State::solveAtRest(Field& v) {
  for (std::size_t i = 0; i < v.size(); ++i)
    if (row[i] >= 0) right.segment<3>(row[i]) = v[i];
  solution = at_rest.permutationP() * right;
  at_rest.matrixL().solveInPlace(solution);
  at_rest.matrixU().solveInPlace(solution);
  right = at_rest.permutationPinv() * solution;
  for (std::size_t i = 0; i < v.size(); ++i)
    if (row[i] >= 0) v[i] = right.segment<3>(row[i]);
}

// H^-1 v by the two loops of L-BFGS.
void TissueSolver::State::precondition(Field& v) {
  std::array<double, kMemory> alpha{};
  for (std::size_t age = 0; age < lessons.count; ++age) {
    const std::size_t m = lessons.at(age);
    alpha[m] = dot(lessons.moves[m], v) / lessons.curvature[m];
    for (std::size_t i = 0; i < v.size(); ++i) v[i] -= alpha[m] * lessons.changes[m][i];
  }
  solveAtRest(v);
  for (std::size_t age = lessons.count; age-- > 0;) {
    const std::size_t m = lessons.at(age);
    const double beta = dot(lessons.changes[m], v) / lessons.curvature[m];
    for (std::size_t i = 0; i < v.size(); ++i) v[i] += (alpha[m] - beta) * lessons.moves[m][i];
  }
}

void TissueSolver::State::findDirection() {
  for (std::size_t i = 0; i < direction.size(); ++i) direction[i] = -gradient[i];
  precondition(direction);
}

// One iteration from `now`, whose value and gradient are known. Returns the largest move of a node; 0 if the sum cannot
// decrease any more.
double TissueSolver::State::iterate(std::span<const Vector3d> forces, double& value) {
  findDirection();
  double slope = dot(gradient, direction);
  if (!(slope < 0)) {  // the memory of other places is misleading here
    lessons.forget();
    findDirection();
    slope = dot(gradient, direction);
    if (!(slope < 0)) return 0;
  }
  double share = 1;
  for (int halving = 0; halving <= kMaxHalvings; ++halving, share /= 2) {
    for (std::size_t i = 0; i < now.size(); ++i) trial[i] = now[i] + share * direction[i];
    const double reached = total(trial, forces, trial_gradient);
    if (!(reached <= value + kSufficient * share * slope + kRounding * std::abs(value))) continue;
    Field &moves = lessons.moves[lessons.next], &changes = lessons.changes[lessons.next];
    double largest2 = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
      moves[i] = trial[i] - now[i];
      changes[i] = trial_gradient[i] - gradient[i];
      largest2 = std::max(largest2, moves[i].squaredNorm());
    }
    const double curvature = dot(moves, changes);
    lessons.curvature[lessons.next] = curvature;
    if (curvature > 1e-10 * std::sqrt(dot(moves, moves) * dot(changes, changes))) lessons.keep();
    now.swap(trial);
    gradient.swap(trial_gradient);
    value = reached;
    return std::sqrt(largest2);
  }
  lessons.forget();
  return 0;
}

bool TissueSolver::State::run(std::span<const Vector3d> forces, double tolerance, int max_iterations) {
  const auto isFinite = [](const Vector3d& v) { return v.allFinite(); };
  if (forces.size() != displacement.size() || !std::all_of(forces.begin(), forces.end(), isFinite)) return false;
  now = displacement;
  double value = total(now, forces, gradient);
  last_move = 0;
  for (int k = 0; k < max_iterations; ++k) {
    last_move = iterate(forces, value);
    if (last_move <= tolerance) break;
  }
  const std::size_t count = elements.inverted(now);
  if (!std::isfinite(value) || !std::all_of(now.begin(), now.end(), isFinite) ||
      static_cast<double>(count) > kMaxInverted * static_cast<double>(elements.elements().size())) {
    lessons.forget();
    return false;
  }
  inverted = count;
  elastic = value;
  for (std::size_t i = 0; i < now.size(); ++i)
    if (row[i] >= 0) elastic += forces[i].dot(now[i]);
  displacement = now;
  return true;
}

TissueSolver::TissueSolver(std::unique_ptr<State> state) : state_(std::move(state)) {}
TissueSolver::~TissueSolver() = default;

std::unique_ptr<TissueSolver> TissueSolver::make(const Tissue& tissue, std::string& fault) {
  fault = findFault(tissue);
  if (!fault.empty()) return nullptr;
  auto state = std::make_unique<State>(tissue);
  if (!state->factorise(tissue)) {
    fault = "the stiffness matrix of the tissue is singular: a part of it is not held, or nothing can move";
    return nullptr;
  }
  return std::unique_ptr<TissueSolver>(new TissueSolver(std::move(state)));
}

bool TissueSolver::advance(std::span<const Vector3d> forces, int iterations) noexcept { return state_->run(forces, -1, iterations); }

bool TissueSolver::settle(std::span<const Vector3d> forces, double tolerance, int max_iterations) noexcept {
  return state_->run(forces, tolerance, max_iterations) && state_->last_move <= tolerance;
}

void TissueSolver::reset() noexcept {
  State& s = *state_;
  std::fill(s.displacement.begin(), s.displacement.end(), Vector3d::Zero());
  s.elements.reset();
  s.lessons.forget();
  s.elastic = s.last_move = 0;
  s.inverted = 0;
}

std::span<const Vector3d> TissueSolver::displacements() const { return state_->displacement; }
double TissueSolver::energy() const { return state_->elastic; }
std::size_t TissueSolver::inverted() const { return state_->inverted; }

std::vector<Vector3d> TissueSolver::elasticForces() {
  Field gradient(state_->displacement.size(), Vector3d::Zero());
  state_->elements.energy(state_->displacement, gradient);
  for (Vector3d& g : gradient) g = -g;
  return gradient;
}

}  // namespace spheretree::tissue
