// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/recording.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

#include "quantile.h"
#include "spheretree/core/rigid.h"
#include "spheretree/formats/csv_table.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::tool {
namespace {

constexpr std::array kColumns{"t_s",   "hx_mm", "hy_mm",  "hz_mm",  "hqw",    "hqx",   "hqy",    "hqz",
                              "gx_mm", "gy_mm", "gz_mm",  "gqw",    "gqx",    "gqy",   "gqz",    "fx_n",
                              "fy_n",  "fz_n",  "tx_nmm", "ty_nmm", "tz_nmm", "pairs", "faults", "total_us"};

constexpr double kJump = 10;  // a larger motion in a step [mm] is not a motion of a hand but a restart

template <std::size_t N>
Trace traceOf(const std::string& name, const std::vector<std::array<float, N>>& rows, std::size_t column) {
  Trace trace{name, {}};
  for (const auto& row : rows) trace.y.push_back(row[column]);
  return trace;
}

/// In place; the size must be a power of two.
void fourier(std::vector<std::complex<double>>& values) {
  const std::size_t n = values.size();
  for (std::size_t i = 1, j = 0; i < n; ++i) {
    std::size_t bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j |= bit;
    if (i < j) std::swap(values[i], values[j]);
  }
  for (std::size_t length = 2; length <= n; length *= 2)
    for (std::size_t first = 0; first < n; first += length)
      for (std::size_t k = 0; k < length / 2; ++k) {
        const std::complex<double> turn = std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(length));
        const std::complex<double> a = values[first + k], b = values[first + k + length / 2] * turn;
        values[first + k] = a + b;
        values[first + k + length / 2] = a - b;
      }
}

std::vector<float> distances(const Recording& r) {
  std::vector<float> out;
  for (std::size_t i = 0; i < r.steps(); ++i)
    out.push_back(std::hypot(r.hand[i][0] - r.tool[i][0], r.hand[i][1] - r.tool[i][1], r.hand[i][2] - r.tool[i][2]));
  return out;
}

double rateOf(const Recording& r) {
  return r.steps() > 1 ? static_cast<double>(r.steps() - 1) / std::max(1e-9, static_cast<double>(r.time.back()) - r.time.front()) : 1000;
}

void countTouch(Recording& recording, const std::string& name) {
  const auto found = std::find_if(recording.touched.begin(), recording.touched.end(), [&](const auto& row) { return row.first == name; });
  if (found == recording.touched.end())
    recording.touched.emplace_back(name, 1);
  else
    ++found->second;
}

}  // namespace

