// SPDX-License-Identifier: Apache-2.0
// make_samples FOLDER: writes the sample meshes molar.obj and probe.obj, in millimetres. make_samples --mouth FOLDER:
// the sample mouth. --robots FOLDER: two sample robots. --cavity FOLDER: a tooth to be drilled. The same meshes on
// every machine, byte for byte.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <span>
#include <string>

#include "cavity.h"
#include "molar.h"
#include "mouth.h"
#include "mouth_files.h"
#include "probe.h"
#include "program_end.h"
#include "robots.h"
#include "run_files.h"
#include "spheretree/formats/file_io.h"

namespace {

namespace samples = spheretree::samples;

/// Replaces nothing that was edited, or that came from elsewhere. All files appear together, by commit().
class Samples : public spheretree::formats::WholeFiles {
 public:
  template <class Content>
  void write(const std::filesystem::path& file, const Content& content) {
    const std::span<const std::byte> bytes = std::as_bytes(std::span(content));
    spheretree::tool::RunFiles().willMake(file, bytes);
    add(file, bytes);
  }
};

std::string objText(const spheretree::TriangleMesh& mesh, const std::string& title) {
  std::string text = samples::objText({{"", &mesh}}, title);
  return text.erase(text.find("g \n"), 3);
}

void writeMouth(const std::filesystem::path& folder, Samples& out) {
  const samples::Mouth mouth = samples::makeMouth();
  out.write(folder / "probe.obj", objText(samples::makeProbe(), "Dental probe, tip at the origin"));
  out.write(folder / "mouth.obj", samples::objText(mouth.parts(), "Open mouth"));
  out.write(folder / "mouth.glb", samples::glbBytes(mouth.parts()));
  out.write(folder / "mouth.scene.json", samples::mouthSceneText(mouth));
  out.write(folder / "opening.scene.json", samples::mouthSceneText(mouth, samples::MouthMotion::Opening));
  out.write(folder / "two_hands.scene.json", samples::mouthSceneText(mouth, samples::MouthMotion::TwoHands));
  out.write(folder / "soft.scene.json", samples::mouthSceneText(mouth, samples::MouthMotion::Soft));
  out.write(folder / "press.csv", samples::trajectoryText(samples::pressTongue()));
  out.write(folder / "pocket.csv", samples::trajectoryText(samples::probePocket(mouth)));
  samples::Path inspection = samples::inspectTeeth(mouth);
  out.write(folder / "inspection.csv", samples::trajectoryText(inspection));
  std::reverse(inspection.begin(), inspection.end());
  out.write(folder / "second_hand.csv", samples::trajectoryText(inspection));
}

void writeCavity(const std::filesystem::path& folder, Samples& out) {
  const samples::CariousMolar molar = samples::makeCariousMolar();
  out.write(folder / "tooth.obj", objText(molar.tooth, "Lower first molar"));
  out.write(folder / "dentine.obj", objText(molar.dentine, "Its dentine"));
  out.write(folder / "lesion.obj", objText(molar.lesion, "Its caries"));
  out.write(folder / "pulp.obj", objText(molar.pulp, "Its pulp"));
  out.write(folder / "handpiece.obj", objText(samples::makeHandpiece(), "Handpiece, the burr at the origin"));
  out.write(folder / "cavity.scene.json", samples::cavitySceneText());
  out.write(folder / "drill.csv", samples::drillText(samples::prepareCavity()));
}

void writeRobot(const std::filesystem::path& folder, const samples::RobotFiles& files, Samples& out) {
  spheretree::formats::makeFolder(folder / "meshes");
  for (const auto& [name, bytes] : files) out.write(folder / name, bytes);
}

}  // namespace

int main(int argc, char** argv) try {
  const bool force = argc > 1 && std::string(argv[1]) == "--force";
  argc -= force, argv += force;
  const std::string first = argc > 1 ? argv[1] : "", folder_name = argv[argc - 1];
  const bool help = first == "--help" || first == "-h", mouth = argc == 3 && first == "--mouth";
  const bool robots = argc == 3 && first == "--robots", cavity = argc == 3 && first == "--cavity";
  if (help || (argc != 2 && !mouth && !robots && !cavity) || folder_name.empty() || folder_name[0] == '-') {
    std::fputs(
        "Usage: make_samples FOLDER\nWrites molar.obj and probe.obj, sample meshes in millimetres, into FOLDER.\n"
        "       make_samples --mouth FOLDER\nWrites an open mouth: mouth.obj, mouth.glb, probe.obj, mouth.scene.json, "
        "opening.scene.json (the jaw moves), two_hands.scene.json (a second probe moves along second_hand.csv), soft.scene.json (soft "
        "tongue, gums and cheeks), and paths of the probe: pocket.csv, inspection.csv, press.csv.\n"
        "       make_samples --robots FOLDER\nWrites two robots: sample_arm7/sample_arm7.urdf and sample_arm6/sample_arm6.urdf, with "
        "meshes.\n       make_samples --cavity FOLDER\nWrites a carious molar as nested meshes (tooth.obj, dentine.obj, lesion.obj, "
        "pulp.obj), handpiece.obj, cavity.scene.json and drill.csv, a path that prepares a class I cavity.\nWith --force as the first "
        "word, files that were edited or came from elsewhere are replaced.\n",
        help ? stdout : stderr);
    return help ? 0 : 2;
  }
  const spheretree::builder::Progress progress;
  const spheretree::tool::RunFiles files(progress, "make_samples", force);
  const std::filesystem::path folder(folder_name);
  Samples out;
  spheretree::formats::makeFolder(folder);
  if (mouth) {
    writeMouth(folder, out);
    out.commit();
    return 0;
  }
  if (cavity) {
    writeCavity(folder, out);
    out.commit();
    return 0;
  }
  if (robots) {
    writeRobot(folder / "sample_arm7", samples::sampleArm7(), out);
    writeRobot(folder / "sample_arm6", samples::sampleArm6(), out);
    out.commit();
    return 0;
  }
  out.write(folder / "molar.obj", objText(samples::makeMolar(), "Lower first molar"));
  out.write(folder / "probe.obj", objText(samples::makeProbe(), "Dental probe, tip at the origin"));
  out.commit();
  return 0;
} catch (const spheretree::tool::UsageError& error) {
  return spheretree::tool::explain("make_samples", spheretree::tool::kExitUsage, error.what());
} catch (const std::exception& error) {
  std::fprintf(stderr, "make_samples: %s\n", error.what());
  return 3;
}
