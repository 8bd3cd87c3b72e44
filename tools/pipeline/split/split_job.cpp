// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/split/split_job.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <set>

#include "generator.h"
#include "json_text.h"
#include "pipeline/scene_draft.h"
#include "pipeline/split/tooth_numbers.h"
#include "program_end.h"
#include "run_files.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/core/mesh_edit.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/marked_glb.h"
#include "spheretree/formats/mesh_writer.h"

namespace spheretree::pipeline {
namespace {

namespace fs = std::filesystem;
using builder::SplitPart;
using Eigen::Vector3d;
using Json = nlohmann::ordered_json;
using tool::UsageError;

constexpr double kToothTolerance = 0.1, kGumTolerance = 0.3;  // tolerances in the scene [mm]
constexpr int kSceneLevels = 5;                               // of the trees in the scene: up to 4,096 leaves
constexpr double kMinMolar = 8, kMaxMolar = 14;               // range of the width of a first molar [mm]
constexpr double kMinArch = 40, kMaxArch = 80;                // range of the distance between the two teeth farthest apart [mm]
// Bonwill (1887): the middle between the condyles is 86.6 mm behind the incisors; Balkwill (1866): 25 degrees above the
// occlusal plane.
constexpr double kHingeDistance = 86.6, kHingeAngle = 25 * M_PI / 180;

struct Jaw {
  fs::path scan;
  std::string name;  // "upper" or "lower"
  builder::SplitScan split;
  std::vector<std::string> part_names;
  std::vector<std::string> notes;
};

Vector3d centreOf(const TriangleMesh& mesh) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& p : mesh.positions) sum += p;
  return sum / static_cast<double>(std::max<std::size_t>(1, mesh.positions.size()));
}

std::string millimetres(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f mm", value);
  return text;
}

void check(const SplitJobSettings& s) {
  if (s.scans.empty() || s.scans.size() > 2) throw UsageError("a mouth has one or two scans, not " + std::to_string(s.scans.size()) + ".");
  const int sources = !s.labels.empty() + !s.source.property.empty() + s.source.parts;
  if (sources != 1) throw UsageError("no labels are given. Add one of --labels, --label-property and --parts.");
  if (!s.labels.empty() && s.labels.size() != s.scans.size())
    throw UsageError("--labels needs one file for each scan: " + std::to_string(s.scans.size()) + ", not " +
                     std::to_string(s.labels.size()) + ".");
  if (s.split.up && !(s.split.up->norm() > 0)) throw UsageError("--up is 0,0,0, which is no direction. Give one such as 0,0,1.");
  if (s.split.up && s.scans.size() == 2)
    throw UsageError("--up is for one scan; two jaws look in opposite directions. Split them one by one.");
  if (s.opening_deg && s.scans.size() != 2) throw UsageError("--opening rotates the lower jaw relative to the upper one. Give both scans.");
  if (s.jaw != "auto" && s.scans.size() == 2) throw UsageError("--jaw is for one scan; with two scans the labels tell the jaws apart.");
}

void nameParts(Jaw& jaw, std::set<std::string>& taken) {
  for (const SplitPart& part : jaw.split.parts) {
    std::string name = part.label == builder::kGumLabel ? (jaw.name.empty() ? "gum" : "gum_" + jaw.name)
                                                        : (isFdi(part.label) ? "tooth_" : "label_") + std::to_string(part.label);
    if (part.piece > 1) name += "_" + std::to_string(part.piece);
    if (taken.count(name) > 0) name += "_" + jaw.name;
    taken.insert(name);
    if (part.piece == 2)
      jaw.notes.push_back("label " + std::to_string(part.label) +
                          " is in several pieces, and each becomes a part: a supernumerary tooth, or a mistake in the labels.");
    jaw.part_names.push_back(std::move(name));
  }
}

