// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bindings.h"
#include "core/arrays.h"
#include "interruptible.h"
#include "mesh_argument.h"
#include "pipeline/evaluation_json.h"
#include "spheretree/builder/evaluate_tree.h"
#include "spheretree/builder/provenance.h"

namespace spheretree::python {
namespace {

using builder::Coverage;
using builder::CoverLimits;
using builder::Evaluation;
using builder::LevelEvaluation;
using builder::Overhang;

Evaluation evaluate(const py::object& mesh, const PythonTree& tree, const py::object& triangles, bool limits, bool lower_bound,
                    double effort, const std::string& repair, std::uint64_t seed, int threads, const py::object& progress) {
  const auto given = meshArgument(mesh, triangles);
  const builder::RepairKind kind = repairArgument(repair);
  Evaluation evaluation;
  std::vector<std::string> notes;
  runInterruptibly(progress, [&](builder::Progress& p) {
    const builder::RepairedMesh repaired = builder::repairMesh(given->mesh, kind, p);
    for (const builder::RepairStep& step : repaired.steps) notes.push_back(step.text);
    if (!repaired.isSound())
      notes.push_back("the mesh is not a closed, clean surface, so that inside and outside are uncertain; check() says where.");
    const Hash128& made_of = tree->provenance.mesh_hash;
    if (made_of != Hash128{} && made_of != builder::meshHash(repaired.mesh))
      notes.push_back("the tree was built from another mesh, or with another repair. The figures compare the two as given.");
    p.check();
    evaluation = builder::evaluateTree(repaired.mesh, *tree, {limits, lower_bound, effort, seed, threads}, p, repaired.to_cover);
  });
  warn(given->name, notes);
  return evaluation;
}

void bindFigures(py::module_& module) {
  py::class_<Overhang>(module, "Overhang", "Overhang of spheres: how far they reach out of the object.")
      .def_readonly("max", &Overhang::max, "Largest found, at `worst_point` [mm].")
      .def_readonly("bound", &Overhang::bound, "Proven upper bound [mm].")
      .def_readonly("p99", &Overhang::p99, "99th percentile over the part of the spheres' surface that is outside, by area [mm].")
      .def_readonly("mean", &Overhang::mean, "Mean over the same [mm].")
      .def_readonly("outside_area", &Overhang::outside_area, "[mm^2].")
      .def_property_readonly(
          "worst_point", [](const Overhang& o) { return arrayOf(o.worst_point); }, "Shape (3,) [mm].");
  py::class_<Coverage>(module, "Coverage", "The part of the surface that no sphere covers.")
      .def_readonly("uncovered_fraction", &Coverage::uncovered_fraction, "Share of the area, 0 to 1, estimated by samples.")
      .def_readonly("max_gap", &Coverage::max_gap, "Largest distance of a surface point from the spheres; 0 if there is none [mm].")
      .def_readonly("max_gap_bound", &Coverage::max_gap_bound, "Proven upper bound on any gap [mm].")
      .def_property_readonly(
          "worst_point", [](const Coverage& c) { return arrayOf(c.worst_point); }, "Shape (3,) [mm].");
  py::class_<LevelEvaluation>(module, "LevelEvaluation", "The figures of one level.")
      .def_readonly("level", &LevelEvaluation::level, "From 0, the root.")
      .def_readonly("spheres", &LevelEvaluation::spheres, "How many.")
      .def_readonly("overhang", &LevelEvaluation::overhang, "How far the spheres reach out of the object.")
      .def_readonly("coverage", &LevelEvaluation::coverage, "The part of the surface that they leave uncovered.")
      .def_readonly("excess_volume_fraction", &LevelEvaluation::excess_volume_fraction,
                    "Volume of the spheres outside the mesh, over the mesh's volume.")
      .def_readonly("missing_volume_fraction", &LevelEvaluation::missing_volume_fraction,
                    "Volume of the mesh outside the spheres, over its volume.");
  py::class_<CoverLimits>(module, "CoverLimits", "Estimates of the smallest overhang that any such cover can have.")
      .def_readonly("h_fin", &CoverLimits::h_fin, "Overhang of the best cover of a surface that is flat compared with the spheres [mm].")
      .def_readonly("h_low", &CoverLimits::h_low, "Lower bound without that assumption, itself approximate [mm].");
}

}  // namespace

void bindEvaluate(py::module_& module) {
  bindFigures(module);
  py::class_<Evaluation>(module, "Evaluation", "How well every level of a tree approximates a mesh.")
      .def_readonly("diagonal", &Evaluation::diagonal, "Diagonal of the bounding box of the mesh [mm].")
      .def_readonly("tolerance", &Evaluation::tolerance, "Of coverage and enclosure [mm].")
      .def_readonly("levels", &Evaluation::levels, "From the root.")
      .def_readonly("limits", &Evaluation::limits, "Limits for the deepest level; None without limits=True.")
      .def(
          "to_dict", [](const Evaluation& e) { return py::module_::import("json").attr("loads")(pipeline::evaluationJson(e).dump()); },
          "All figures as `spheretree evaluate --json` prints them.");
  module.def("evaluate", &evaluate, py::arg("mesh"), py::arg("tree"), py::arg("triangles") = py::none(), py::kw_only(),
             py::arg("limits") = true, py::arg("lower_bound") = false, py::arg("effort") = 1.0, py::arg("repair") = "auto",
             py::arg("seed") = 1, py::arg("threads") = 0, py::arg("progress") = py::none(),
             R"(Measures how well every level of a tree approximates a mesh.

mesh: a Mesh, or vertices (n, 3) [mm], with `triangles` (m, 3). limits: also estimate the best possible cover.
lower_bound: also prove how small its overhang can be (to_dict()["proven_limit"]), a minute for 512 leaves.
effort: share of the samples, above 0 to 1. repair, seed, threads, progress: as for build().
Cost: 1 to 2 s on one core for 4,000 triangles and 585 nodes. Raises ValueError, KeyboardInterrupt.)");
}

}  // namespace spheretree::python
