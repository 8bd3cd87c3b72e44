// SPDX-License-Identifier: Apache-2.0
#include "contact/contact_system.h"

#include <algorithm>
#include <cmath>

namespace spheretree::runtime {
namespace {

constexpr double kYield = 1e-9;  // relative compliance that is added to each force, so that equal rows have one solution

}  // namespace

// An entry of J J^T + E E^T.
double ContactSystem::product(std::size_t i, std::size_t j) const {
  const auto side = [&](std::size_t k) -> const Vector6& {
    return k < rows ? problem.rows[k].a : problem.discs[(k - rows) / 2].across[(k - rows) % 2];
  };
  double sum = side(i).dot(side(j));
  if (i >= rows || j >= rows) return sum;
  const ContactRow &r = problem.rows[i], &s = problem.rows[j];
  if (r.group >= 0 && r.group == s.group) sum += r.give * s.give;
  return sum;
}

ContactSystem::ContactSystem(const ContactProblem& of, const SurfaceCompliance* compliance)
    : problem(of), rows(static_cast<std::size_t>(problem.row_count)), count(rows + 2 * static_cast<std::size_t>(problem.disc_count)) {
  for (std::size_t i = 0; i < rows; ++i) {
    const ContactRow& r = problem.rows[i];
    q[i] = r.a.dot(problem.target) - r.b + (r.group >= 0 ? r.give * problem.rest[static_cast<std::size_t>(r.group)] : 0);
    p[i] = std::max(0.0, r.multiplier);
  }
  for (std::size_t i = rows; i < count; ++i) {
    const FrictionDisc& d = problem.discs[(i - rows) / 2];
    const std::size_t axis = (i - rows) % 2;
    q[i] = d.across[axis].dot(problem.target) - d.origin[axis];
    p[i] = d.force[axis];
  }
  const auto surface = [&](std::size_t i) { return i < rows ? i : kMaxContactRows + i - rows; };
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      const double entry = product(i, j) + (compliance ? (*compliance)[surface(i)][surface(j)] : 0);
      g[i][j] = g[j][i] = i == j ? (1 + kYield) * entry : entry;
    }
  products += 3.0 * static_cast<double>(count * count);
  listParts();
}

void ContactSystem::listParts() {
  std::array<bool, kMaxContactRows> is_joined{};
  for (std::size_t d = 0; rows + 2 * d < count; ++d) {
    const FrictionDisc& disc = problem.discs[d];
    const std::size_t row = static_cast<std::size_t>(disc.row), first = rows + 2 * d;
    const bool has_friction = disc.friction > 0;
    if (has_friction) rubs = is_joined[row] = true;
    parts[part_count++] =
        has_friction ? ContactPart{{row, first, first + 1}, 3, disc.friction, 0} : ContactPart{{first, first + 1, 0}, 2, 0, disc.radius};
  }
  for (std::size_t i = 0; i < rows; ++i)
    if (!is_joined[i]) parts[part_count++] = {{i, 0, 0}, 1, 0, 0};
  obey(Law::Coulomb);
}

// A force obeys its law if it is the nearest allowed one to  force - motion / scale,  for any scale; of a cone, the
// same one for all axes.
void ContactSystem::obey(Law next) {
  law = next;
  for (std::size_t k = 0; k < part_count; ++k) {
    ContactPart& part = parts[k];
    double own[3] = {}, sum = 0;
    for (std::size_t a = 0; a < part.size; ++a) sum += own[a] = g[part.at[a]][part.at[a]];
    const bool is_apart = part.size == 3 && law != Law::Cones;
    for (std::size_t a = 0; a < part.size; ++a) part.scale[a] = !is_apart ? sum : a == 0 ? own[0] : own[1] + own[2];
    part.radius = part.size == 3 ? part.friction * p[part.at[0]] : part.radius;
  }
}

void ContactSystem::aim(const ContactPart& part, double* z) const {
  for (std::size_t a = 0; a < part.size; ++a) z[a] = p[part.at[a]] - w[part.at[a]] / part.scale[a];
}

void ContactSystem::findMotions() {
  std::copy_n(q.begin(), count, w.begin());
  for (std::size_t j = 0; j < count; ++j)
    for (std::size_t i = 0; p[j] != 0 && i < count; ++i) w[i] += p[j] * g[j][i];
  products += static_cast<double>(count * count);
}

void ContactSystem::change(std::size_t force, double by) {
  if (by == 0) return;
  p[force] += by;
  for (std::size_t i = 0; i < count; ++i) w[i] += by * g[force][i];
}

void ContactSystem::allow() {
  double z[3];
  for (std::size_t k = 0; k < part_count; ++k) {
    const ContactPart& part = parts[k];
    for (std::size_t a = 0; a < part.size; ++a) z[a] = p[part.at[a]];
    nearest(part, z, nullptr);
    for (std::size_t a = 0; a < part.size; ++a) p[part.at[a]] = z[a];
  }
}

double ContactSystem::residual() {
  double largest = 0, z[3];
  findMotions();
  for (std::size_t k = 0; k < part_count; ++k) {
    const ContactPart& part = parts[k];
    aim(part, z);
    nearest(part, z, nullptr);
    for (std::size_t a = 0; a < part.size; ++a) largest = std::max(largest, part.scale[a] * std::abs(z[a] - p[part.at[a]]));
  }
  return largest;
}

bool ContactSystem::solveEquations() {
  const std::size_t size = unknown_count;
  for (std::size_t k = 0; k < size; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < size; ++i)
      if (std::abs(matrix[i][k]) > std::abs(matrix[pivot][k])) pivot = i;
    if (!(std::abs(matrix[pivot][k]) > 1e-14)) return false;
    if (pivot != k) {
      std::swap_ranges(matrix[k].begin() + static_cast<std::ptrdiff_t>(k), matrix[k].begin() + static_cast<std::ptrdiff_t>(size),
                       matrix[pivot].begin() + static_cast<std::ptrdiff_t>(k));
      std::swap(right[k], right[pivot]);
    }
    for (std::size_t i = k + 1; i < size; ++i) {
      const double factor = matrix[i][k] / matrix[k][k];
      if (factor == 0) continue;
      for (std::size_t j = k + 1; j < size; ++j) matrix[i][j] -= factor * matrix[k][j];
      right[i] -= factor * right[k];
    }
  }
  for (std::size_t i = size; i-- > 0;) {
    for (std::size_t j = i + 1; j < size; ++j) right[i] -= matrix[i][j] * right[j];
    right[i] /= matrix[i][i];
  }
  products += static_cast<double>(size * size * size) / 3;
  return true;
}

}  // namespace spheretree::runtime
