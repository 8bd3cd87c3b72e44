// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/cut/grade.h"

#include <algorithm>

#include "cut/layer_materials.h"
#include "cut/remaining_mesh.h"
#include "generator.h"
#include "geometry/distance_field.h"

namespace spheretree::pipeline {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kShownTolerance = 0.05;  // of meshes to look at [mm]

Json boundsJson(const builder::VolumeBounds& bounds) { return {{"low", bounds.low}, {"high", bounds.high}}; }

Json distanceJson(const std::optional<builder::CutDistance>& distance) {
  if (!distance) return nullptr;
  return {{"low", distance->low}, {"high", distance->high ? Json(*distance->high) : Json(nullptr)}};
}

}  // namespace

builder::VolumeBounds GradedLayer::left() const {
  if (!(volume.low > 0)) return {0, 1};
  return {std::max(0.0, 1 - removed.high / volume.low), std::clamp(1 - removed.low / volume.high, 0.0, 1.0)};
}

builder::VolumeBounds GradedObject::outsideLesion() const {
  builder::VolumeBounds out;
  for (std::size_t k = 0; k < layers.size(); ++k)
    if (k != lesion) out.low += layers[k].removed.low, out.high += layers[k].removed.high;
  return out;
}

std::vector<GradedObject> gradeRun(const CutRun& run, double tolerance, const std::string& lesion, builder::Progress& progress) {
  std::vector<GradedObject> out;
  for (const CutRun::Object& object : run.objects) {
    std::vector<builder::DistanceField> fields;
    std::vector<TriangleMesh> meshes;
    for (const CutRun::Layer& layer : object.layers) {
      fields.emplace_back(layer.mesh);
      meshes.push_back(layer.mesh);
    }
    progress.stage("volumes of " + object.name);
    const builder::CutVolumes volumes = builder::removedVolumes(fields, object.paths, {.tolerance = tolerance}, progress);
    GradedObject& graded = out.emplace_back();
    graded.name = object.name;
    graded.removed = volumes.total;
    graded.is_met = volumes.is_met;
    std::vector<builder::LayerMaterial> materials = builder::layerMaterials(meshes, progress);
    for (std::size_t k = 0; k < fields.size(); ++k) {
      progress.check();
      GradedLayer& layer = graded.layers.emplace_back();
      layer.name = object.layers[k].name;
      layer.volume = materials[k].volume;
      graded.materials.push_back(std::move(materials[k].mesh));
      layer.removed = volumes.layers[k];
      if (k > 0) layer.distance = builder::distanceOfCut(fields[0], fields[k], object.paths);
      if (layer.name == lesion) graded.lesion = k;
    }
  }
  return out;
}

std::vector<TriangleMesh> leftOfLayers(const CutRun::Object& object, const GradedObject& graded, builder::Progress& progress) {
  std::vector<TriangleMesh> out;
  for (const TriangleMesh& material : graded.materials)
    out.push_back(material.triangles.empty() ? material : builder::remainingMesh(material, object.paths, kShownTolerance, progress).mesh);
  return out;
}

Json gradeJson(const CutRun& run, const std::vector<GradedObject>& objects, const std::string& recording) {
  Json out{{"schema", "spheretree.grade/1"},
           {"generator", tool::kGenerator},
           {"recording", recording},
           {"scene", run.scene.string()},
           {"steps", run.steps},
           {"spinning_steps", run.spinning},
           {"objects", Json::array()},
           {"notes", run.notes}};
  for (const GradedObject& object : objects) {
    Json layers = Json::array();
    for (const GradedLayer& layer : object.layers)
      layers.push_back({{"name", layer.name},
                        {"volume_mm3", boundsJson(layer.volume)},
                        {"removed_mm3", boundsJson(layer.removed)},
                        {"left_share", boundsJson(layer.left())},
                        {"distance_mm", distanceJson(layer.distance)}});
    Json entry{{"name", object.name}, {"removed_mm3", boundsJson(object.removed)}, {"tolerance_met", object.is_met}, {"layers", layers}};
    if (object.lesion)
      entry["lesion"] = {{"layer", object.layers[*object.lesion].name},
                         {"left_share", boundsJson(object.layers[*object.lesion].left())},
                         {"removed_outside_mm3", boundsJson(object.outsideLesion())}};
    out["objects"].push_back(std::move(entry));
  }
  return out;
}

}  // namespace spheretree::pipeline
