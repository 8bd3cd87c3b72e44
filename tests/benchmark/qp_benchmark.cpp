// SPDX-License-Identifier: Apache-2.0
// Time of the QP alone, on rows of consecutive servo cycles of a rod of 512 balls:
//   slide      over and into a solid of about 22 000 balls
//   slot       between two walls of varying distance; every deficit clamped, so that staying is always allowed
//   slot-raw   the same, not clamped: some cycles have no answer
//   redundant  slide, each row four times: itself, a copy, and neighbours turned by 1e-8 and 1e-5
// Warm: from the rows that were active in the cycle before; cold: from none. Peer: quadprog, where it is installed
// (r-cran-quadprog). Least of three passes for each cycle, less the cost of reading the clock; copying rows to the peer
// is not timed.
// Usage: qp_benchmark [CYCLES]
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "benchmark/benchmark_scenes.h"
#include "quantile.h"
#include "rows/rows.h"
#include "search/find_pairs.h"
#include "spheretree/runtime/step.h"
#include "state/step_memory.h"
#include "support/quadprog_peer.h"
#include "support/shape_trees.h"

namespace {

using namespace spheretree;
using namespace spheretree::runtime;
using Clock = std::chrono::steady_clock;

struct Cycle {
  std::vector<float> memory;  // 6 arrays of `a`, then b
  std::vector<std::uint64_t> name;
  Vector6 target;
  std::size_t stride = 0;

  QpRows rows() const { return rowsIn(memory); }
  QpRows rowsIn(const std::vector<float>& copy) const {
    QpRows out;
    for (std::size_t k = 0; k < 6; ++k) out.a[k] = copy.data() + k * stride;
    out.b = copy.data() + 6 * stride;
    out.count = static_cast<std::uint32_t>(name.size());
    return out;
  }
};

SceneDescription scene(bool slot) {
  SceneDescription d;
  d.tool = test::rodTree(35, 512, 0.5);
  d.reference_point = {0, 0, 17};
  d.step_limits = {1 << 16, 1 << 24};
  if (slot) {
    const SphereTree wall = test::boxTree({2, 12, 20}, {5, 32, 52}, 0.5);
    d.objects.push_back({wall, {{-3.2, 0, 0}, rotationOf({0, 0, 0.06})}});
    d.objects.push_back({wall, {{3.2, 0, 0}, rotationOf({0, 0.03, -0.05})}});
  } else {
    d.objects.push_back({test::boxTree({20, 20, 10}, {34, 34, 19}, 0.8), {}});
  }
  return d;
}

Configuration hapticPose(bool slot, int n) {
  const double t = 0.001 * n;
  if (slot)
    return {{1.5 * std::sin(2 * t), 9 * std::sin(1.1 * t), 3 * std::sin(0.7 * t)},
            rotationOf({0.1 * std::sin(3 * t), 0.12 * std::sin(2.3 * t), 0})};
  return {{12 * std::sin(0.9 * t), 12 * std::sin(1.3 * t), 9.5 + 1.5 * std::sin(5 * t)},
          rotationOf({0.5 * M_PI + 0.04 * std::sin(1.7 * t), 0.05 * std::sin(2.1 * t), 0.4 * t})};
}

/// The `wanted` rows with the smallest gaps about the tool, for each cycle.
std::vector<Cycle> cyclesOf(const std::string& family, std::size_t wanted, int count) {
  const bool slot = family.starts_with("slot"), redundant = family == "redundant";
  const std::size_t base = redundant ? wanted / 4 : wanted;
  const SceneDescription description = scene(slot);
  const Scene compiled = benchmark::compiled(description);
  Workspace mover(compiled), finder(compiled);
  resetTo(slot ? Configuration{{0, 0, 0}, {1, 0, 0, 0}} : Configuration{{0, 0, 14}, hapticPose(slot, 0).orientation}, mover);
  Configuration before = mover.memory().graphic;
  std::vector<Cycle> cycles;
  for (int n = -100; n < count; ++n) {
    const Configuration haptic = hapticPose(slot, n);
    const StepResult moved = step(compiled, haptic, Mode::Constrained, mover);
    // The walls approach each other, at times closer than the tool is thick.
    const float closing = slot ? 0.15f * static_cast<float>(std::sin(0.01 * n)) : 0.0f;
    if (n >= 0) {
      double margin = 0.2;
      PairSet pairs = findPairs(before, margin, PairsOf::LeavesExactly, 1u << 24, finder.memory());
      while (pairs.pairs.size() < base && margin < 20)
        pairs = findPairs(before, margin *= 1.3, PairsOf::LeavesExactly, 1u << 24, finder.memory());
      const RowSet set = makeRows(pairs, before, RowForm::TrueDistance, Eigen::Matrix3d::Identity(), finder.memory());
      std::vector<std::uint32_t> order(pairs.pairs.size());
      std::iota(order.begin(), order.end(), 0u);
      const std::size_t kept = std::min(base, order.size());
      std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(kept), order.end(),
                        [&](std::uint32_t a, std::uint32_t b) {
                          const float x = set.rows.b[a] / set.weight[a], y = set.rows.b[b] / set.weight[b];
                          return x != y ? x > y : a < b;
                        });
      std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(kept));
      Cycle c;
      const std::size_t copies = redundant ? 4 : 1;
      c.stride = (kept * copies + 15) / 8 * 8 + 8;
      c.memory.assign(7 * c.stride, 0);
      std::fill(c.memory.begin() + static_cast<std::ptrdiff_t>(6 * c.stride), c.memory.end(), -1e30f);
      for (std::size_t copy = 0; copy < copies; ++copy)
        for (std::size_t i = 0; i < kept; ++i) {
          const std::size_t row = c.name.size();
          for (std::size_t k = 0; k < 6; ++k) c.memory[k * c.stride + row] = set.rows.a[k][order[i]];
          if (copy >= 2) c.memory[(i % 6) * c.stride + row] += copy == 2 ? 1e-8f : 1e-5f;
          const float b = set.rows.b[order[i]] + closing * set.weight[order[i]];
          c.memory[6 * c.stride + row] = family == "slot" ? std::min(b, 0.0f) : b;
          const PairRun* run = pairs.runs.data();
          while (order[i] >= run->begin + run->count) ++run;
          c.name.push_back((std::uint64_t{copy} << 48) + (std::uint64_t{run->object} << 32) + pairs.pairs[order[i]]);
        }
      const Displacement want = displacementBetween(before, haptic);
      c.target << want.translation, compiled.compiled().angle_length * want.rotation;
      cycles.push_back(std::move(c));
    }
    before = moved.graphic;
  }
  return cycles;
}

