// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of a cut: what was removed of each layer, what is left, and how near the cut comes. Definitions:
// docs/grade.md. Units: mm, mm^3.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cut/cut_distance.h"
#include "cut/cut_volumes.h"
#include "pipeline/cut/cut_run.h"

namespace spheretree::pipeline {

struct GradedLayer {
  std::string name;
  builder::VolumeBounds volume, removed;         // before the cut; by it
  std::optional<builder::CutDistance> distance;  // of the cut to the mesh of the layer; empty for the first layer, and without a cut
  /// The share that is left, 0 .. 1.
  builder::VolumeBounds left() const;
};

struct GradedObject {
  std::string name;
  builder::VolumeBounds removed;
  bool is_met = true;  // the tolerance
  std::vector<GradedLayer> layers;
  std::vector<TriangleMesh> materials;          // of the layers, before the cut
  std::optional<std::size_t> lesion;            // the layer that was to be removed
  builder::VolumeBounds outsideLesion() const;  // removed of the other layers
};

/// `tolerance` [mm^3] of the sum of the widths of the removed volumes; 0: 0.5 % of what was removed. `lesion`: name of
/// the layer that was to be removed; an object may lack it. @throws builder::Cancelled
std::vector<GradedObject> gradeRun(const CutRun& run, double tolerance, const std::string& lesion, builder::Progress& progress);

/// What is left of the material of each layer, as closed meshes to look at, within 0.05 mm; without triangles where
/// nothing is left. @throws builder::BuildError, builder::Cancelled
std::vector<TriangleMesh> leftOfLayers(const CutRun::Object& object, const GradedObject& graded, builder::Progress& progress);

/// Schema spheretree.grade/1.
nlohmann::ordered_json gradeJson(const CutRun& run, const std::vector<GradedObject>& objects, const std::string& recording);

}  // namespace spheretree::pipeline
