// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>

#include "bindings.h"
#include "core/arrays.h"
#include "interruptible.h"
#include "mesh_argument.h"
#include "spheretree/builder/mesh_checks.h"
#include "spheretree/builder/repair_mesh.h"

namespace spheretree::python {
namespace {

using builder::Component;
using builder::Defect;
using builder::MeshReport;
using builder::Place;
using builder::RepairedMesh;
using builder::RepairStep;

MeshReport check(const py::object& mesh, const py::object& triangles, std::size_t places) {
  const auto given = meshArgument(mesh, triangles);
  MeshReport report;
  runInterruptibly(py::none(), [&](builder::Progress& p) { report = builder::checkMesh(given->mesh, places, p); });
  return report;
}

RepairedMesh repair(const py::object& mesh, const py::object& triangles, const std::string& kind, const py::object& progress) {
  const auto given = meshArgument(mesh, triangles);
  const builder::RepairKind chosen = repairArgument(kind);
  RepairedMesh repaired;
  runInterruptibly(progress, [&](builder::Progress& p) { repaired = builder::repairMesh(given->mesh, chosen, p); });
  return repaired;
}

void bindReport(py::module_& module) {
  py::class_<Place>(module, "Place", "A place on a mesh.")
      .def_readonly("triangles", &Place::triangles, "One triangle, or the two of a pair; rows of Mesh.triangles.")
      .def_readonly("vertices", &Place::vertices, "One vertex, or the two of an edge; may be empty.")
      .def_property_readonly(
          "point", [](const Place& place) { return arrayOf(place.point); }, "Shape (3,) [mm].");
  py::class_<Defect>(module, "Defect", "One kind of fault of a mesh.")
      .def_property_readonly(
          "kind", [](const Defect& defect) { return std::string(builder::name(defect.kind)); }, "Such as 'non-manifold edge'.")
      .def_readonly("count", &Defect::count, "Number of triangles, edges, vertices, components or pairs.")
      .def_readonly("is_lower_bound", &Defect::is_lower_bound, "True if there may be more, because the search was stopped.")
      .def_readonly("first", &Defect::first, "The first places, in the order of the mesh.")
      .def("__repr__", [](const Defect& d) {
        return "<spheretree.Defect: " + std::to_string(d.count) + " x " + std::string(builder::name(d.kind)) + ">";
      });
  py::class_<Component>(module, "Component", "Triangles that are connected by edges.")
      .def_readonly("triangles", &Component::triangles, "How many.")
      .def_readonly("volume", &Component::volume, "Signed, as wound; 0 if it is not closed [mm^3].")
      .def_readonly("inside_out", &Component::inside_out, "True if a repair reverses its winding.")
      .def_readonly("buried", &Component::buried, "True if it lies wholly within solid matter.")
      .def_readonly("cavity", &Component::cavity, "True if it is wound inward within solid matter, and so bounds a cavity.");
  py::class_<MeshReport>(module, "MeshReport", "The defects of a mesh and their places. True if there are none.")
      .def_readonly("triangles", &MeshReport::triangles, "How many.")
      .def_readonly("vertices", &MeshReport::vertices, "How many.")
      .def_readonly("volume", &MeshReport::volume, "Volume of a closed mesh [mm^3].")
      .def_readonly("area", &MeshReport::area, "[mm^2].")
      .def_property_readonly(
          "low", [](const MeshReport& r) { return arrayOf(r.low); }, "Shape (3,): corner of the bounding box [mm].")
      .def_property_readonly(
          "high", [](const MeshReport& r) { return arrayOf(r.high); }, "Shape (3,): the opposite corner [mm].")
      .def_readonly("defects", &MeshReport::defects, "Empty for a mesh that a build uses unchanged.")
      .def_readonly("components", &MeshReport::components, "Ordered by first triangle.")
      .def_property_readonly("clean", &MeshReport::clean, "No defects.")
      .def(
          "summary", [](const MeshReport& r) { return r.clean() ? std::string("no defects: a build takes this mesh.\n") : r.summary(); },
          "One line for each defect: kind, count, first place, advice; a line that says so if there are none.")
      .def("__bool__", &MeshReport::clean)
      .def("__repr__", [](const MeshReport& r) {
        return "<spheretree.MeshReport: " + (r.clean() ? std::string("clean") : std::to_string(r.defects.size()) + " kinds of defects") +
               ">";
      });
}

void bindRepaired(py::module_& module) {
  py::class_<RepairStep>(module, "RepairStep", "One step of a repair.")
      .def_property_readonly(
          "kind", [](const RepairStep& s) { return std::string(builder::name(s.kind)); }, "Such as 'stitch cracks'.")
      .def_readonly("text", &RepairStep::text, "The change, as a sentence.")
      .def_readonly("count", &RepairStep::count, "Number of elements that the step changed.")
      .def_readonly("change_mm", &RepairStep::change_mm,
                    "Largest distance from the surface of anything that it moved, added or removed [mm].");
  py::class_<RepairedMesh>(module, "RepairedMesh", "A mesh after a repair.")
      .def_property_readonly(
          "mesh",
          [](const RepairedMesh& r) {
            return std::make_shared<PythonMesh>(PythonMesh{r.mesh, 1, "mesh", {}});
          },
          "A copy of the mesh.")
      .def_property_readonly("is_sound", &RepairedMesh::isSound, "True if a build accepts it.")
      .def_readonly("bound_mm", &RepairedMesh::bound_mm, "Largest distance of the surface from the input, except in filled holes [mm].")
      .def_readonly("steps", &RepairedMesh::steps, "The steps of the repair; empty for a sound mesh.")
      .def_readonly("result", &RepairedMesh::result, "The check of the repaired mesh.");
}

}  // namespace

void bindCheck(py::module_& module) {
  bindReport(module);
  bindRepaired(module);
  module.def("check", &check, py::arg("mesh"), py::arg("triangles") = py::none(), py::kw_only(), py::arg("places") = builder::kPlacesListed,
             R"(Finds the defects of a mesh and their places.

mesh: a Mesh, or vertices (n, 3) [mm] with triangles (m, 3). places: number of places to list for each defect.
Cost: about 0.5 s for 100,000 triangles.)");
  module.def("repair", &repair, py::arg("mesh"), py::arg("triangles") = py::none(), py::kw_only(), py::arg("repair") = "auto",
             py::arg("progress") = py::none(),
             R"(The mesh that a build would use: closed, wound outward, without crossings.

repair: "auto": the smallest change that makes it sound; "off": none; "wrap": a closed surface around it. progress: as for build().
Never raises for a defect: look at `is_sound` of the result. Raises KeyboardInterrupt.)");
}

}  // namespace spheretree::python
