// SPDX-License-Identifier: GPL-3.0-or-later
#include "run/sample_scene.h"

#include "molar.h"
#include "probe.h"
#include "spheretree/builder/build_sphere_tree.h"

namespace spheretree::player {

runtime::SceneDescription sampleScene(builder::Progress& progress) {
  builder::BuildSettings settings;
  settings.quality = builder::Quality::Quick;
  runtime::SceneDescription d;
  d.tool = builder::buildSphereTree(samples::makeProbe(), settings, progress).tree;
  d.reference_point = {0, 0, 20};
  d.objects.push_back({builder::buildSphereTree(samples::makeMolar(), settings, progress).tree, {}});
  return d;
}

}  // namespace spheretree::player