/// Notes on unusual sizes of a mouth. The ranges apply to patients of any age, except for deciduous teeth.
void checkSizes(Jaw& jaw) {
  std::vector<Vector3d> centres;
  for (const SplitPart& part : jaw.split.parts) {
    if (part.label == builder::kGumLabel) continue;
    const Vector3d centre = centreOf(part.mesh);
    centres.push_back(centre);
    if (part.label % 10 != 6 || !isFdi(part.label) || part.label > 48 || part.piece > 1) continue;
    double reach = 0;
    for (const Vector3d& p : part.mesh.positions) {
      const Vector3d arm = p - centre;
      reach = std::max(reach, (arm - arm.dot(jaw.split.up) * jaw.split.up).norm());
    }
    if (2 * reach < kMinMolar || 2 * reach > kMaxMolar * 1.3)  // diagonal
      jaw.notes.push_back("the first molar " + std::to_string(part.label) + " is " + millimetres(2 * reach) + " wide, not " +
                          millimetres(kMinMolar) + " to " + millimetres(kMaxMolar) + ". Is the unit right? See --unit.");
  }
  double width = 0;
  for (const Vector3d& a : centres)
    for (const Vector3d& b : centres) width = std::max(width, (a - b).norm());
  if (centres.size() >= 10 && (width < kMinArch || width > kMaxArch))
    jaw.notes.push_back("the arch is " + millimetres(width) + " wide, not " + millimetres(kMinArch) + " to " + millimetres(kMaxArch) +
                        ". Is the unit right? See --unit.");
}

/// Reads both scans and tells the jaws apart, before any work.
std::vector<ScanInput> readScans(const SplitJobSettings& settings, builder::Progress& progress) {
  progress.stage("read");
  std::vector<ScanInput> inputs;
  for (std::size_t i = 0; i < settings.scans.size(); ++i) {
    progress.check();
    LabelSource source = settings.source;
    if (!settings.labels.empty()) source.file = settings.labels[i];
    inputs.push_back(readScan(settings.scans[i], settings.unit, source, settings.jaw));
    ScanInput& input = inputs.back();
    if (!settings.frame.empty() && !input.space.empty() && input.space != settings.frame)
      for (Vector3d& p : input.mesh.positions) p = {0.0 - p.x(), 0.0 - p.y(), p.z()};  // LPS and RAS differ in two axes
  }
  for (ScanInput& input : inputs)
    if (input.jaw.empty()) {
      if (inputs.size() == 2)
        throw UsageError("jaw unknown: nothing tells which scan is the upper jaw. Split them one by one, with --jaw.");
      input.notes.push_back("jaw unknown: neither the labels nor their file tell it. Add --jaw upper or --jaw lower.");
    }
  if (inputs.size() == 2 && inputs[0].jaw == inputs[1].jaw)
    throw formats::FormatError(settings.scans[1].string() + ": both scans are of the " + inputs[0].jaw +
                               " jaw according to their labels. Give one of each.");
  if (settings.frame.empty() && inputs.size() == 2 && !inputs[0].space.empty() && !inputs[1].space.empty() &&
      inputs[0].space != inputs[1].space)
    inputs[1].notes.push_back("this scan states SPACE=" + inputs[1].space + " and the other one " + inputs[0].space +
                              ": their x and y axes point opposite ways. Turn it: --frame " + inputs[0].space + ".");
  return inputs;
}

Jaw splitJaw(const SplitJobSettings& settings, std::size_t index, ScanInput input, builder::Progress& progress) {
  Jaw jaw;
  jaw.scan = settings.scans[index];
  jaw.name = input.jaw;
  jaw.notes = std::move(input.notes);
  jaw.split = builder::splitScan(input.mesh, input.labels, settings.split, progress);
  for (const std::string& note : jaw.split.notes) jaw.notes.push_back(note);
  checkSizes(jaw);
  return jaw;
}

std::string stateOf(const SplitPart& part) {
  if (!part.is_sound) return "refused";
  return part.crossing_pairs > 0 ? "crosses" : "ok";
}

std::string placeText(const Vector3d& p) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.2f, %.2f, %.2f)", p.x(), p.y(), p.z());
  return text;
}

Json toJson(const SplitPart& part, const std::string& name) {
  return {{"name", name},
          {"file", part.is_sound ? Json(name + ".ply") : Json(nullptr)},
          {"fdi", isFdi(part.label) ? Json(part.label) : Json(nullptr)},
          {"label", part.label},
          {"piece", part.piece},
          {"triangles", part.mesh.triangles.size()},
          {"scanned_area_mm2", part.scanned_area},
          {"invented_area_mm2", part.invented_area},
          {"rim_length_mm", part.rim_length},
          {"volume_mm3", part.volume},
          {"sound", part.is_sound},
          {"crossing_pairs", part.crossing_pairs},
          {"state", stateOf(part)},
          {"notes", part.notes}};
}

