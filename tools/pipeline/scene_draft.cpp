// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/scene_draft.h"

#include <fnmatch.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include "pipeline/ball_mesh.h"
#include "program_end.h"
#include "run_files.h"
#include "spheretree/builder/mesh_survey.h"
#include "spheretree/formats/mesh_writer.h"
#include "spheretree/formats/nearest_word.h"
#include "spheretree/formats/safe_name.h"

namespace spheretree::pipeline {
namespace {

namespace fs = std::filesystem;
using formats::SceneItem;
using tool::UsageError;

constexpr double kBallDiameter = 1;          // [mm] of the default tool: between the tips of an explorer and a small bur
constexpr double kUnreachedTolerance = 5;    // times the largest tolerance, for surfaces that the tool cannot reach
constexpr double kUnlikelySizeRatio = 1000;  // between files of one scene: their units are probably different
constexpr std::array kToolWords{"probe", "tool", "instrument", "explorer", "scaler", "handpiece", "bur", "burr", "drill", "stylus"};

/// An object without its final name.
struct Candidate {
  SceneItem item;
  std::string wanted;    // its name in the file; for a whole file the name of the file
  std::size_t file = 0;  // index of its file
};

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

std::string withSuffix(const std::string& name, const std::string& suffix) {
  return std::string(formats::cutName(name, formats::kMaxNameBytes - std::min(formats::kMaxNameBytes, suffix.size()))) + suffix;
}

/// If two files use a name, the name of the file is put in front; remaining duplicates get a number.
void nameAll(std::vector<Candidate>& candidates, const std::vector<fs::path>& files, std::vector<std::string>& notes) {
  std::map<std::string, std::set<std::size_t>> files_of;
  for (const Candidate& c : candidates) files_of[lower(formats::safeName(c.wanted))].insert(c.file);
  std::set<std::string> taken;
  std::size_t renamed = 0;
  std::string first;
  for (Candidate& c : candidates) {
    std::string name = formats::safeName(c.wanted);
    if (files_of[lower(name)].size() > 1 && !c.item.part.empty()) name = formats::safeName(files[c.file].stem().string() + "_" + c.wanted);
    const std::string base = name;
    for (int n = 2; !taken.insert(lower(name)).second; ++n) name = withSuffix(base, "_" + std::to_string(n));
    c.item.name = name;
    if (name == c.wanted) continue;
    ++renamed;
    if (first.empty()) first = c.wanted + " is called " + name;
  }
  if (renamed > 0)
    notes.push_back((renamed == 1 ? "1 name was" : std::to_string(renamed) + " names were") +
                    " made unique and safe as a file name; the first: " + first + ".");
}

Eigen::AlignedBox3d boxOf(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : mesh.positions) box.extend(p);
  return box;
}

/// The parts of one mesh file: the named ones, and the connected components of triangles without a name; or all
/// components.
class PartsOfFile {
 public:
  PartsOfFile(const MeshStore::File& file, const fs::path& path) : file_(file), mesh_(file.mesh.mesh), path_(path) {}

  std::vector<std::string> findComponents() const {
    const std::vector<std::uint32_t>& component_of = file_.components.of(mesh_);
    const std::uint32_t last = component_of.empty() ? 0 : *std::max_element(component_of.begin(), component_of.end());
    if (last == 0) return {""};
    std::vector<std::string> parts;
    for (std::uint32_t c = 0; c <= last; ++c) parts.push_back("#" + std::to_string(c));
    return parts;
  }

  std::vector<std::string> find(std::vector<std::string>& notes) {
    std::vector<std::size_t> count(mesh_.part_names.size(), 0);
    for (const std::uint32_t p : mesh_.part) ++count[p];
    std::vector<std::string> parts;
    bool has_unnamed = false;
    for (std::size_t p = 0; p < count.size(); ++p) {
      if (count[p] == 0) continue;
      if (mesh_.part_names[p].empty())
        has_unnamed = true;
      else
        parts.push_back(mesh_.part_names[p]);
    }
    if (parts.size() + has_unnamed <= 1) return {""};  // the whole file
    if (has_unnamed) addUnnamed(parts, notes);
    return parts;
  }