Recording readRecording(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = formats::readFile(path);
  formats::CsvTable table({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, path.string());
  std::array<std::size_t, kColumns.size()> at{};
  for (std::size_t c = 0; c < kColumns.size(); ++c) at[c] = table.require(kColumns[c], "give a recording of haptic-player --record");
  const std::optional<std::size_t> depth = table.find("penetration_mm"), scene = table.find("scene"), touched = table.find("touched");
  Recording out;
  while (table.next()) {
    std::array<float, kColumns.size()> v{};
    for (std::size_t c = 0; c < kColumns.size(); ++c) v[c] = static_cast<float>(table.number(at[c]));
    if (!out.time.empty() && !(v[0] >= out.time.back())) table.failField(at[0], "the time decreases");
    if (depth) out.penetration.push_back(static_cast<float>(table.number(*depth)));
    if (scene && out.scene.empty()) out.scene = formats::decodedField(table.field(*scene));  // it is in the first row
    if (touched && !table.field(*touched).empty()) countTouch(out, formats::decodedField(table.field(*touched)));
    out.time.push_back(v[0]);
    out.hand.push_back({v[1], v[2], v[3], v[4], v[5], v[6], v[7]});
    out.tool.push_back({v[8], v[9], v[10], v[11], v[12], v[13], v[14]});
    out.wrench.push_back({v[15], v[16], v[17], v[18], v[19], v[20]});
    out.pairs.push_back(v[21]);
    out.faults.push_back(static_cast<std::uint32_t>(table.count(at[22], 0xffffffffu)));
    out.total_us.push_back(v[23]);
  }
  if (out.steps() == 0) throw formats::FormatError(path.string() + ": no step was recorded. Record the run again.");
  return out;
}

std::string remarkOnScene(const Recording& recording, const std::filesystem::path& file, const std::filesystem::path& scene_file) {
  namespace fs = std::filesystem;
  if (recording.scene.empty()) return "";
  std::error_code none;
  const fs::path made_in = fs::absolute(file).parent_path() / recording.scene;
  if (fs::equivalent(made_in, scene_file, none)) return "";
  if (recording.scene != "sample" && !fs::exists(made_in, none))
    return "It names the scene " + recording.scene + ", which was not found to be compared with this one.";
  if (recording.scene != "sample" && formats::readFile(made_in) == formats::readFile(scene_file)) return "";
  throw formats::FormatError(file.string() + ": was recorded in the scene " +
                             (recording.scene == "sample" ? "that is built into haptic-player" : made_in.lexically_normal().string()) +
                             ", not in " + scene_file.string() + ". Name a recording of this scene.");
}

std::vector<float> energyTaken(const Recording& r) {
  const auto poseOf = [](const std::array<float, 7>& p) {
    return Configuration{{p[0], p[1], p[2]}, Quaternion(p[3], p[4], p[5], p[6]).normalized()};
  };
  std::vector<float> out(r.steps(), 0);
  double energy = 0;
  for (std::size_t i = 1; i < r.steps(); ++i) {
    const Displacement way = displacementBetween(poseOf(r.hand[i - 1]), poseOf(r.hand[i]));
    const std::array<float, 6>& w = r.wrench[i - 1];
    if (way.translation.norm() <= kJump)
      energy -= Eigen::Vector3d(w[0], w[1], w[2]).dot(way.translation) + Eigen::Vector3d(w[3], w[4], w[5]).dot(way.rotation);
    out[i] = static_cast<float>(energy);
  }
  return out;
}

Spectrum spectrumOf(const std::vector<float>& values, double rate) {
  Spectrum out;
  if (values.size() < 16) return out;
  const std::size_t n = std::min<std::size_t>(1024, std::bit_floor(values.size()));
  std::vector<double> power(n / 2 + 1, 0);
  std::size_t windows = 0;
  for (std::size_t first = 0; first + n <= values.size(); first += n / 2, ++windows) {
    double mean = 0;
    for (std::size_t i = 0; i < n; ++i) mean += values[first + i] / static_cast<double>(n);
    std::vector<std::complex<double>> window(n);
    for (std::size_t i = 0; i < n; ++i)
      window[i] = (values[first + i] - mean) * 0.5 * (1 - std::cos(2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n)));
    fourier(window);
    for (std::size_t k = 0; k < power.size(); ++k) power[k] += std::norm(window[k]);
  }
  for (std::size_t k = 1; k < power.size(); ++k) {
    out.hertz.push_back(static_cast<float>(static_cast<double>(k) * rate / static_cast<double>(n)));
    // A sine of amplitude 1 gives n / 4: one half is at the negative frequency, and the window halves the rest.
    out.amplitude.push_back(static_cast<float>(std::sqrt(power[k] / static_cast<double>(windows)) * 4 / static_cast<double>(n)));
  }
  return out;
}

std::vector<float> forceLength(const Recording& r) {
  std::vector<float> out;
  for (const auto& w : r.wrench) out.push_back(std::hypot(w[0], w[1], w[2]));
  return out;
}

