// SPDX-License-Identifier: Apache-2.0
// The sample mouth as files: meshes, a scene for `spheretree batch`, and paths of a probe.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mouth.h"

namespace spheretree::samples {

/// One group for each part.
std::string objText(const std::vector<Mouth::Part>& parts, const std::string& title);

/// A node for each part, positions in metres, as glTF requires.
std::string glbBytes(const std::vector<Mouth::Part>& parts);

/// The parts of the mouth that move in a scene, apart from the tool.
enum class MouthMotion {
  None,      // the lower jaw has its hinge and rests
  Opening,   // the jaw opens by 8 degrees and closes again, repeatedly
  TwoHands,  // a second probe follows second_hand.csv; the jaw rests
  Soft,      // only soft tissue: tongue, gums, and the face with soft cheeks and lips
};

/// The probe as tool, with its tip as reference point, and each part of mouth.obj as an object. The lower teeth, their
/// jaw and the tongue belong to the body "mandible".
std::string mouthSceneText(const Mouth& mouth, MouthMotion motion = MouthMotion::None);

/// A pose for each millisecond.
using Path = std::vector<Configuration>;

/// The probe moves around the cheek side of the lower right first molar, into the sulcus and out again; it presses on
/// the floor by 0.3 mm.
Path probePocket(const Mouth& mouth);

/// The probe's tip slides over the chewing surfaces and biting edges of all teeth, pressed in by 0.4 mm: the lower
/// arch, then the upper.
Path inspectTeeth(const Mouth& mouth);

/// The tip presses the tongue in by 3 mm, rests, is drawn sideways over its edge, slips off onto tooth 46 and returns.
Path pressTongue();

/// In the form that spheretree/formats/trajectory.h reads.
std::string trajectoryText(const Path& path);

}  // namespace spheretree::samples
