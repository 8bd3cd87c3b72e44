// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/evaluate/evaluate_states_report.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "json_text.h"
#include "pipeline/tissue/states_file.h"
#include "program_end.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/core/mesh_edit.h"
#include "terminal.h"
#include "tissue/evaluate_states.h"

namespace spheretree::tool {
namespace {

using builder::StateFigures;

/// Figures of the states of one kind, with the worst value of each.
struct KindFigures {
  std::size_t states = 0, bare = 0, faults = 0, inverted = 0;
  double largest_amount = 0, largest_stretch = 0;
  double overhang = 0;  // over the states that have one [mm]
  bool has_overhang = false;
};

KindFigures figuresOf(const std::vector<StateFigures>& states, const std::string& kind) {
  KindFigures out;
  for (const StateFigures& s : states) {
    if (s.kind != kind) continue;
    ++out.states;
    out.bare += s.bare_samples;
    out.faults += !s.fault.empty();
    out.inverted = std::max(out.inverted, s.strain.inverted);
    out.largest_amount = std::max(out.largest_amount, s.amount);
    out.largest_stretch = std::max(out.largest_stretch, s.strain.largest_stretch);
    if (s.overhang_mm) out.overhang = std::max(out.overhang, *s.overhang_mm), out.has_overhang = true;
  }
  return out;
}

std::vector<std::string> kindsOf(const std::vector<StateFigures>& states) {
  std::vector<std::string> kinds;
  for (const StateFigures& s : states)
    if (std::find(kinds.begin(), kinds.end(), s.kind) == kinds.end()) kinds.push_back(s.kind);
  return kinds;
}

void printTable(const builder::StatesEvaluation& e) {
  printResult("%zu leaves, overhang at rest at most %.4g mm; %zu states of %zu samples\n\n", e.leaves, e.rest_overhang_mm, e.states.size(),
              e.samples);
  printResult("kind      states  largest  stretch  inverted    uncovered  unsound trees  overhang [mm]  over rest\n");
  for (const std::string& kind : kindsOf(e.states)) {
    const KindFigures f = figuresOf(e.states, kind);
    printResult("%-8s  %6zu  %7.3g  %7.3g  %8zu  %12zu  %13zu", kind.c_str(), f.states, f.largest_amount, f.largest_stretch, f.inverted,
                f.bare, f.faults);
    if (f.has_overhang)
      printResult("  %13.4g  %9.3g\n", f.overhang, f.overhang / e.rest_overhang_mm);
    else
      printResult("              -          -\n");
  }
}

nlohmann::ordered_json jsonOf(const builder::StatesEvaluation& e) {
  nlohmann::ordered_json out{
      {"schema", "spheretree.states/1"}, {"leaves", e.leaves}, {"samples", e.samples}, {"rest_overhang_mm", e.rest_overhang_mm}};
  out["states"] = nlohmann::ordered_json::array();
  for (const StateFigures& s : e.states)
    out["states"].push_back({{"kind", s.kind},
                             {"amount", s.amount},
                             {"largest_stretch", s.strain.largest_stretch},
                             {"smallest_stretch", s.strain.smallest_stretch},
                             {"inverted_tetrahedra", s.strain.inverted},
                             {"bare_samples", s.bare_samples},
                             {"overhang_mm", s.overhang_mm ? nlohmann::ordered_json(*s.overhang_mm) : nlohmann::ordered_json(nullptr)},
                             {"largest_radius_mm", s.largest_radius_mm},
                             {"fault", s.fault}});
  return out;
}

}  // namespace

int reportStates(const std::string& name, const SphereTree& tree, const Tissue& tissue, const builder::RepairedMesh& mesh,
                 const StatesOptions& options, builder::Progress& progress) {
  if (tree.provenance.mesh_hash != builder::meshHash(mesh.mesh))
    throw builder::BuildError(name + " belongs to another mesh, or to one with another --unit, --parts or --repair");
  const TriangleMesh surface = joined(mesh.mesh, mesh.to_cover);
  if (surface.positions.size() != tissue.surface.size())
    throw builder::BuildError(name + " has a number of vertices other than the mesh. Soften it again");
  std::size_t count = 0;
  std::vector<builder::TissueState> listed;
  const char* last = options.states.data() + options.states.size();
  const auto [end, error] = std::from_chars(options.states.data(), last, count);
  const bool is_number = error == std::errc() && end == last;
  if (is_number && (count < 1 || count > pipeline::kMaxStates)) throw UsageError("--states: the number of states must be 1 to 100000.");
  if (!is_number) listed = pipeline::readStates(options.states, tissue.nodes.size()), count = listed.size();
  const auto state = [&](std::size_t i) { return is_number ? builder::sampleState(tissue, i, count, options.seed) : listed[i]; };
  progress.stage("states");
  const int threads = options.threads > 0 ? options.threads : tbb::this_task_arena::max_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(std::max(threads, 1)));
  const builder::StatesEvaluation e = builder::evaluateStates(mesh.mesh, surface, tree, tissue, count, state,
                                                              static_cast<std::size_t>(options.samples), options.seed, progress);
  clearProgressLine();
  if (options.json)
    writeResult(jsonText(jsonOf(e), 2) + "\n");
  else
    printTable(e);
  const auto isBroken = [](const StateFigures& s) { return s.bare_samples > 0 || !s.fault.empty(); };
  if (std::none_of(e.states.begin(), e.states.end(), isBroken)) return kExitOk;
  say("spheretree evaluate: the leaves do not hold the moved surface in every state. That is a fault of this program; please report it.");
  return kExitInternal;
}

}  // namespace spheretree::tool
