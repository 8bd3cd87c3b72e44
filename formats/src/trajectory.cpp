// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/trajectory.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "mesh_assembly.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "text_scan.h"

namespace spheretree::formats {
namespace {

constexpr std::array<std::string_view, 8> kColumns{"t_s", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"};
constexpr std::array<std::string_view, 8> kRecordedColumns{"t_s", "hx_mm", "hy_mm", "hz_mm", "hqw", "hqx", "hqy", "hqz"};
constexpr const char* kHeader = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz";
constexpr double kStep = 1e-3, kStepTolerance = 1e-6, kLongestGap = 0.1;  // [s]
constexpr double kFarthest = 1e7;                                         // [mm]; as the runtime's
constexpr double kUnitTolerance = 1e-3;

std::string shown(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string_view takeField(std::string_view& line) {
  const std::size_t end = std::min(line.find(','), line.size());
  const std::string_view field = trimmed(line.substr(0, end));
  line.remove_prefix(std::min(end + 1, line.size()));
  return field;
}

class TrajectoryReader {
 public:
  TrajectoryReader(std::string_view text, const std::string& name) : lines_(std::span<const char>(text.data(), text.size())), name_(name) {}

  Trajectory read() {
    std::string_view line;
    if (!lines_.next(line)) fail("the file is empty: begin with the line " + std::string(kHeader));
    readHeader(line);
    while (lines_.next(line))
      if (!trimmed(line).empty()) readRow(line);
    if (poses_.empty()) fail("no row after the header: give one for each servo step of 1 ms");
    if (is_every_step_) return {std::move(poses_), kStep};
    return {resampled(), longest_gap_};
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw FormatError(name_ + ", line " + std::to_string(lines_.number()) + ": " + what);
  }

  void readHeader(std::string_view line) {
    std::vector<std::string_view> found;
    for (std::string_view rest = line; !rest.empty();) found.push_back(takeField(rest));
    const auto place = [&](std::string_view column) -> std::optional<std::size_t> {
      for (std::size_t k = 0; k < found.size(); ++k)
        if (found[k] == column) return k;
      return std::nullopt;
    };
    const bool recorded = place("hx_mm").has_value();
    if (!recorded && !std::equal(found.begin(), found.end(), kColumns.begin(), kColumns.end()))
      fail("the header is " + inQuotes(line) + ": write " + kHeader + ", or give a recording of haptic-player");
    columns_ = found.size();
    for (std::size_t k = 0; k < 8; ++k) {
      const std::string_view column = recorded ? kRecordedColumns[k] : kColumns[k];
      const std::optional<std::size_t> at = place(column);
      if (!at) fail("the recording has no column " + std::string(column) + ": record it again with haptic-player --record");
      wanted_[k] = *at;
      names_[k] = column;
    }
  }

  void readRow(std::string_view line) {
    fields_.clear();
    for (std::string_view rest = line; !rest.empty();) fields_.push_back(takeField(rest));
    if (line.ends_with(',')) fields_.emplace_back();
    if (fields_.size() != columns_) fail(std::to_string(fields_.size()) + " fields, the header has " + std::to_string(columns_));
    std::array<double, 8> v;
    for (std::size_t k = 0; k < 8; ++k) v[k] = number(k);
    checkTime(v[0]);
    Configuration pose{{v[1], v[2], v[3]}, {v[4], v[5], v[6], v[7]}};
    const double length = pose.orientation.norm();
    if (!(std::abs(length - 1) <= kUnitTolerance))
      fail("the quaternion " + std::string(names_[4]) + ".." + std::string(names_[7]) + " has length " + shown(length) +
           ", not 1: normalise it");
    // Shorter than that is rounding: to normalise again would change the last bit of what was recorded.
    if (std::abs(length - 1) > 4e-15) pose.orientation.normalize();
    poses_.push_back(pose);
  }

  double number(std::size_t k) const {
    const std::string_view field = fields_[wanted_[k]];
    const auto failField = [&](const std::string& what) {
      fail("column " + std::to_string(wanted_[k] + 1) + " (" + std::string(names_[k]) + ") is " + inQuotes(field) + what);
    };
    double value = 0;
    if (parseDouble(field, value) != NumberFault::None) failField(": write a number");
    if (!std::isfinite(value) || std::abs(value) > kFarthest) failField(": write a finite number within 1e7");
    return value;
  }

  void checkTime(double time) {
    const double first = times_.empty() ? time : times_.front(), last = times_.empty() ? time - kStep : times_.back();
    if (!(time > last)) fail("t_s is " + shown(time) + ", not after the " + shown(last) + " of the row before");
    if (time - last > kLongestGap + kStepTolerance)
      fail("t_s is " + shown(time) + ", " + shown(time - last) + " s after the row before: give at least one row in 0.1 s");
    if (std::abs(time - (first + static_cast<double>(times_.size()) * kStep)) > kStepTolerance) is_every_step_ = false;
    if (!times_.empty()) longest_gap_ = std::max(longest_gap_, time - last);
    times_.push_back(time);
  }

  /// The poses at each millisecond after the first row, between the rows that come before and after.
  std::vector<Configuration> resampled() const {
    std::vector<Configuration> out;
    std::size_t after = 0;
    for (std::size_t n = 0;; ++n) {
      const double time = times_.front() + static_cast<double>(n) * kStep;
      while (after < times_.size() && times_[after] < time - kStepTolerance) ++after;
      if (after == times_.size()) return out;
      const Configuration& to = poses_[after];
      if (after == 0 || times_[after] - time < kStepTolerance) {
        out.push_back(to);
        continue;
      }
      const Configuration& from = poses_[after - 1];
      const double share = (time - times_[after - 1]) / (times_[after] - times_[after - 1]);
      const Displacement way = displacementBetween(from, to);
      out.push_back(moved(from, {share * way.translation, share * way.rotation}));
    }
  }

  Lines lines_;
  const std::string& name_;
  std::size_t columns_ = 0;
  std::array<std::size_t, 8> wanted_{};
  std::array<std::string_view, 8> names_{};
  std::vector<std::string_view> fields_;
  std::vector<double> times_;
  double longest_gap_ = 0;
  bool is_every_step_ = true;
  std::vector<Configuration> poses_;
};

}  // namespace

Trajectory parseTrajectory(std::string_view text, const std::string& name) {
  const std::span<const char> checked = asText(std::span<const char>(text.data(), text.size()), name);
  return TrajectoryReader({checked.data(), checked.size()}, name).read();
}

Trajectory readTrajectory(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = readFile(path);
  return parseTrajectory({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, path.string());
}

}  // namespace spheretree::formats
