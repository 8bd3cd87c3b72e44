// SPDX-License-Identifier: GPL-3.0-or-later
// The sample mouth as an intraoral scanner sees it: one open surface for each jaw, gum and crowns joined, with a label
// for each vertex. What the crowns and their margins are in truth is known. Units: mm.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mouth.h"

namespace spheretree::samples {

struct ScanSettings {
  bool upper = true;
  double edge_mm = 0.4;        // of the triangles, about
  double noise_mm = 0;         // standard deviation along the normal
  std::uint64_t seed = 1;      // of noise and holes
  int holes = 0;               // round ones of 1.5 mm, anywhere
  bool double_layer = false;   // a patch of the gum is there twice, 0.05 mm apart and stitched along one side
  bool hidden_removed = true;  // faces that no view from within 60 degrees of above sees
  int missing_fdi = 0;         // this tooth is left out
  bool supernumerary = false;  // a small tooth beside the second premolar on the left, labelled as that one
  double crowding_mm = 0;      // neighbours stand by this much more to the cheek or the tongue, in turn
  bool braces = false;         // brackets of 0.8 mm on the cheek side, label 91
  bool jagged = false;         // the labels of vertices at the margin are chance
};

struct SampleScan {
  TriangleMesh mesh;
  std::vector<std::int32_t> labels;                   // FDI number of each vertex; 0: gum
  std::vector<MouthTooth> teeth;                      // that are in it, as they are in truth; label: the last two digits of the name
  std::vector<std::vector<Eigen::Vector3d>> margins;  // of each tooth: the closed line along which it leaves the gum, without noise
};

SampleScan makeScan(const Mouth& mouth, const ScanSettings& settings);

/// The labels in the form of the public set Teeth3DS+.
std::string labelsText(const SampleScan& scan, const std::string& patient, bool upper);

}  // namespace spheretree::samples
