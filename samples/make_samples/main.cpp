// SPDX-License-Identifier: Apache-2.0
// make_samples FOLDER: writes the sample meshes molar.obj and probe.obj, in millimetres. make_samples --mouth FOLDER:
// the sample mouth. make_samples --robots FOLDER: two sample robots. The same meshes on every machine, byte for byte.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "molar.h"
#include "mouth.h"
#include "mouth_files.h"
#include "probe.h"
#include "robots.h"
#include "spheretree/formats/file_io.h"

namespace {

namespace samples = spheretree::samples;
using spheretree::formats::writeWhole;

std::string objText(const spheretree::TriangleMesh& mesh, const std::string& title) {
  std::string text = samples::objText({{"", &mesh}}, title);
  return text.erase(text.find("g \n"), 3);
}

void writeMouth(const std::filesystem::path& folder) {
  const samples::Mouth mouth = samples::makeMouth();
  writeWhole(folder / "probe.obj", objText(samples::makeProbe(), "Dental probe, tip at the origin"));
  writeWhole(folder / "mouth.obj", samples::objText(mouth.parts(), "Open mouth"));
  writeWhole(folder / "mouth.glb", samples::glbBytes(mouth.parts()));
  writeWhole(folder / "mouth.scene.json", samples::mouthSceneText(mouth));
  writeWhole(folder / "opening.scene.json", samples::mouthSceneText(mouth, samples::MouthMotion::Opening));
  writeWhole(folder / "two_hands.scene.json", samples::mouthSceneText(mouth, samples::MouthMotion::TwoHands));
  writeWhole(folder / "soft.scene.json", samples::mouthSceneText(mouth, samples::MouthMotion::Soft));
  writeWhole(folder / "press.csv", samples::trajectoryText(samples::pressTongue()));
  writeWhole(folder / "pocket.csv", samples::trajectoryText(samples::probePocket(mouth)));
  samples::Path inspection = samples::inspectTeeth(mouth);
  writeWhole(folder / "inspection.csv", samples::trajectoryText(inspection));
  std::reverse(inspection.begin(), inspection.end());
  writeWhole(folder / "second_hand.csv", samples::trajectoryText(inspection));
}

void writeRobot(const std::filesystem::path& folder, const samples::RobotFiles& files) {
  spheretree::formats::makeFolder(folder / "meshes");
  for (const auto& [name, bytes] : files) writeWhole(folder / name, bytes);
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string first = argc > 1 ? argv[1] : "", folder_name = argv[argc - 1];
  const bool help = first == "--help" || first == "-h", mouth = argc == 3 && first == "--mouth";
  const bool robots = argc == 3 && first == "--robots";
  if (help || (argc != 2 && !mouth && !robots) || folder_name.empty() || folder_name[0] == '-') {
    std::fputs(
        "Usage: make_samples FOLDER\nWrites molar.obj and probe.obj, sample meshes in millimetres, into FOLDER.\n"
        "       make_samples --mouth FOLDER\nWrites an open mouth: mouth.obj, mouth.glb, probe.obj, mouth.scene.json, "
        "opening.scene.json (the jaw moves), two_hands.scene.json (a second probe moves along second_hand.csv), soft.scene.json (soft "
        "tongue, gums and cheeks), and paths of the probe: pocket.csv, inspection.csv, press.csv.\n"
        "       make_samples --robots FOLDER\nWrites two robots: sample_arm7/sample_arm7.urdf and sample_arm6/sample_arm6.urdf, with "
        "meshes.\n",
        help ? stdout : stderr);
    return help ? 0 : 2;
  }
  const std::filesystem::path folder(folder_name);
  spheretree::formats::makeFolder(folder);
  if (mouth) {
    writeMouth(folder);
    return 0;
  }
  if (robots) {
    writeRobot(folder / "sample_arm7", samples::sampleArm7());
    writeRobot(folder / "sample_arm6", samples::sampleArm6());
    return 0;
  }
  writeWhole(folder / "molar.obj", objText(samples::makeMolar(), "Lower first molar"));
  writeWhole(folder / "probe.obj", objText(samples::makeProbe(), "Dental probe, tip at the origin"));
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "make_samples: %s\n", error.what());
  return 3;
}
