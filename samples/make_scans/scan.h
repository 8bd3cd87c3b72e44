// SPDX-License-Identifier: GPL-3.0-or-later
// The sample mouth as seen by an intraoral scanner: one open surface for each jaw, gum and crowns joined, with a label
// for each vertex. The true crowns and margins are known. Units: mm.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mouth.h"

namespace spheretree::samples {

struct ScanSettings {
  bool upper = true;
  double edge_mm = 0.4;        // of the triangles, approximately
  double noise_mm = 0;         // standard deviation along the normal
  std::uint64_t seed = 1;      // of noise and holes
  int holes = 0;               // round holes of 1.5 mm at random places
  bool double_layer = false;   // a patch of the gum exists twice, 0.05 mm apart and connected along one side
  bool hidden_removed = true;  // removes faces that no view within 60 degrees of vertical sees
  int missing_fdi = 0;         // this tooth is missing
  bool supernumerary = false;  // a small tooth beside the second premolar on the left, labelled as that one
  double crowding_mm = 0;      // displacement of neighbouring teeth, alternately to the cheek and the tongue
  bool braces = false;         // brackets of 0.8 mm on the cheek side, label 91
  bool jagged = false;         // vertices at the margin have random labels
};

struct SampleScan {
  TriangleMesh mesh;
  std::vector<std::int32_t> labels;                   // FDI number of each vertex; 0: gum
  std::vector<MouthTooth> teeth;                      // the true teeth in the scan; label: the last two digits of the name
  std::vector<std::vector<Eigen::Vector3d>> margins;  // of each tooth: the closed line where it leaves the gum, without noise
};

SampleScan makeScan(const Mouth& mouth, const ScanSettings& settings);

/// The labels in the form of the public set Teeth3DS+.
std::string labelsText(const SampleScan& scan, const std::string& patient, bool upper);

}  // namespace spheretree::samples