 private:
  void addUnnamed(std::vector<std::string>& parts, std::vector<std::string>& notes) const {
    const std::vector<std::uint32_t>& component_of = file_.components.of(mesh_);
    std::map<std::uint32_t, std::pair<std::size_t, std::size_t>> found;  // component: number of triangles without and with a name
    for (std::size_t t = 0; t < mesh_.part.size(); ++t) {
      auto& [unnamed, named] = found[component_of[t]];
      ++(mesh_.part_names[mesh_.part[t]].empty() ? unnamed : named);
    }
    std::size_t left_out = 0;
    for (const auto& [component, triangles] : found) {
      if (triangles.first == 0) continue;
      if (triangles.second == 0)
        parts.push_back("#" + std::to_string(component));
      else
        left_out += triangles.first;
    }
    if (left_out > 0)
      notes.push_back(path_.string() + ": " + std::to_string(left_out) +
                      " triangles without a name are connected to named parts and belong to no object." +
                      " Put them into a group of the file.");
  }

  const MeshStore::File& file_;
  const TriangleMesh& mesh_;
  const fs::path& path_;
};

class Drafting {
 public:
  Drafting(const SceneDraftSettings& settings, const fs::path& scene_path, MeshStore& meshes)
      : settings_(settings), files_(settings.files), scene_path_(scene_path), meshes_(meshes) {}

  SceneDraft run() {
    if (!settings_.unit.empty()) draft_.scene.unit = settings_.unit;
    draft_.scene.defaults.tolerance_mm = settings_.tolerance_mm;
    addToolFile();
    for (std::size_t f = 0; f < files_.size(); ++f) readFile(f);
    nameAll(candidates_, files_, draft_.notes);
    checkSizes();
    checkSpaces();
    takeTool();
    if (candidates_.empty()) throw UsageError("the files hold the tool and no object. Name a file with the objects that the tool touches.");
    if (candidates_.size() > formats::kMaxSceneObjects)
      throw UsageError("the files hold " + std::to_string(candidates_.size()) + " objects; a scene has at most " +
                       std::to_string(formats::kMaxSceneObjects) + ". Name fewer files, or give one scene for each group of them.");
    setTolerances();
    for (Candidate& c : candidates_) draft_.scene.objects.push_back(std::move(c.item));
    return std::move(draft_);
  }

 private:
  /// The path relative to the scene.
  fs::path fromScene(const fs::path& file) const { return fs::proximate(fs::absolute(file), fs::absolute(scene_path_).parent_path()); }

  /// --tool may name a file that is not among the inputs.
  void addToolFile() {
    std::error_code none;
    if (settings_.tool.empty() || !fs::is_regular_file(settings_.tool, none)) return;
    const auto same =
        std::find_if(files_.begin(), files_.end(), [&](const fs::path& f) { return fs::equivalent(f, settings_.tool, none); });
    tool_file_ = static_cast<std::size_t>(same - files_.begin());
    if (same == files_.end()) files_.push_back(settings_.tool);
  }

  void readFile(std::size_t f) {
    const fs::path& file = files_[f];
    Candidate whole;
    whole.wanted = file.stem().string();
    whole.file = f;
    if (tool::endingOf(file) == ".stree") {
      whole.item.tree = fromScene(file);
      candidates_.push_back(std::move(whole));
      return;
    }
    whole.item.mesh = fromScene(file);
    const std::string ending = tool::endingOf(file);
    if (ending == ".glb" || ending == ".gltf") whole.item.unit = settings_.unit.empty() ? "m" : settings_.unit;
    const std::shared_ptr<const MeshStore::File> read = meshes_.read(draft_.scene, scene_path_, whole.item);
    const TriangleMesh& mesh = read->mesh.mesh;
    file_boxes_.emplace_back(f, boxOf(mesh));
    file_units_.push_back(read->mesh.unit_mm);
    spaces_.push_back(read->mesh.space);
    if (!settings_.frame.empty() && !read->mesh.space.empty() && read->mesh.space != settings_.frame)
      whole.item.pose.orientation = Quaternion(0, 0, 0, 1);  // left and right, front and back are the other way round
    PartsOfFile of_file(*read, file);
    const std::vector<std::string> parts = tool_file_ == f        ? std::vector<std::string>{""}
                                           : settings_.components ? of_file.findComponents()
                                                                  : of_file.find(draft_.notes);
    for (const std::string& part : parts) {
      Candidate c = whole;
      c.item.part = part;
      if (!part.empty()) c.wanted = part[0] == '#' ? whole.wanted + "_" + part.substr(1) : part;
      candidates_.push_back(std::move(c));
    }
  }

