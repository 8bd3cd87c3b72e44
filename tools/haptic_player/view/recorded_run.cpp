// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/recorded_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "run/servo_loop.h"
#include "spheretree/formats/csv_table.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::player {
namespace {

constexpr std::array<const char*, 31> kColumns{"tick",   "t_s",           "hx_mm",  "hy_mm",   "hz_mm",   "hqw",    "hqx",     "hqy",
                                               "hqz",    "gx_mm",         "gy_mm",  "gz_mm",   "gqw",     "gqx",    "gqy",     "gqz",
                                               "fx_n",   "fy_n",          "fz_n",   "tx_nmm",  "ty_nmm",  "tz_nmm", "pairs",   "rows",
                                               "active", "qp_iterations", "faults", "find_us", "rows_us", "qp_us",  "total_us"};

class RunReader {
 public:
  RunReader(std::string_view text, const std::string& name)
      : table_(text, name),
        penetration_(table_.find("penetration_mm")),
        scene_(table_.find("scene")),
        settings_(table_.find("settings")),
        hinges_(table_.find("hinges_deg")),
        tissue_(table_.find("tissue_states")),
        spin_(table_.find("spin")),
        removed_(table_.find("removed_mm3")),
        layer_(table_.find("layer")) {
    for (std::size_t c = 0; c < kColumns.size(); ++c) at_[c] = table_.require(kColumns[c], "give a recording of haptic-player --record");
  }

  RecordedRun read() {
    while (table_.next()) readRow();
    if (out_.steps.empty()) table_.fail("no step was recorded");
    return std::move(out_);
  }

 private:
  double real(std::size_t c) const { return table_.number(at_[c]); }
  std::uint32_t count(std::size_t c) const { return static_cast<std::uint32_t>(table_.count(at_[c], 0xffffffffu)); }
  Configuration pose(std::size_t c) const {
    const Configuration tool{{real(c), real(c + 1), real(c + 2)}, {real(c + 3), real(c + 4), real(c + 5), real(c + 6)}};
    if (!(std::abs(tool.orientation.norm() - 1) < 1e-3)) table_.failField(at_[c + 3], "the quaternion is not of length 1");
    return tool;
  }

  HingeAngles angles() const {
    HingeAngles out{};
    const std::vector<double> read = table_.numbers(*hinges_, 360);
    std::copy_n(read.begin(), std::min(read.size(), kMaxHinges), out.begin());
    return out;
  }

  std::uint32_t layerOf(const std::string& name) {
    if (name.empty()) return kUntouched;
    std::vector<std::string>& names = out_.identity.layers;
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) return names.push_back(name), static_cast<std::uint32_t>(names.size() - 1);
    return static_cast<std::uint32_t>(found - names.begin());
  }

  void readRow() {
    RecordedStep step;
    step.tick = table_.count(at_[0], UINT64_MAX);
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
    if (hinges_) step.hinges = angles();
    if (tissue_) step.tissue_states = static_cast<std::uint32_t>(table_.count(*tissue_, 0xffffffffu));
    if (spin_) step.spins = table_.count(*spin_, 1) == 1;
    if (removed_) step.removed = table_.number(*removed_);
    if (layer_) step.layer = layerOf(formats::decodedField(table_.field(*layer_)));
    if (penetration_) step.penetration = table_.number(*penetration_);
    if (!out_.steps.empty() && step.time < out_.steps.back().time) table_.failField(at_[1], "the time decreases");
    if (out_.steps.empty()) {
      if (scene_) out_.identity.scene = formats::decodedField(table_.field(*scene_));
      if (settings_) out_.identity.settings = formats::decodedField(table_.field(*settings_));
    }
    out_.steps.push_back(step);
  }

  formats::CsvTable table_;
  std::optional<std::size_t> penetration_, scene_, settings_, hinges_, tissue_, spin_, removed_, layer_;
  std::array<std::size_t, kColumns.size()> at_{};
  RecordedRun out_;
};

/// The word after "key=" in the settings of a recording; empty if there is none.
std::string wordOf(const std::string& settings, const std::string& key) {
  const std::string marked = " " + settings + " ";
  const std::size_t found = marked.find(" " + key + "=");
  if (found == std::string::npos) return {};
  const std::size_t begin = found + key.size() + 2;
  return marked.substr(begin, marked.find(' ', begin) - begin);
}

/// Whether two steps are close enough for the contacts of one to be those of the other.
bool isSame(const RecordedStep& recorded, const runtime::StepResult& again) {
  const Displacement apart = displacementBetween(recorded.graphic, again.graphic);
  return apart.translation.norm() < 1e-3 && apart.rotation.norm() < 1e-3;
}

}  // namespace

RecordedRun readRun(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = formats::readFile(path);
  RecordedRun run = RunReader({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, path.string()).read();
  if (const std::string rate = wordOf(run.identity.settings, "rate"); !rate.empty())
    throw formats::FormatError(path.string() + ": was recorded at " + rate +
                               " Hz, and views show a step for each millisecond. Play it again as a trajectory: haptic-player SCENE.json "
                               "--view --trajectory " +
                               path.string() + " --hand-from file");
  return run;
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
  if (mode == "paper") return runtime::Mode::Published;
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

TissueShapes ShownRun::tissueAt(std::size_t step) const {
  if (tissue.empty()) return {};
  return tissue[std::min<std::size_t>((steps[step].tissue_states - steps[0].tissue_states) / kShownStates, tissue.size() - 1)];
}

ShownRun shownRun(std::vector<RecordedStep> steps, const runtime::Scene& scene, runtime::Mode mode, const BodyPaths& bodies,
                  TissueMotion* tissue) {
  ShownRun out;
  out.steps = std::move(steps);
  runtime::Workspace workspace(scene);
  std::size_t differ = 0;
  const std::uint32_t first = out.steps.empty() ? 0 : out.steps[0].tissue_states;
  std::uint32_t states = first > 0 ? first - 1 : 0;
  out.contact_begin.push_back(0);
  for (const RecordedStep& step : out.steps) {
    bodies.moveTo(step.time, step.hinges, workspace);
    // A recording may begin in the middle of a run.
    if (out.contact_begin.size() == 1) runtime::resetTo(step.graphic, workspace);
    if (tissue) tissue->take(step.tick, workspace, step.tissue_states != states);
    if (tissue && step.tissue_states != states && (step.tissue_states - first) / kShownStates >= out.tissue.size())
      out.tissue.push_back(tissue->shapes());
    states = step.tissue_states;
    (void)runtime::setSpindle(step.spins, workspace);
    if (isSame(step, runtime::step(scene, step.haptic, mode, workspace))) {
      for (const runtime::Contact& contact : runtime::contacts(workspace)) out.contacts.push_back(shownContact(contact));
    } else {
      ++differ;
      runtime::resetTo(step.graphic, workspace);
      if (tissue) tissue->restart();
    }
    out.contact_begin.push_back(static_cast<std::uint32_t>(out.contacts.size()));
  }
  if (differ > 1 + out.steps.size() / 100)
    out.note = "Contacts are missing in " + std::to_string(differ) + " steps: scene or program have changed since the recording.";
  return out;
}

}  // namespace spheretree::player
