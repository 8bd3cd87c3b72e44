// SPDX-License-Identifier: GPL-3.0-or-later
#include "run/run_statistics.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace spheretree::player {
namespace {

constexpr std::array<const char*, 7> kFaultNames{"pairs_full",  "work_limit", "qp_stopped",   "rows_conflict",
                                                 "penetrating", "bad_input",  "tissue_frozen"};

}  // namespace

nlohmann::ordered_json timesJson(const TimeHistogram& h) {
  const auto rounded = [](double us) { return std::round(us * 1000) / 1000; };
  return {{"median", rounded(h.quantile(0.5))},
          {"p99", rounded(h.quantile(0.99))},
          {"p99_9", rounded(h.quantile(0.999))},
          {"max", rounded(h.largest())}};
}

void TimeHistogram::add(double us) noexcept {
  const double octave = us > 0.001 ? std::log2(us * 1000) : 0;
  const int bin = std::min(static_cast<int>(octave * kPerOctave), kPerOctave * kOctaves - 1);
  ++bins_[static_cast<std::size_t>(bin)];
  ++count_;
  largest_ = std::max(largest_, us);
}

double TimeHistogram::quantile(double q) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(q * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (std::size_t bin = 0; bin < bins_.size() && count_ > 0; ++bin) {
    seen += bins_[bin];
    if (seen >= wanted) return std::min(largest_, 0.001 * std::exp2(static_cast<double>(bin + 1) / kPerOctave));
  }
  return 0;
}

void PassivityObserver::add(const Configuration& pose, const Wrench& wrench) noexcept {
  if (started_) {
    const Displacement way = displacementBetween(pose_, pose);
    energy_ -= wrench_.force.dot(way.translation) + wrench_.torque.dot(way.rotation);
    smallest_ = std::min(smallest_, energy_);
    largest_ = std::max(largest_, energy_);
  }
  pose_ = pose;
  wrench_ = wrench;
  started_ = true;
}

void RunStatistics::add(const RecordedStep& row, double processor_us) noexcept {
  find_.add(row.find_us);
  rows_.add(row.rows_us);
  qp_.add(row.qp_us);
  total_.add(row.total_us);
  processor_.add(processor_us);
  if (row.total_us > longest_.clock_us) longest_ = {row.time, row.total_us, processor_us, row.pairs, row.active};
  over_by_clock_ += row.total_us > period_us_;
  over_by_processor_ += processor_us > period_us_;
  if (isFinite(row.haptic)) energy_.add(row.haptic, row.wrench);
  if (follows_) {
    force_step_ = std::max(force_step_, (row.wrench.force - last_wrench_.force).norm());
    torque_step_ = std::max(torque_step_, (row.wrench.torque - last_wrench_.torque).norm());
  }
  last_wrench_ = row.wrench;
  largest_force_ = std::max(largest_force_, row.wrench.force.norm());
  penetration_ = std::max(penetration_, row.penetration);
  passivity_steps_ += row.passivity_force > 0 || row.passivity_torque > 0;
  passivity_force_ = std::max(passivity_force_, row.passivity_force);
  passivity_torque_ = std::max(passivity_torque_, row.passivity_torque);
  passivity_debt_ = std::max(passivity_debt_, row.passivity_debt);
  for (std::size_t k = 0; k < faults_.size(); ++k) faults_[k] += row.faults >> k & 1;
  ++steps_;
  follows_ = true;
}

void RunStatistics::restart() noexcept {
  energy_.restart();
  follows_ = false;
}

nlohmann::ordered_json RunStatistics::toJson() const {
  nlohmann::ordered_json faults;
  for (std::size_t k = 0; k < faults_.size(); ++k) faults[kFaultNames[k]] = faults_[k];
  return {{"steps", steps_},
          {"time_us",
           {{"find", timesJson(find_)},
            {"rows", timesJson(rows_)},
            {"qp", timesJson(qp_)},
            {"total", timesJson(total_)},
            {"processor", timesJson(processor_)}}},
          {"longest_step",
           {{"kind", longest_.kind()},
            {"t_s", longest_.time},
            {"clock_us", longest_.clock_us},
            {"processor_us", longest_.processor_us},
            {"pairs", longest_.pairs},
            {"contacts", longest_.contacts}}},
          {"steps_over_ms", {{"clock", over_by_clock_}, {"processor", over_by_processor_}}},
          {"largest_penetration_mm", penetration_},
          {"largest_force_n", largest_force_},
          {"wrench_step", {{"force_n", force_step_}, {"torque_n_mm", torque_step_}}},
          {"energy_mj", {{"smallest", energy_.smallest()}, {"largest", energy_.largest()}, {"final", energy_.energy()}}},
          {"faults", faults}};
}

nlohmann::ordered_json RunStatistics::passivityJson() const {
  return {{"steps", passivity_steps_},
          {"largest_force_n", passivity_force_},
          {"largest_torque_n_mm", passivity_torque_},
          {"largest_debt_mj", passivity_debt_}};
}

}  // namespace spheretree::player