  /// Notes on sizes: files in another unit than the user expects are the most frequent mistake.
  void checkSizes() {
    double min_diagonal = 0, max_diagonal = 0;
    std::size_t smallest = 0, largest = 0;
    for (std::size_t i = 0; i < file_boxes_.size(); ++i) {
      const auto& [f, box] = file_boxes_[i];
      const double diagonal = box.diagonal().norm();
      if (const std::string hint = builder::unitHint(diagonal, file_units_[i]); !hint.empty())
        draft_.notes.push_back(files_[f].string() + ": " + hint);
      if (min_diagonal == 0 || diagonal < min_diagonal) min_diagonal = diagonal, smallest = f;
      if (diagonal > max_diagonal) max_diagonal = diagonal, largest = f;
    }
    if (min_diagonal > 0 && max_diagonal > kUnlikelySizeRatio * min_diagonal) {
      const double ratio = max_diagonal / min_diagonal;
      draft_.notes.push_back(files_[largest].string() + " is " + std::to_string(static_cast<long long>(ratio)) + " times as large as " +
                             files_[smallest].string() + "; if their units differ, set \"unit\" of each object in the scene.");
    }
  }

  /// Notes on files whose axes point different ways: the same tooth then stands in two places.
  void checkSpaces() {
    const auto count = [&](const char* space) { return std::count(spaces_.begin(), spaces_.end(), space); };
    const auto lps = count("LPS"), ras = count("RAS");
    const auto files = [](long n) { return std::to_string(n) + (n == 1 ? " file" : " files"); };
    if (!settings_.frame.empty()) {
      const auto turned = settings_.frame == "LPS" ? ras : lps;
      draft_.notes.push_back(files(turned) + (turned == 1 ? " is" : " are") + " turned to " + settings_.frame + "; " +
                             files(std::count(spaces_.begin(), spaces_.end(), "")) + " did not state LPS or RAS.");
    } else if (lps > 0 && ras > 0) {
      draft_.notes.push_back(files(lps) + (lps == 1 ? " says" : " say") + " SPACE=LPS and " + files(ras) + (ras == 1 ? " says" : " say") +
                             " SPACE=RAS: their x and y axes point opposite ways. Turn them into one frame: --frame LPS, or --frame RAS.");
    }
  }

  std::size_t indexOfTool() const {
    std::vector<std::string_view> names;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const Candidate& c = candidates_[i];
      if (tool_file_ ? c.file == *tool_file_ : c.item.name == settings_.tool) return i;
      names.push_back(c.item.name);
    }
    std::size_t found = candidates_.size();
    for (std::size_t i = 0; i < candidates_.size(); ++i)
      if (candidates_[i].wanted == settings_.tool) {
        if (found < candidates_.size())
          throw UsageError("--tool: more than one file has a part " + settings_.tool + ". Give one of the names " +
                           candidates_[found].item.name + ", " + candidates_[i].item.name + ".");
        found = i;
      }
    if (found < candidates_.size()) return found;
    const auto nearest = formats::nearestWord(settings_.tool, names);
    throw UsageError("--tool: " + settings_.tool + " is neither a file nor one of the " + std::to_string(names.size()) + " objects" +
                     (nearest ? "; the nearest is " + std::string(*nearest) : "") + ".");
  }

