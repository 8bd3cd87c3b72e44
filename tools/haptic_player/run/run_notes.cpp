// SPDX-License-Identifier: GPL-3.0-or-later
#include "run/run_notes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

#include "spheretree/formats/scene_file.h"
#include "spheretree/formats/sphere_tree_file.h"
#include "spheretree/formats/trajectory.h"

namespace spheretree::player {
namespace {

std::string inSeconds(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g s", seconds);
  return text;
}

/// Distance from the reference point of the tool to its nearest leaf [mm]; 0 if it is inside one.
double referenceDistance(const formats::SceneFile& scene, const std::filesystem::path& path) {
  const SphereTree tree = formats::readSphereTree(formats::scenePath(path, scene.tool.tree));
  const Eigen::Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  double nearest = std::numeric_limits<double>::infinity();
  for (std::uint32_t i = 0; i < tree.nodeCount(); ++i) {
    if (!tree.isLeaf(i)) continue;
    const Sphere& s = tree.cover[i];
    const Eigen::Vector3d centre = origin + centreOf(s);
    nearest = std::min(nearest, (centre - scene.tool.reference_point_mm).norm() - static_cast<double>(s.radius));
  }
  return std::max(0.0, nearest);
}

}  // namespace

std::vector<std::string> notesOn(const PlaySettings& settings, bool is_steered, std::uint64_t steps, double largest_force_n,
                                 bool renders_torque) {
  std::vector<std::string> notes;
  if (!renders_torque) notes.push_back("The device has motors for forces only: torques were not felt. A recording and a window show them.");
  std::optional<formats::SceneFile> scene;
  if (!settings.scene.empty()) scene = formats::readScene(settings.scene);
  if (scene && scene->tool.burr.empty() && std::any_of(scene->objects.begin(), scene->objects.end(), [](const auto& o) { return o.cut; }))
    notes.push_back("Nothing was cut: the tool of the scene has no burr.");
  const double seconds = static_cast<double>(steps) / settings.rate;
  const bool is_tour = settings.device == DeviceKind::Simulated && settings.trajectory.empty() && !is_steered;
  if (is_tour) {
    const std::size_t objects = scene ? scene->objects.size() : 1;
    const auto visited = static_cast<std::size_t>(std::ceil(seconds / kTourStopSeconds));
    if (visited < objects)
      notes.push_back("The hand visited " + std::to_string(visited) + " of " + std::to_string(objects) + " objects; --seconds " +
                      std::to_string(static_cast<long>(static_cast<double>(objects) * kTourStopSeconds)) + " visits all.");
  }
  if (!is_tour && settings.device == DeviceKind::Replay && settings.seconds && seconds + 5e-4 < *settings.seconds)
    notes.push_back("The trajectory ended after " + inSeconds(seconds) + " of the " + inSeconds(*settings.seconds) + " asked for.");
  const double gap = settings.trajectory.empty() ? 0 : formats::readTrajectory(settings.trajectory).longest_gap;
  if (gap > 1.001e-3)
    notes.push_back("The rows of the trajectory are up to " + inSeconds(gap) + " apart; the poses between them are interpolated.");
  if (largest_force_n == 0 && steps > 0) {
    std::string note = "The tool touched nothing.";
    const double distance = scene ? referenceDistance(*scene, settings.scene) : 0;
    char text[160];
    std::snprintf(text, sizeof text, " Its reference point is %.4g mm away from its nearest sphere: set reference_point_mm in the scene.",
                  distance);
    if (distance > 0) note += text;
    notes.push_back(note);
  }
  return notes;
}

}  // namespace spheretree::player
