// SPDX-License-Identifier: Apache-2.0
// Feeds any text to the reader of scenes: it is refused with a message that names the file, or gives a scene that is
// equal after writing and reading.
#include "fuzz/fuzz_target.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/scene_file.h"

namespace spheretree::fuzz {

std::vector<std::string> seeds() {
  return {R"({"schema": "spheretree.scene/1", "unit": "mm", "defaults": {"builder": "cover", "levels": 4, "tolerance_mm": 0.1},
 "coupling": {"translation_n_per_mm": 1.0, "rotation_n_mm_per_rad": 1000.0},
 "limits": {"force_n": 8.0, "torque_n_mm": [188, 188, 48]},
 "tool": {"name": "probe", "mesh": "probe.obj", "reference_point_mm": [0, 0, 0], "tolerance_mm": 0.05},
 "objects": [{"name": "tooth_11", "mesh": "mouth.obj", "part": "tooth_11",
              "position_mm": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0], "tolerance_mm": 0.1}]})",
          R"({"schema":"spheretree.scene/1","tool":{"name":"a","tree":"a.stree"},"objects":[{"name":"b","tree":"b.stree"}]})"};
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace spheretree;
  try {
    const formats::SceneFile scene = formats::parseScene({reinterpret_cast<const char*>(data), size}, "fuzz");
    const std::string text = formats::sceneText(scene);
    fuzz::require(formats::sceneText(formats::parseScene(text, "again")) == text, "a scene that was written is read as it was");
  } catch (const formats::FormatError& error) {
    fuzz::require(std::string(error.what()).find("fuzz") == 0, "a refusal names the file");
  }
  return 0;
}