  /// Objects whose names contain a word for a tool.
  std::vector<std::size_t> likelyTools() const {
    std::vector<std::size_t> likely;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      std::string word;
      bool is_tool = false;
      for (const char c : lower(candidates_[i].item.name) + " ") {
        if (c >= 'a' && c <= 'z') {
          word += c;
          continue;
        }
        is_tool = is_tool || std::find(kToolWords.begin(), kToolWords.end(), word) != kToolWords.end();
        word.clear();
      }
      if (is_tool) likely.push_back(i);
    }
    return likely;
  }

  void takeTool() {
    std::size_t index = 0;
    if (!settings_.tool.empty()) {
      index = indexOfTool();
    } else {
      const std::vector<std::size_t> likely = likelyTools();
      if (likely.size() > 1)
        throw UsageError(candidates_[likely[0]].item.name + " and " + candidates_[likely[1]].item.name +
                         " could both be the tool. Choose one with --tool NAME.");
      if (likely.empty() || candidates_.size() == 1) return supplyBall();
      index = likely[0];
    }
    Candidate& chosen = candidates_[index];
    chosen.item.reference_point = "tip";
    draft_.scene.tool = std::move(chosen.item);
    candidates_.erase(candidates_.begin() + static_cast<std::ptrdiff_t>(index));
  }

  void supplyBall() {
    std::set<std::string> taken;
    for (const Candidate& c : candidates_) taken.insert(lower(c.item.name));
    std::string name = "ball";
    for (int n = 2; taken.count(name) > 0; ++n) name = "ball_" + std::to_string(n);
    draft_.ball = scene_path_.parent_path() / (name + ".obj");
    const TriangleMesh mesh = ballMesh(kBallDiameter / 2);
    draft_.ball_mesh = defaultToolFile();
    draft_.scene.tool.name = name;
    draft_.scene.tool.mesh = name + ".obj";
    draft_.scene.tool.unit = "mm";
    draft_.scene.tool.reference_point = "centre";
    meshes_.hold(formats::scenePath(scene_path_, draft_.scene.tool.mesh), 1, mesh, draft_.ball_mesh);
    draft_.notes.push_back("no tool is named, so the tool is a ball of 1 mm (" + draft_.ball.string() + "). Choose another with --tool.");
  }

  void setTolerances() {
    for (const ToleranceMatch& match : settings_.matches) {
      bool found = false;
      const auto set = [&](SceneItem& item) {
        if (fnmatch(match.pattern.c_str(), item.name.c_str(), 0) != 0) return;
        item.settings.tolerance_mm = match.tolerance_mm;
        found = true;
      };
      for (Candidate& c : candidates_) set(c.item);
      set(draft_.scene.tool);
      if (!found)
        throw UsageError("--match: no object has a name like " + match.pattern + "; the first of " + std::to_string(candidates_.size()) +
                         " is " + candidates_[0].item.name + ".");
    }
    if (!settings_.reach_mm) return;
    double largest = settings_.tolerance_mm.value_or(0);
    for (const Candidate& c : candidates_) largest = std::max(largest, c.item.settings.tolerance_mm.value_or(0));
    if (!(largest > 0)) throw UsageError("--reach enlarges the tolerance of surfaces, and there is none. Add --tolerance or --match.");
    draft_.scene.reach = formats::Reach{*settings_.reach_mm, std::min(kUnreachedTolerance * largest, formats::kMaxSceneLength)};
  }

  const SceneDraftSettings& settings_;
  std::vector<fs::path> files_;
  const fs::path& scene_path_;
  MeshStore& meshes_;
  std::optional<std::size_t> tool_file_;
  std::vector<std::pair<std::size_t, Eigen::AlignedBox3d>> file_boxes_;
  std::vector<double> file_units_;  // of the same files [mm]
  std::vector<std::string> spaces_;
  std::vector<Candidate> candidates_;
  SceneDraft draft_;
};

}  // namespace

std::vector<std::byte> defaultToolFile() { return formats::encodeObj(ballMesh(kBallDiameter / 2)); }

SceneDraft draftScene(const SceneDraftSettings& settings, const fs::path& scene_path, MeshStore& meshes) {
  return Drafting(settings, scene_path, meshes).run();
}

ToleranceMatch parseToleranceMatch(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  ToleranceMatch match;
  const char* end = text.data() + text.size();
  if (equals != std::string::npos && equals > 0) {
    match.pattern = text.substr(0, equals);
    const auto [rest, error] = std::from_chars(text.data() + equals + 1, end, match.tolerance_mm);
    if (error == std::errc() && rest == end && std::isfinite(match.tolerance_mm) && match.tolerance_mm > 0 &&
        match.tolerance_mm <= formats::kMaxSceneLength)
      return match;
  }
  throw UsageError(text + " is not PATTERN=MM, such as tooth_*=0.1, with a length above 0 and at most 10^6");
}

}  // namespace spheretree::pipeline