Json recordingFigures(const Recording& r) {
  const std::vector<float> force = forceLength(r), energy = energyTaken(r), away = distances(r);
  double torque = 0, step = 0;
  std::size_t faulty = 0;
  for (std::size_t i = 0; i < r.steps(); ++i) {
    const auto& w = r.wrench[i];
    torque = std::max<double>(torque, std::hypot(w[3], w[4], w[5]));
    if (i > 0) step = std::max<double>(step, std::hypot(w[0] - r.wrench[i - 1][0], w[1] - r.wrench[i - 1][1], w[2] - r.wrench[i - 1][2]));
    faulty += r.faults[i] != 0;
  }
  Json touched = Json::array();
  for (const auto& [name, steps] : r.touched) touched.push_back({{"name", name}, {"seconds", static_cast<double>(steps) / rateOf(r)}});
  return {
      {"steps", r.steps()},
      {"seconds", r.time.back() - r.time.front()},
      {"touched", touched},
      {"largest_force_n", *std::max_element(force.begin(), force.end())},
      {"largest_torque_n_mm", torque},
      {"largest_force_step_n", step},
      {"largest_hand_to_tool_mm", *std::max_element(away.begin(), away.end())},
      {"energy_mj", {{"smallest", *std::min_element(energy.begin(), energy.end())}, {"final", energy.back()}}},
      {"total_us",
       {{"median", tool::quantile(r.total_us, 0.5)}, {"p99", tool::quantile(r.total_us, 0.99)}, {"max", tool::quantile(r.total_us, 1)}}},
      {"steps_with_faults", faulty}};
}

std::string recordingCharts(const Recording& r) {
  const std::string seconds = "Time [s]";
  std::string out = "<div class=\"charts wide\">";
  out += traceCharts({"Force on the hand",
                      seconds,
                      "Force [N]",
                      r.time,
                      {traceOf("x", r.wrench, 0), traceOf("y", r.wrench, 1), traceOf("z", r.wrench, 2), {"length", forceLength(r)}},
                      false,
                      {}});
  out += traceCharts({"Torque on the hand",
                      seconds,
                      "Torque [N mm]",
                      r.time,
                      {traceOf("x", r.wrench, 3), traceOf("y", r.wrench, 4), traceOf("z", r.wrench, 5)},
                      false,
                      {}});
  out += traceCharts({"How far the hand has gone beyond the tool that is shown",
                      seconds,
                      "Distance [mm]",
                      r.time,
                      {{"distance", distances(r)}},
                      false,
                      {}});
  out += traceCharts({"Energy taken from the hand; below 0 the renderer has given energy",
                      seconds,
                      "Energy [mJ]",
                      r.time,
                      {{"energy", energyTaken(r)}},
                      false,
                      ScatterChart::Line{0, ""}});
  const Spectrum spectrum = spectrumOf(forceLength(r), rateOf(r));
  if (!spectrum.hertz.empty())
    out += traceCharts(
        {"Spectrum of the force", "Frequency [Hz]", "Amplitude [N]", spectrum.hertz, {{"force", spectrum.amplitude}}, true, {}});
  out += traceCharts({"Time of a servo step", seconds, "Time [us]", r.time, {{"step", r.total_us}}, false, {}});
  out += traceCharts({"Pairs of leaves in contact", seconds, "Pairs", r.time, {{"pairs", r.pairs}}, false, {}});
  return out + "</div>\n";
}

Json packRecording(PageData& data, const std::string& name, const Recording& r) {
  const std::size_t stride = std::max<std::size_t>(1, (r.steps() + 1999) / 2000);
  std::vector<float> time, poses, wrench;
  for (std::size_t i = 0; i < r.steps(); i += stride) {
    time.push_back(r.time[i]);
    poses.insert(poses.end(), r.hand[i].begin(), r.hand[i].end());
    poses.insert(poses.end(), r.tool[i].begin(), r.tool[i].end());
    wrench.insert(wrench.end(), r.wrench[i].begin(), r.wrench[i].end());
  }
  return {{"name", name},
          {"time", data.add(std::span<const float>(time))},
          {"poses", data.add(std::span<const float>(poses))},
          {"wrench", data.add(std::span<const float>(wrench))}};
}

}  // namespace spheretree::tool