Json toJson(const Jaw& jaw) {
  Json parts = Json::array();
  for (std::size_t i = 0; i < jaw.part_names.size(); ++i) parts.push_back(toJson(jaw.split.parts[i], jaw.part_names[i]));
  const Vector3d& up = jaw.split.up;
  return {{"jaw", jaw.name.empty() ? Json(nullptr) : Json(jaw.name)},
          {"scan", jaw.scan.string()},
          {"up", {up.x(), up.y(), up.z()}},
          {"scan_area_mm2", jaw.split.scan_area},
          {"lost_area_mm2", jaw.split.lost_area},
          {"moved_vertices", jaw.split.moved.count},
          {"largest_move_mm", jaw.split.moved.farthest},
          {"filled_holes", jaw.split.holes},
          {"crossing_pairs", jaw.split.crossing_pairs},
          {"notes", jaw.notes},
          {"parts", std::move(parts)}};
}

Json inputsOf(const SplitJobSettings& settings) {
  Json inputs = Json::array();
  for (std::size_t i = 0; i < settings.scans.size(); ++i) {
    Json input{{"scan", settings.scans[i].string()}, {"hash", toHex(builder::bytesHash(formats::readFile(settings.scans[i])))}};
    if (!settings.labels.empty()) {
      input["labels"] = settings.labels[i].string();
      input["labels_hash"] = toHex(builder::bytesHash(formats::readFile(settings.labels[i])));
    }
    inputs.push_back(std::move(input));
  }
  return inputs;
}

/// Rotates the lower jaw about the line between the condyles.
Configuration openedBy(double degrees, const Jaw& lower) {
  Vector3d front = Vector3d::Zero(), back = Vector3d::Zero();
  int fronts = 0, backs = 0;
  for (const SplitPart& part : lower.split.parts) {
    if (!isFdi(part.label)) continue;
    const int place = part.label % 10;
    if (place <= 2) front += centreOf(part.mesh), ++fronts;
    if (place >= 4) back += centreOf(part.mesh), ++backs;
  }
  if (fronts == 0 || backs == 0)
    throw UsageError("--opening needs incisors and molars with FDI numbers in the lower jaw, to find its hinge. Leave it out.");
  front /= fronts, back /= backs;
  const Vector3d up = lower.split.up;
  Vector3d forward = front - back;
  forward = (forward - forward.dot(up) * up).normalized();
  const Vector3d hinge = front + kHingeDistance * (std::sin(kHingeAngle) * up - std::cos(kHingeAngle) * forward);
  Configuration pose;
  pose.orientation = Quaternion(Eigen::AngleAxisd(degrees * M_PI / 180, up.cross(forward).normalized()));
  pose.position = hinge - pose.orientation * hinge;
  return pose;
}

std::vector<std::byte> markedGlb(const std::vector<Jaw>& jaws) {
  TriangleMesh all;
  formats::Marks invented{"invented", {0.9, 0.4, 0.1}, {}, {}}, repaired{"repaired", {0.3, 0.5, 0.9}, {}, {}};
  for (const Jaw& jaw : jaws)
    for (const SplitPart& part : jaw.split.parts) {
      const auto first = static_cast<std::uint32_t>(all.triangles.size());
      for (std::uint32_t t = 0; t < part.mesh.triangles.size(); ++t) {
        if (part.is_invented.empty())
          repaired.triangles.push_back(first + t);
        else if (part.is_invented[t])
          invented.triangles.push_back(first + t);
      }
      all = joined(std::move(all), part.mesh);
    }
  return formats::encodeMarkedGlb(all, std::vector{invented, repaired});
}

class Writing {
 public:
  Writing(const SplitJobSettings& settings, const std::vector<Jaw>& jaws) : settings_(settings), jaws_(jaws) {}

