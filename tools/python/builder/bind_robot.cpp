// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bindings.h"
#include "core/arrays.h"
#include "interruptible.h"
#include "pipeline/builder_names.h"
#include "pipeline/sound_mesh.h"
#include "program_end.h"
#include "robot/cover/ignored_pairs.h"
#include "robot/cover/robot_cover.h"
#include "robot/files/robot_files.h"
#include "robot/model/robot_shapes.h"
#include "run_files.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::python {
namespace {

namespace fs = std::filesystem;

/// The result of a run of `spheretree robot`.
struct PythonRobot {
  robot::Robot robot;
  robot::RobotCover cover;
  std::vector<robot::IgnoredPair> pairs;
  std::vector<std::string> notes;
};

/// The arrays keep the robot alive, and with it its links.
struct PythonLink {
  const PythonRobot* owner;
  std::size_t index;
  const robot::LinkCover& cover() const { return owner->cover.links[index]; }
  const std::string& name() const { return owner->robot.links[cover().link].name; }
};

const char* reasonName(robot::PairReason reason) {
  return reason == robot::PairReason::Adjacent ? "adjacent" : reason == robot::PairReason::Always ? "always" : "never";
}

std::unique_ptr<PythonRobot> coveredRobot(const fs::path& urdf, std::optional<double> tolerance, std::optional<std::size_t> budget,
                                          const std::map<std::string, std::size_t>& links, const std::vector<fs::path>& packages,
                                          bool visual, const std::map<std::string, std::string>& units, const std::string& quality,
                                          const std::string& repair, std::uint64_t seed, int threads, const py::object& progress) {
  if (tolerance && budget) throw tool::UsageError("tolerance and budget do not go together: give one of them.");
  if (tolerance && !(*tolerance > 0 && *tolerance <= 1e6)) throw tool::UsageError("tolerance must be above 0 and at most 10^6 mm.");
  if (budget && !(*budget >= 1 && *budget <= 100'000)) throw tool::UsageError("budget must be 1 to 100000 spheres.");
  if (quality != "quick" && quality != "standard" && quality != "best")
    throw py::value_error("quality must be quick, standard or best, not " + quality + ".");
  if (repair != "auto" && repair != "off" && repair != "wrap")
    throw py::value_error("repair must be auto, off or wrap, not " + repair + ".");
  robot::CoverSettings settings;
  for (const auto& [pattern, spheres] : links) {
    if (spheres < 1 || spheres > 4096) throw tool::UsageError("links: " + pattern + " must have 1 to 4096 spheres.");
    settings.counts.push_back({pattern, spheres});
  }
  std::vector<robot::LinkUnit> link_units;
  for (const auto& [pattern, unit] : units) {
    const std::optional<robot::LinkUnit> known = robot::linkUnit(pattern + "=" + unit);
    if (!known) throw py::value_error("units: " + pattern + " must have mm, cm, m or in, not " + unit + ".");
    link_units.push_back(*known);
  }
  std::vector<std::string> package_words;
  for (const fs::path& package : packages) package_words.push_back(package.string());
  settings.tolerance_mm = tolerance.value_or(0);
  settings.budget = budget.value_or(0);
  settings.quality = pipeline::byName(pipeline::kQualities, quality);
  settings.repair = pipeline::repairKind(repair);
  settings.seed = seed;
  settings.threads = threads;
  auto out = std::make_unique<PythonRobot>();
  runInterruptibly(progress, [&](builder::Progress& p) {
    p.stage("read");
    out->robot =
        robot::readUrdf(urdf, robot::packagePaths(package_words), visual ? robot::ShapeSource::Visual : robot::ShapeSource::Collision);
    std::vector<robot::ShapedElement> shapes = robot::readShapes(out->robot, link_units, p);
    if (!tolerance && !budget) settings.budget = robot::usualBudget(out->robot);
    out->cover = robot::coverRobot(out->robot, std::move(shapes), settings, p);
    out->pairs = robot::findIgnoredPairs(out->robot, out->cover, {}, p);
    out->notes = out->robot.notes;
    (void)robot::mjcf({out->robot, out->cover, out->pairs, {}, {}}, out->notes);
  });
  return out;
}

std::vector<std::string> write(const PythonRobot& self, const fs::path& folder, const std::optional<fs::path>& srdf,
                               const std::optional<fs::path>& merge, bool force) {
  const builder::Progress progress;
  const tool::RunFiles files(progress, "robot", force);
  robot::makeRobotFolders(folder, files);
  for (const fs::path& input : {self.robot.path, srdf.value_or(""), merge.value_or("")})
    if (!input.empty()) files.willRead(input);
  for (const fs::path& name : robot::robotFileNames(self.robot)) files.willMake(folder / name);
  std::vector<std::string> names;
  for (const fs::path& name : robot::writeRobotFiles({self.robot, self.cover, self.pairs, srdf.value_or(""), merge.value_or("")}, folder))
    names.push_back(name.string());
  return names;
}

void bindLink(py::module_& module) {
  py::class_<PythonLink>(module, "LinkSpheres", "The spheres of one link, in its frame.")
      .def_property_readonly("name", &PythonLink::name, "As the URDF has it.")
      .def_property_readonly(
          "centres",
          [](const py::object& self) {
            const auto& spheres = self.cast<const PythonLink&>().cover().spheres();
            return viewOf(&spheres.data()->x, {static_cast<py::ssize_t>(spheres.size()), 3}, {sizeof(Sphere), sizeof(float)}, self);
          },
          "Shape (n, 3), float32 [m]; a view.")
      .def_property_readonly(
          "radii",
          [](const py::object& self) {
            const auto& spheres = self.cast<const PythonLink&>().cover().spheres();
            return viewOf(&spheres.data()->radius, {static_cast<py::ssize_t>(spheres.size())}, {sizeof(Sphere)}, self);
          },
          "Shape (n,), float32 [m]; a view.")
      .def_property_readonly(
          "overhang_bound", [](const PythonLink& link) { return link.cover().overhangBound() / 1000; },
          "Proven upper bound on how far a sphere reaches out of its collision element [m].")
      .def_property_readonly(
          "notes", [](const PythonLink& link) { return link.cover().notes; }, "Repairs and missed tolerances, in sentences.");
}

}  // namespace

void bindRobot(py::module_& module) {
  bindLink(module);
  py::class_<PythonRobot>(module, "RobotSpheres", "Spheres that cover every collision shape of a robot, proven.")
      .def_property_readonly(
          "name", [](const PythonRobot& self) { return self.robot.name; }, "As the URDF has it.")
      .def_property_readonly(
          "links",
          [](const py::object& self) {
            const auto& owner = self.cast<const PythonRobot&>();
            py::dict links;
            for (std::size_t i = 0; i < owner.cover.links.size(); ++i) {
              const PythonLink link{&owner, i};
              py::object item = py::cast(link);
              py::detail::keep_alive_impl(item, self);
              links[py::str(link.name())] = item;
            }
            return links;
          },
          "LinkSpheres of every link with collision shapes, by name, in the order of the URDF.")
      .def_property_readonly(
          "notes", [](const PythonRobot& self) { return self.notes; },
          "What is unusual in the URDF, and what the files change, in sentences that name file, line and link.")
      .def("__repr__",
           [](const PythonRobot& self) {
             return "<spheretree.RobotSpheres: " + self.robot.name + ", " + std::to_string(self.cover.sphereCount()) + " spheres on " +
                    std::to_string(self.cover.links.size()) + " links>";
           })
      .def_property_readonly(
          "pairs",
          [](const PythonRobot& self) {
            py::list pairs;
            for (const robot::IgnoredPair& pair : self.pairs)
              pairs.append(py::make_tuple(self.robot.links[pair.a].name, self.robot.links[pair.b].name, reasonName(pair.reason)));
            return pairs;
          },
          "Pairs of links that need no check against each other: (link, link, \"adjacent\", \"always\" or \"never\"), proven.")
      .def("write", &write, py::arg("folder"), py::kw_only(), py::arg("srdf") = py::none(), py::arg("merge") = py::none(),
           py::arg("force") = false,
           R"(Writes the spheres in the formats of planners and simulators (docs/robots.md) into a folder, created if missing.

srdf: an SRDF whose groups, states and pairs are copied. merge: an XRDF or configuration of cuRobo whose other keys are copied.
force: replace files that were edited, or that neither this nor `spheretree robot` wrote; otherwise UsageError names them.
Returns the names of the files, relative to the folder. Raises FileError, FormatError, UsageError.)");
  module.def("robot", &coveredRobot, py::arg("urdf"), py::kw_only(), py::arg("tolerance") = py::none(), py::arg("budget") = py::none(),
             py::arg("links") = std::map<std::string, std::size_t>(), py::arg("packages") = std::vector<fs::path>(),
             py::arg("visual") = false, py::arg("units") = std::map<std::string, std::string>(), py::arg("quality") = "standard",
             py::arg("repair") = "auto", py::arg("seed") = 1, py::arg("threads") = 0, py::arg("progress") = py::none(),
             R"(Covers the collision shapes of a URDF with spheres; the same as `spheretree robot`.

urdf: path of a URDF with xacro expanded. tolerance [mm]: largest overhang, met with the fewest spheres; or budget: spheres
of all links together; by default 8 for each collision element. links: {"hand": 1, "arm*": 5}, numbers for single links.
packages: folders to search for package://, or "NAME=FOLDER". visual: take the shapes of <visual>. units: {"hand": "mm"},
the unit of the numbers in mesh files. quality: quick, standard or best. repair: auto, off or wrap.
seed, threads, progress: as for build(). Returns RobotSpheres.
Raises FileError, FormatError, UsageError, BuildError, KeyboardInterrupt.)");
}

}  // namespace spheretree::python
