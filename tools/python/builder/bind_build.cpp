// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bindings.h"
#include "interruptible.h"
#include "mesh_argument.h"
#include "pipeline/builder_names.h"
#include "pipeline/sound_mesh.h"
#include "spheretree/builder/build_sphere_tree.h"

namespace spheretree::python {
namespace {

using builder::BuilderKind;
using builder::BuildResult;
using builder::BuildSettings;

template <class Kinds>
auto kindNamed(const Kinds& kinds, const std::string& name, const char* argument) {
  std::string known;
  for (const auto kind : kinds) {
    if (builder::name(kind) == name) return kind;
    known += (known.empty() ? "" : ", ") + std::string(builder::name(kind));
  }
  throw py::value_error(std::string(argument) + " must be one of " + known + ", not " + name + ".");
}

/// "auto", None for no skin, or a tolerance.
void setSkin(BuildSettings& settings, const py::object& skin) {
  settings.skin = !skin.is_none();
  if (skin.is_none() || (py::isinstance<py::str>(skin) && skin.cast<std::string>() == "auto")) return;
  if (!py::isinstance<py::float_>(skin) && !py::isinstance<py::int_>(skin))
    throw py::type_error("skin must be 'auto', None or a length in mm.");
  settings.skin_tolerance_mm = skin.cast<double>();
  if (!(settings.skin_tolerance_mm > 0)) throw py::value_error("skin must be above 0 mm; None builds no skin.");
}

double positive(std::optional<double> value, const char* name) {
  if (value && !(*value > 0)) throw py::value_error(std::string(name) + " must be above 0.");
  return value.value_or(0);
}

py::dict statisticsOf(const BuildSettings& settings, const BuildResult& result, const builder::RepairedMesh& repaired) {
  py::dict out;
  double total = 0;
  py::list stages, levels, steps;
  for (const builder::BuildStatistics::Stage& stage : result.statistics.stages) {
    stages.append(py::make_tuple(stage.name, stage.seconds));
    total += stage.seconds;
  }
  for (const builder::LevelBuildStatistics& level : result.statistics.levels) {
    py::dict of_level;
    of_level["spheres"] = level.spheres;
    of_level["overhang_bound_mm"] = level.overhang_bound_mm;
    of_level["largest_growth_mm"] = level.largest_growth_mm;
    levels.append(of_level);
  }
  for (const builder::RepairStep& step : repaired.steps) steps.append(step.text);
  out["seconds"] = total;
  out["stages"] = stages;
  out["levels"] = levels;
  out["tolerance_met"] = settings.tolerance_mm > 0 ? py::object(py::bool_(result.statistics.tolerance_met)) : py::object(py::none());
  out["certified_pieces"] = result.statistics.certified_pieces;
  out["repair"] = steps;
  return out;
}

std::shared_ptr<PythonTree> buildTree(const PythonMesh& given, const BuildSettings& settings, builder::RepairKind repair,
                                      const py::object& progress) {
  builder::RepairedMesh repaired;
  std::optional<BuildResult> result;
  std::vector<std::string> notes;
  runInterruptibly(progress, [&](builder::Progress& p) {
    p.stage("check");
    repaired = pipeline::soundMesh(given.mesh, given.name, repair, notes, p);
    p.check();
    result = builder::buildSphereTree(repaired.mesh, settings, p, repaired.to_cover);
  });
  notes.insert(notes.end(), result->statistics.notes.begin(), result->statistics.notes.end());
  const py::dict statistics = statisticsOf(settings, *result, repaired);
  if (settings.tolerance_mm > 0 && !result->statistics.tolerance_met)
    notes.push_back(
        "the tolerance is not met; this is the best tree with these levels. Allow more levels or leaves, or a larger tolerance.");
  warn(given.name, notes);
  return std::make_shared<PythonTree>(std::move(result->tree), statistics);
}

std::shared_ptr<PythonTree> build(const py::object& mesh, const py::object& triangles, std::optional<double> tolerance, int levels,
                                  int branching, std::optional<int> leaves, const std::string& quality, const std::string& builder,
                                  const std::vector<std::string>& combine, bool search, const std::string& medial_axis,
                                  const py::object& skin, double crease_angle, const std::string& repair, std::uint64_t seed, int threads,
                                  const py::object& progress) {
  BuildSettings s;
  s.tolerance_mm = positive(tolerance, "tolerance");
  s.levels = levels;
  s.branching = branching;
  if (leaves && *leaves < 1) throw py::value_error("leaves must be at least 1.");
  s.max_leaves = leaves.value_or(0);
  s.quality = kindNamed(pipeline::kQualities, quality, "quality");
  s.builder = kindNamed(pipeline::kBuilders, builder, "builder");
  for (const std::string& member : combine) s.combine.push_back(kindNamed(pipeline::kMembers, member, "combine"));
  if (s.builder == BuilderKind::Combined && s.combine.empty()) s.combine = {BuilderKind::Expand, BuilderKind::Merge, BuilderKind::Burst};
  s.search = search;
  s.medial_axis = kindNamed(pipeline::kMedialAxes, medial_axis, "medial_axis");
  setSkin(s, skin);
  s.crease_angle_deg = crease_angle;
  s.seed = seed;
  s.threads = threads;
  const auto given = meshArgument(mesh, triangles);
  s.unit_mm = given->unit_mm;
  builder::validate(s);
  return buildTree(*given, s, repairArgument(repair), progress);
}

}  // namespace

void bindBuild(py::module_& module) {
  const BuildSettings defaults;
  module.def("build", &build, py::arg("mesh"), py::arg("triangles") = py::none(), py::kw_only(), py::arg("tolerance") = py::none(),
             py::arg("levels") = defaults.levels, py::arg("branching") = defaults.branching, py::arg("leaves") = py::none(),
             py::arg("quality") = "standard", py::arg("builder") = "cover", py::arg("combine") = py::list(), py::arg("search") = false,
             py::arg("medial_axis") = "adaptive", py::arg("skin") = "auto", py::arg("crease_angle") = defaults.crease_angle_deg,
             py::arg("repair") = "auto", py::arg("seed") = defaults.seed, py::arg("threads") = defaults.threads,
             py::arg("progress") = py::none(),
             R"(Builds the sphere-tree of a mesh: every level provably covers the surface.

mesh: a Mesh, or vertices (n, 3) [mm] with triangles (m, 3), counter-clockwise seen from outside.
tolerance: largest overhang of the leaves, > 0 [mm], met with the fewest spheres; None (default): as many leaves as allowed.
levels: 2 to 6 with the root (4). branching: 2 to 8 (8). leaves: their largest number (branching ** (levels - 1)).
quality: "quick", "standard" (default) or "best". builder: "cover" (default) or a published one; combine: reducers of
"combined"; search: the cover search distributes the balls of a published builder; medial_axis: "adaptive" or "static". skin: "auto" (default), its tolerance [mm], or None. crease_angle: 1 to 180 (50) [degrees].
repair: "auto" (default), "off" or "wrap"; a change, and a tolerance that is not met, is reported as a MeshWarning.
seed: 0 to 2**64 - 1 (1). threads: 0 (all) to 1024; the tree does not depend on it.
progress: called as progress(stage, fraction) from the calling thread; an exception that it raises ends the build.

The same mesh and settings give the same bytes as `spheretree build`. The GIL is released; Ctrl-C cancels.
Raises BuildError for a mesh that is refused, ValueError and TypeError for settings, KeyboardInterrupt.)");
}

}  // namespace spheretree::python