double nanos(Clock::time_point a, Clock::time_point b) { return std::chrono::duration<double, std::nano>(b - a).count(); }

double clockCost() {
  double smallest = 1e9;
  for (int i = 0; i < 1000; ++i) {
    const auto a = Clock::now(), b = Clock::now();
    smallest = std::min(smallest, nanos(a, b));
  }
  return smallest;
}

struct Times {
  std::vector<double> smallest;  // [ns] of each cycle
  double at(double part) const { return 1e-3 * tool::quantile(smallest, part); }
};

template <class Solve>
Times measure(const std::vector<Cycle>& cycles, double clock_cost, Solve&& solve) {
  Times times;
  times.smallest.assign(cycles.size(), std::numeric_limits<double>::infinity());
  for (int pass = 0; pass < 3; ++pass)
    for (std::size_t n = 0; n < cycles.size(); ++n) times.smallest[n] = std::min(times.smallest[n], solve(n) - clock_cost);
  return times;
}

/// The answers of consecutive cycles. Each cycle starts from the rows that were active in the one before.
struct Answers {
  std::vector<QpAnswer> start, solved;
  double active = 0;  // rows, sum over the cycles
  int infeasible = 0;
};
Answers solveInTurn(const KernelTable& kernel, const std::vector<Cycle>& cycles) {
  Answers out;
  out.start.resize(cycles.size());
  out.solved.resize(cycles.size());
  for (std::size_t n = 0; n < cycles.size(); ++n) {
    QpAnswer& start = out.start[n];
    if (n > 0)
      for (std::size_t k = 0; k < out.solved[n - 1].active_count; ++k) {
        const auto& names = cycles[n].name;
        const auto found = std::find(names.begin(), names.end(), cycles[n - 1].name[out.solved[n - 1].active[k]]);
        if (found != names.end()) start.active[start.active_count++] = static_cast<std::uint32_t>(found - names.begin());
      }
    out.solved[n] = start;
    solveQp6(kernel, cycles[n].rows(), cycles[n].target, out.solved[n]);
    out.active += out.solved[n].active_count;
    out.infeasible += out.solved[n].status == QpStatus::Infeasible;
  }
  return out;
}