  SplitJobResult run(const tool::RunFiles& files) {
    const fs::path scene_path = settings_.folder / "mouth.scene.json", report_path = settings_.folder / "split.json";
    result_.report = {{"schema", "spheretree.split/1"}, {"generator", tool::kGenerator}, {"inputs", inputsOf(settings_)}};
    Json jaws = Json::array();
    for (const Jaw& jaw : jaws_) jaws.push_back(toJson(jaw));
    result_.report["jaws"] = std::move(jaws);
    SceneDraftSettings draft;
    draft.tolerance_mm = kToothTolerance;
    draft.matches = {{"gum*", kGumTolerance}};
    bool has_gum = false;
    for (const Jaw& jaw : jaws_)
      for (std::size_t i = 0; i < jaw.part_names.size(); ++i) {
        const fs::path path = settings_.folder / (jaw.part_names[i] + ".ply");
        files.willMake(path);
        note(jaw, i);
        if (!jaw.split.parts[i].is_sound) continue;
        draft.files.push_back(path);
        has_gum = has_gum || jaw.split.parts[i].label == builder::kGumLabel;
      }
    if (!has_gum) draft.matches.clear();
    for (const Jaw& jaw : jaws_)
      for (std::size_t i = 0; i < jaw.part_names.size(); ++i)
        if (jaw.split.parts[i].is_sound)
          formats::writeWhole(settings_.folder / (jaw.part_names[i] + ".ply"), formats::encodePly(jaw.split.parts[i].mesh));
    if (!draft.files.empty()) writeScene(draft, scene_path);
    if (!settings_.marked.empty()) formats::writeWhole(settings_.marked, markedGlb(jaws_));
    formats::writeWhole(report_path, tool::jsonText(result_.report, 1) + "\n");
    return std::move(result_);
  }

 private:
  void note(const Jaw& jaw, std::size_t i) {
    const SplitPart& part = jaw.split.parts[i];
    if (i == 0)
      for (const std::string& text : jaw.notes) result_.notes.push_back((jaw.name.empty() ? jaw.scan.string() : jaw.name) + ": " + text);
    if (part.crossing_pairs > 0 && part.is_sound) {
      ++result_.crossing;
      result_.notes.push_back("finding: " + jaw.part_names[i] + " crosses its neighbours in " + std::to_string(part.crossing_pairs) +
                              " pairs of triangles, one at " + placeText(part.crossing) +
                              " mm: they overlap there. Check the labels and holes of the scan at this point.");
    }
    if (part.is_sound) {
      ++(part.label == builder::kGumLabel ? result_.gums : result_.teeth);
      return;
    }
    ++result_.refused;
    result_.notes.push_back(jaw.part_names[i] + ": is not written, because it is open or crosses itself at " + placeText(part.fault) +
                            " mm. Check the scan at this point, or increase --smooth or --min-area.");
  }

  void writeScene(const SceneDraftSettings& draft, const fs::path& path) {
    MeshStore meshes;
    SceneDraft scene = draftScene(draft, path, meshes);
    scene.scene.defaults.levels = kSceneLevels;
    if (settings_.opening_deg)
      for (const Jaw& jaw : jaws_) {
        if (jaw.name != "lower") continue;
        const Configuration pose = openedBy(*settings_.opening_deg, jaw);
        for (formats::SceneItem& object : scene.scene.objects)
          if (std::find(jaw.part_names.begin(), jaw.part_names.end(), object.name) != jaw.part_names.end()) object.pose = pose;
      }
    if (!scene.ball.empty()) formats::writeWhole(scene.ball, scene.ball_mesh);
    formats::writeWhole(path, formats::sceneText(scene.scene));
  }

  const SplitJobSettings& settings_;
  const std::vector<Jaw>& jaws_;
  SplitJobResult result_;
};

}  // namespace

SplitJobResult runSplit(const SplitJobSettings& settings, builder::Progress& progress) {
  const tool::RunFiles files(progress);
  check(settings);
  for (const fs::path& scan : settings.scans) files.willRead(scan);
  for (const fs::path& labels : settings.labels) files.willRead(labels);
  std::vector<ScanInput> inputs = readScans(settings, progress);
  files.makeFolder(settings.folder);
  files.willWrite(settings.marked, {".glb"}, "the marked mesh", false);  // it may be in the folder
  for (const char* name : {"mouth.scene.json", "split.json"}) files.willMake(settings.folder / name);
  files.willMake(settings.folder / "ball.obj", defaultToolFile());  // no part has this name
  files.keepOthers(settings.folder, [](const std::string& name) {
    return name.ends_with(".ply") && (name.starts_with("tooth_") || name.starts_with("label_") || name.starts_with("gum"));
  });
  std::vector<Jaw> jaws;
  std::set<std::string> taken;
  for (std::size_t i = 0; i < settings.scans.size(); ++i) {
    jaws.push_back(splitJaw(settings, i, std::move(inputs[i]), progress));
    nameParts(jaws.back(), taken);
  }
  return Writing(settings, jaws).run(files);
}

}  // namespace spheretree::pipeline
