// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "bindings.h"
#include "interruptible.h"
#include "json_text.h"
#include "pipeline/batch/batch.h"

namespace spheretree::python {
namespace {

namespace py = pybind11;

/// A number of leaves, or a time such as "20us".
std::optional<pipeline::Budget> budgetFrom(const py::object& budget) {
  if (budget.is_none()) return std::nullopt;
  pipeline::Budget out;
  if (py::isinstance<py::int_>(budget)) {
    out.amount = budget.cast<double>();
  } else if (py::isinstance<py::str>(budget) && budget.attr("endswith")("us").cast<bool>()) {
    out.is_time = true;
    out.amount = py::float_(budget.attr("removesuffix")("us")).cast<double>();
  } else {
    throw py::type_error("budget must be a number of leaves or a time such as '20us'.");
  }
  if (!(out.amount > 0 && out.amount <= 1e9)) throw py::value_error("budget must be above 0 and at most 10^9.");
  return out;
}

/// Forwards stages and fractions of a batch to an observer, and its request to stop to the batch.
class ForwardedProgress final : public tool::WorkProgress {
 public:
  explicit ForwardedProgress(builder::Progress& watcher) : watcher_(watcher) {}
  void stage(std::string_view name) override {
    watcher_.stage(name);
    if (watcher_.cancelled()) cancel();
  }
  void advance(double fraction) override {
    watcher_.advance(fraction);
    if (watcher_.cancelled()) cancel();
  }

 private:
  builder::Progress& watcher_;
};

py::object batch(const std::filesystem::path& scene, const std::filesystem::path& output, const py::object& budget,
                 const std::optional<std::filesystem::path>& cache, const std::optional<std::string>& quality,
                 std::optional<double> tolerance, bool speed, bool dry_run, int threads, const py::object& progress) {
  pipeline::BatchSettings settings;
  settings.scene = scene;
  settings.folder = output;
  settings.cache = cache.value_or(std::filesystem::path());
  settings.budget = budgetFrom(budget);
  if (quality && *quality != "quick" && *quality != "standard" && *quality != "best")
    throw py::value_error("quality must be quick, standard or best, not " + *quality + ".");
  settings.overrides.quality = quality;
  if (tolerance && !(*tolerance > 0 && *tolerance <= formats::kMaxSceneLength))
    throw py::value_error("tolerance must be above 0 and at most 10^6 mm.");
  settings.overrides.tolerance_mm = tolerance;
  settings.speed = speed;
  settings.dry_run = dry_run;
  settings.threads = threads;
  std::string report;
  runInterruptibly(progress, [&](builder::Progress& p) {
    ForwardedProgress forwarded(p);
    report = tool::jsonText(pipeline::toJson(pipeline::runBatch(settings, forwarded)), -1);
  });
  return py::module_::import("json").attr("loads")(report);
}

}  // namespace

void bindBatch(py::module_& module) {
  module.def("batch", &batch, py::arg("scene"), py::arg("output"), py::kw_only(), py::arg("budget") = py::none(),
             py::arg("cache") = py::none(), py::arg("quality") = py::none(), py::arg("tolerance") = py::none(), py::arg("speed") = false,
             py::arg("dry_run") = false, py::arg("threads") = 0, py::arg("progress") = py::none(),
             R"(Builds the trees of every object of a scene; unchanged trees are taken from a cache.

scene: path of a *.scene.json. output: folder for NAME.stree, scene.json and report.json; created if it is missing.
budget: leaves of all trees together, or the time of a haptic step, such as "20us". cache: folder of finished trees.
quality, tolerance [mm]: replace the settings of the scene. speed: also measure speed against accuracy. dry_run: only list
the trees that would be built. threads, progress: as for build().
Returns report.json as a dict (docs/batch.md); an object that failed has "status" "failed" and "error".
Raises FileError, FormatError, UsageError, KeyboardInterrupt: finished trees are then in the cache.)");
}

}  // namespace spheretree::python
