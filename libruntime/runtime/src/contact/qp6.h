// SPDX-License-Identifier: Apache-2.0
// The projection of a point on a polyhedron in 6 dimensions:  minimise |y - target|^2 / 2  subject to  a_i . y >= b_i.
// Paper: D. Goldfarb, A. Idnani. A numerically stable dual method for solving strictly convex quadratic programs.
//        Mathematical Programming 27, 1983. Here the Hessian is the identity, rows are scanned in float, active rows
//        are
//        kept in double, the start is warm, and contradicting rows come with a certificate.
// Units: y in mm (scaled), rows of unit length. No allocation. Deterministic.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

namespace spheretree::runtime {

using Vector6 = Eigen::Matrix<double, 6, 1, Eigen::DontAlign>;

/// Rows as structure of arrays. All arrays have `count` values and are readable up to the next multiple of 8; the
/// padding has a = 0 and b < 0.
struct QpRows {
  std::array<const float*, 6> a;
  const float* b = nullptr;
  std::uint32_t count = 0;
};

enum class QpStatus : std::uint8_t {
  Optimal,
  Infeasible,      // no y satisfies the rows of the certificate
  IterationLimit,  // `y` is optimal for the active rows only
};

inline constexpr int kMaxContactRows = 24;  // rows that hold the tool; 6 without friction and tissue

struct QpAnswer {
  Vector6 y = Vector6::Zero();
  QpStatus status = QpStatus::Optimal;
  std::uint8_t active_count = 0;                        // 0..6; with friction or tissue, more
  std::array<std::uint32_t, kMaxContactRows> active{};  // indices of rows with a_i . y = b_i
  std::array<double, kMaxContactRows> multiplier{};     // > 0; y = target + sum multiplier_i a_i
  std::uint8_t certificate_count = 0;                   // of an Infeasible answer, 1..7
  std::array<std::uint32_t, 7> certificate{};           // indices of the rows of the certificate
  std::array<double, 7> certificate_weight{};           // weights > 0: sum weight_i a_i = 0 and sum weight_i b_i > 0
  std::uint16_t iterations = 0;                         // rows that entered the active set
};

inline constexpr double kQpTolerance = 1e-5;  // a row may be violated by this [mm, scaled]
inline constexpr int kQpIterationLimit = 100;

struct KernelTable;

/// `answer`: its active rows are the warm start. Indices out of range and dependent rows are skipped, so any content is
/// allowed. Cost: one scan of the rows for each iteration; 0 to 3 iterations in steady contact.
void solveQp6(const KernelTable& kernel, const QpRows& rows, const Vector6& target, QpAnswer& answer) noexcept;

}  // namespace spheretree::runtime
