// SPDX-License-Identifier: GPL-3.0-or-later
// Feeds any text to the readers of recordings (replay, page), states of tissue and lists of patients: each refuses it
// with a reason that names the file, or gives what replay and page can show.
#include <cmath>

#include "fuzz/fuzz_target.h"
#include "page/recording.h"
#include "pipeline/tissue/states_file.h"
#include "spheretree/formats/cohort_list.h"
#include "spheretree/formats/errors.h"
#include "view/recorded_run.h"

namespace spheretree::fuzz {
namespace {

constexpr std::size_t kNodes = 20;

template <class Read>
void refusedOr(const Read& read, const std::string& name) {
  try {
    read();
  } catch (const formats::FormatError& error) {
    require(std::string(error.what()).starts_with(name), "a refusal names the file");
  }
}

void feedReplay(const std::filesystem::path& path) {
  const player::RecordedRun run = player::readRun(path);
  require(!run.steps.empty(), "a run has a step");
  double time = run.steps.front().time;
  for (const player::RecordedStep& step : run.steps) {
    require(isFinite(step.haptic) && isFinite(step.graphic) && step.wrench.force.allFinite() && step.wrench.torque.allFinite(),
            "what is shown is finite");
    require(step.time >= time, "time increases");
    require(step.layer == player::kUntouched || step.layer < run.identity.layers.size(), "a layer has a name");
    time = step.time;
  }
  refusedOr([&] { (void)player::sceneOf(run, path); }, path.string());
  refusedOr([&] { (void)player::modeOf(run, path); }, path.string());
}

void feedPage(const std::filesystem::path& path) {
  const tool::Recording recording = tool::readRecording(path);
  require(recording.hand.size() == recording.steps() && recording.total_us.size() == recording.steps(), "each step has all columns");
  (void)tool::recordingFigures(recording);
  (void)tool::recordingCharts(recording);
}

}  // namespace

std::vector<std::string> seeds() {
  const std::string numbers = "0,0,1,2,3,1,0,0,0,1,2,3,1,0,0,0,0.5,0,0,0,0,0,3,2,1,4,0,1.5,2.5,3.5,9,0",
                    next = "1,0.001" + numbers.substr(3);
  std::string head(player::recordingHeader());
  head.pop_back();
  return {head + "\n" + numbers + "\n" + next + "\n",
          head + ",scene,settings,touched,friction_n,slip_mm_s,hinges_deg,tissue_states,spin,removed_mm3,layer\n" + numbers +
              ",a.scene.json,mode=constrained contact=skin,tooth_11,0.1,0.2,12;3,4,1,0.25,enamel\n" + next +
              ",,,tooth%2C1,0,0,1;2,5,0,0.5,dentine\n",
          "state,node,dx_mm,dy_mm,dz_mm\n0,1,0.5,0,0\n0,2,0,-1e-3,0\n2,19,0,0,1\n",
          "{\"patient\": \"P1\", \"scene\": \"a/mouth.scene.json\"}\n{\"patient\": \"P-2_b.c\", \"scene\": \"b.json\"}\n"};
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace spheretree;
  const std::filesystem::path path = fuzz::asFile(data, size);
  fuzz::refusedOr([&] { fuzz::feedReplay(path); }, path.string());
  fuzz::refusedOr([&] { fuzz::feedPage(path); }, path.string());
  fuzz::refusedOr([&] { (void)pipeline::readStates(path, fuzz::kNodes); }, path.string());
  fuzz::refusedOr([&] { (void)formats::parseCohortList({reinterpret_cast<const char*>(data), size}, "list"); }, "list");
  return 0;
}
