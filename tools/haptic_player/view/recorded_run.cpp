// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/recorded_run.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "servo_loop.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::player {
namespace {

constexpr std::array<const char*, 31> kColumns{"tick",   "t_s",           "hx_mm",  "hy_mm",   "hz_mm",   "hqw",    "hqx",     "hqy",
                                               "hqz",    "gx_mm",         "gy_mm",  "gz_mm",   "gqw",     "gqx",    "gqy",     "gqz",
                                               "fx_n",   "fy_n",          "fz_n",   "tx_nmm",  "ty_nmm",  "tz_nmm", "pairs",   "rows",
                                               "active", "qp_iterations", "faults", "find_us", "rows_us", "qp_us",  "total_us"};

void splitFields(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    if (end == line.size()) return;
    begin = end + 1;
  }
}

class RunReader {
 public:
  RunReader(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {}

  RecordedRun read() {
    splitFields(nextLine(), heads_);
    for (std::size_t c = 0; c < kColumns.size(); ++c) {
      at_[c] = placeOf(kColumns[c]);
      if (at_[c] == heads_.size()) fail(std::string("has no column '") + kColumns[c] + "'. Give a recording of haptic-player --record");
    }
    penetration_ = placeOf("penetration_mm");
    scene_ = placeOf("scene");
    settings_ = placeOf("settings");
    hinges_ = placeOf("hinges_deg");
    while (!text_.empty()) readRow(nextLine());
    if (out_.steps.empty()) fail("is the last: no step was recorded");
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw formats::FormatError(name_ + ": line " + std::to_string(line_) + " " + what);
  }
  std::size_t placeOf(std::string_view head) const {
    return static_cast<std::size_t>(std::find(heads_.begin(), heads_.end(), head) - heads_.begin());
  }
  std::string_view nextLine() {
    const std::size_t end = std::min(text_.find('\n'), text_.size());
    std::string_view line = text_.substr(0, end);
    text_.remove_prefix(std::min(end + 1, text_.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    ++line_;
    return line;
  }
  template <class Number>
  Number number(std::size_t column) const {
    const std::string_view field = fields_[column];
    Number value{};
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(static_cast<double>(value)))
      fail("has in column " + std::string(heads_[column]) + " '" + std::string(field.substr(0, 40)) + "', which is no such number");
    return value;
  }
  Configuration pose(std::size_t c) const {
    const auto v = [&](std::size_t k) { return number<double>(at_[c + k]); };
    return {{v(0), v(1), v(2)}, {v(3), v(4), v(5), v(6)}};
  }

  HingeAngles angles(std::string_view field) const {
    HingeAngles out{};
    for (std::size_t k = 0; k < kMostHinges && !field.empty(); ++k) {
      const std::size_t end = std::min(field.find(';'), field.size());
      const auto [stop, error] = std::from_chars(field.data(), field.data() + end, out[k]);
      if (error != std::errc() || stop != field.data() + end || !(std::abs(out[k]) <= 360))
        fail("has in column hinges_deg '" + std::string(field.substr(0, 40)) + "', which are no angles");
      field.remove_prefix(std::min(end + 1, field.size()));
    }
    return out;
  }

  void readRow(std::string_view line) {
    splitFields(line, fields_);
    if (fields_.size() != heads_.size())
      fail("has " + std::to_string(fields_.size()) + " fields, the first line " + std::to_string(heads_.size()));
    const auto real = [&](std::size_t c) { return number<double>(at_[c]); };
    const auto count = [&](std::size_t c) { return number<std::uint32_t>(at_[c]); };
    RecordedStep step;
    step.tick = number<std::uint64_t>(at_[0]);
    step.time = real(1);
    step.haptic = pose(2);
    step.graphic = pose(9);
    step.wrench = {{real(16), real(17), real(18)}, {real(19), real(20), real(21)}};
    step.pairs = count(22);
    step.rows = count(23);
    step.active = count(24);
    step.qp_iterations = count(25);
    step.faults = count(26);
    step.find_us = real(27);
    step.rows_us = real(28);
    step.qp_us = real(29);
    step.total_us = real(30);
    if (hinges_ < heads_.size()) step.hinges = angles(fields_[hinges_]);
    if (penetration_ < heads_.size()) step.penetration = number<double>(penetration_);
    for (const Configuration& tool : {step.haptic, step.graphic})
      if (!(std::abs(tool.orientation.norm() - 1) < 1e-3)) fail("has a quaternion that is not of length 1");
    if (!out_.steps.empty() && step.time < out_.steps.back().time) fail("goes back in time");
    if (out_.steps.empty()) {
      if (scene_ < heads_.size()) out_.identity.scene = decodedField(fields_[scene_]);
      if (settings_ < heads_.size()) out_.identity.settings = decodedField(fields_[settings_]);
    }
    out_.steps.push_back(step);
  }

  std::string_view text_;
  std::string name_;
  std::size_t line_ = 0, penetration_ = 0, scene_ = 0, settings_ = 0, hinges_ = 0;
  std::vector<std::string_view> heads_, fields_;
  std::array<std::size_t, kColumns.size()> at_{};
  RecordedRun out_;
};

/// The word after "key=" in the settings of a recording; empty: there is none.
std::string wordOf(const std::string& settings, const std::string& key) {
  const std::string marked = " " + settings + " ";
  const std::size_t found = marked.find(" " + key + "=");
  if (found == std::string::npos) return {};
  const std::size_t begin = found + key.size() + 2;
  return marked.substr(begin, marked.find(' ', begin) - begin);
}

/// Close enough for the contacts of one to be those of the other.
bool isSame(const RecordedStep& recorded, const runtime::StepResult& again) {
  const Displacement apart = displacementBetween(recorded.graphic, again.graphic);
  return apart.translation.norm() < 1e-3 && apart.rotation.norm() < 1e-3;
}

}  // namespace

RecordedRun readRun(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = formats::readFile(path);
  return RunReader({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, path.string()).read();
}

std::filesystem::path sceneOf(const RecordedRun& run, const std::filesystem::path& recording) {
  if (run.identity.scene.empty())
    throw formats::FormatError(recording.string() +
                               ": does not say which scene it belongs to. Name the scene: haptic-player SCENE.json "
                               "--view --replay " +
                               recording.string());
  if (run.identity.scene == kSampleScene) return {};
  return std::filesystem::absolute(recording).parent_path() / run.identity.scene;
}

runtime::Mode modeOf(const RecordedRun& run, const std::filesystem::path& recording) {
  const std::string mode = wordOf(run.identity.settings, "mode");
  if (mode == "paper") return runtime::Mode::Paper;
  if (mode.empty() || mode == "constrained") return runtime::Mode::Constrained;
  throw formats::FormatError(recording.string() + ": was made in the mode '" + mode + "', which this version does not know");
}

view::LiveState ShownRun::at(std::size_t step) const {
  view::LiveState out;
  out.step = steps[step];
  if (contact_begin.size() <= step + 1) return out;
  for (std::uint32_t k = contact_begin[step]; k < contact_begin[step + 1] && out.contact_count < out.contacts.size(); ++k)
    out.contacts[out.contact_count++] = contacts[k];
  return out;
}

ShownRun shownRun(std::vector<RecordedStep> steps, const runtime::Scene& scene, runtime::Mode mode, const BodyPaths& bodies) {
  ShownRun out;
  out.steps = std::move(steps);
  runtime::Workspace workspace(scene);
  std::size_t differ = 0;
  out.contact_begin.push_back(0);
  for (const RecordedStep& step : out.steps) {
    bodies.moveTo(step.time, step.hinges, workspace);
    // A recording may begin in the middle of a run.
    if (out.contact_begin.size() == 1) runtime::resetTo(step.graphic, workspace);
    if (isSame(step, runtime::step(scene, step.haptic, mode, workspace))) {
      for (const runtime::Contact& contact : runtime::contacts(workspace)) out.contacts.push_back(shownContact(contact));
    } else {
      ++differ;
      runtime::resetTo(step.graphic, workspace);
    }
    out.contact_begin.push_back(static_cast<std::uint32_t>(out.contacts.size()));
  }
  if (differ > 1 + out.steps.size() / 100)
    out.note = "Contacts are missing in " + std::to_string(differ) + " steps: scene or program have changed since the recording.";
  return out;
}

}  // namespace spheretree::player