/// Times of our own QP, from the answers in `start`; from no active rows if `start` is null.
Times ownTimes(const KernelTable& kernel, const std::vector<Cycle>& cycles, const std::vector<QpAnswer>* start, double clock_cost) {
  std::size_t largest = 0;
  for (const Cycle& c : cycles) largest = std::max(largest, c.memory.size());
  std::vector<float> used(largest);
  return measure(cycles, clock_cost, [&](std::size_t n) {
    QpAnswer answer = start ? (*start)[n] : QpAnswer{};
    std::copy(cycles[n].memory.begin(), cycles[n].memory.end(), used.begin());  // in a servo step rows come fresh from the cache
    const QpRows rows = cycles[n].rowsIn(used);
    const auto a = Clock::now();
    solveQp6(kernel, rows, cycles[n].target, answer);
    return nanos(a, Clock::now());
  });
}

struct PeerTimes {
  Times times;
  double apart = 0;  // largest distance between its answers and ours, relative to ours where that is above 1 [mm]
};
PeerTimes peerTimes(test::QuadprogPeer& peer, const std::vector<Cycle>& cycles, const std::vector<QpAnswer>& ours, std::size_t wanted,
                    double clock_cost) {
  PeerTimes out;
  peer.reserve(wanted);
  std::vector<double> a(6 * wanted), b(wanted);
  out.times = measure(cycles, clock_cost, [&](std::size_t n) {
    const QpRows rows = cycles[n].rows();
    for (std::uint32_t i = 0; i < rows.count; ++i) {
      for (std::size_t k = 0; k < 6; ++k) a[6 * i + k] = static_cast<double>(rows.a[k][i]);
      b[i] = static_cast<double>(rows.b[i]);
    }
    double y[6];
    const auto from = Clock::now();
    const bool solved = peer.solve(a.data(), b.data(), static_cast<int>(rows.count), cycles[n].target.data(), y);
    const double spent = nanos(from, Clock::now());
    if (solved && ours[n].status == QpStatus::Optimal)
      out.apart = std::max(out.apart, (Eigen::Map<const Eigen::Matrix<double, 6, 1>>(y) - ours[n].y).norm() /
                                          std::max(1.0, ours[n].y.cwiseAbs().maxCoeff()));
    return spent;
  });
  return out;
}

std::string medianToMax(const Times& t) {
  char text[64];
  std::snprintf(text, sizeof text, "%.2f / %.2f / %.1f", t.at(0.5), t.at(0.99), t.at(1));
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::max(10, std::atoi(argv[1])) : 1000;
  const KernelTable& kernel = avx2Kernel() ? *avx2Kernel() : scalarKernel();
  const double clock_cost = clockCost();
  test::QuadprogPeer peer;
  if (!peer.isThere()) std::puts("no peer: r-cran-quadprog is not installed");
  std::printf("%-10s %5s %6s %6s | %-24s %-24s %-24s %6s %s\n", "family", "rows", "active", "infeas", "warm median/p99/max us", "cold",
              "quadprog", "ratio", "farthest apart mm");
  for (const char* family : {"slide", "slot", "slot-raw", "redundant"})
    for (const std::size_t wanted : {20u, 150u, 500u, 2000u}) {
      const std::vector<Cycle> cycles = cyclesOf(family, wanted, count);
      const Answers answers = solveInTurn(kernel, cycles);
      const Times warm = ownTimes(kernel, cycles, &answers.start, clock_cost), cold = ownTimes(kernel, cycles, nullptr, clock_cost);
      double apart = 0;
      std::string theirs = "-", ratio = "-";
      if (peer.isThere()) {
        const PeerTimes found = peerTimes(peer, cycles, answers.solved, wanted, clock_cost);
        apart = found.apart;
        theirs = medianToMax(found.times);
        char text[64];
        std::snprintf(text, sizeof text, "%.1f", found.times.at(0.5) / warm.at(0.5));
        ratio = text;
      }
      std::printf("%-10s %5zu %6.1f %6d | %-24s %-24s %-24s %6s %.1e\n", family, cycles[0].name.size(), answers.active / count,
                  answers.infeasible, medianToMax(warm).c_str(), medianToMax(cold).c_str(), theirs.c_str(), ratio.c_str(), apart);
    }
  return 0;
}
