// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/trajectory.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "spheretree/formats/csv_table.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/path_name.h"
#include "text/text_scan.h"

namespace spheretree::formats {
namespace {

constexpr std::array<std::string_view, 8> kColumns{"t_s", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"};
constexpr std::array<std::string_view, 8> kRecordedColumns{"t_s", "hx_mm", "hy_mm", "hz_mm", "hqw", "hqx", "hqy", "hqz"};
constexpr const char* kHeader = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz";
constexpr double kStep = 1e-3, kStepTolerance = 1e-6, kLongestGap = 0.1;  // [s]
constexpr double kFarthest = 1e7;                                         // [mm]; as in the runtime
constexpr double kUnitTolerance = 1e-3;

class TrajectoryReader {
 public:
  TrajectoryReader(std::string_view text, const std::string& name) : table_(text, name) {}

  Trajectory read() {
    chooseColumns();
    while (table_.next()) readRow();
    if (poses_.empty()) table_.fail("no row after the header: give one for each servo step of 1 ms");
    if (is_every_step_) return {std::move(poses_), std::move(spins_), kStep};
    return resampled();
  }

 private:
  void chooseColumns() {
    const std::vector<std::string_view>& found = table_.columns();
    const bool recorded = table_.find("hx_mm").has_value();
    spin_ = table_.find("spin");
    const auto poses_end = found.end() - (spin_ == kColumns.size() && found.size() == kColumns.size() + 1 ? 1 : 0);
    if (!recorded && !std::equal(found.begin(), poses_end, kColumns.begin(), kColumns.end())) {
      std::string header;
      for (const std::string_view column : found) header += (header.empty() ? "" : ",") + std::string(column);
      table_.fail("the header is " + inQuotes(header) + ": write " + kHeader +
                  " (and ,spin for a burr), or give a recording of haptic-player");
    }
    for (std::size_t k = 0; k < kColumns.size(); ++k)
      at_[k] = table_.require(recorded ? kRecordedColumns[k] : kColumns[k], "record it again with haptic-player --record");
  }

  void readRow() {
    std::array<double, 8> v;
    for (std::size_t k = 0; k < 8; ++k) v[k] = table_.number(at_[k], kFarthest);
    checkTime(v[0]);
    Configuration pose{{v[1], v[2], v[3]}, {v[4], v[5], v[6], v[7]}};
    const double length = pose.orientation.norm();
    if (!(std::abs(length - 1) <= kUnitTolerance))
      table_.fail("the quaternion " + std::string(table_.columns()[at_[4]]) + ".." + std::string(table_.columns()[at_[7]]) +
                  " has length " + shortest(length) + ", not 1: normalise it");
    // A smaller deviation is rounding: normalising again would change the last bit of a recorded number.
    if (std::abs(length - 1) > 4e-15) pose.orientation.normalize();
    poses_.push_back(pose);
    if (spin_) spins_.push_back(table_.count(*spin_, 1) == 1);
  }

  void checkTime(double time) {
    const double first = times_.empty() ? time : times_.front(), last = times_.empty() ? time - kStep : times_.back();
    if (!(time > last)) table_.fail("t_s is " + shortest(time) + ", not after the " + shortest(last) + " of the row before");
    if (time - last > kLongestGap + kStepTolerance)
      table_.fail("t_s is " + shortest(time) + ", " + shortest(time - last) + " s after the row before: give at least one row in 0.1 s");
    if (std::abs(time - (first + static_cast<double>(times_.size()) * kStep)) > kStepTolerance) is_every_step_ = false;
    if (!times_.empty()) longest_gap_ = std::max(longest_gap_, time - last);
    times_.push_back(time);
  }

  /// Interpolates the poses at each millisecond after the first row.
  Trajectory resampled() const {
    Trajectory out{{}, {}, longest_gap_};
    std::size_t after = 0;
    for (std::size_t n = 0;; ++n) {
      const double time = times_.front() + static_cast<double>(n) * kStep;
      while (after < times_.size() && times_[after] < time - kStepTolerance) ++after;
      if (after == times_.size()) return out;
      const Configuration& to = poses_[after];
      const bool is_row = after == 0 || times_[after] - time < kStepTolerance;
      if (spin_) out.spins.push_back(spins_[is_row ? after : after - 1]);
      if (is_row) {
        out.poses.push_back(to);
        continue;
      }
      const Configuration& from = poses_[after - 1];
      const double share = (time - times_[after - 1]) / (times_[after] - times_[after - 1]);
      const Displacement way = displacementBetween(from, to);
      out.poses.push_back(moved(from, {share * way.translation, share * way.rotation}));
    }
  }

  CsvTable table_;
  std::array<std::size_t, 8> at_{};
  std::optional<std::size_t> spin_;
  std::vector<double> times_;
  double longest_gap_ = 0;
  bool is_every_step_ = true;
  std::vector<Configuration> poses_;
  std::vector<bool> spins_;
};

}  // namespace

Trajectory parseTrajectory(std::string_view text, const std::string& name) { return TrajectoryReader(text, name).read(); }

Trajectory readTrajectory(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = readFile(path);
  return parseTrajectory({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, toUtf8(path));
}

}  // namespace spheretree::formats
