// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/cut/cut_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "pipeline/sound_mesh.h"
#include "spheretree/core/rigid.h"
#include "spheretree/formats/csv_table.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/scene_file.h"
#include "spheretree/formats/trajectory.h"

namespace spheretree::pipeline {
namespace {

namespace fs = std::filesystem;

struct ToolRow {
  double time;
  Configuration tool;  // the graphic one
  bool spins;
  std::vector<double> hinges;  // angles [degree]
};

struct ToolRows {
  std::string scene;
  std::vector<ToolRow> rows;
};

constexpr const char* kAdvice = "give a recording of haptic-player --record";

ToolRows readRows(std::string_view text, const std::string& name, std::uint64_t last_tick) {
  formats::CsvTable table(text, name);
  std::array<std::size_t, 7> pose{};
  const std::array<const char*, 7> names{"gx_mm", "gy_mm", "gz_mm", "gqw", "gqx", "gqy", "gqz"};
  for (std::size_t k = 0; k < 7; ++k) pose[k] = table.require(names[k], kAdvice);
  const std::size_t tick = table.require("tick", kAdvice), time = table.require("t_s", kAdvice), scene = table.require("scene", kAdvice);
  const std::size_t spin = table.require("spin", "record a scene whose tool has a burr and with an object that can be cut");
  const std::optional<std::size_t> hinges = table.find("hinges_deg");
  ToolRows out;
  std::uint64_t before = 0;
  while (table.next()) {
    const std::uint64_t now = table.count(tick, UINT64_MAX - 1);
    if (out.rows.empty())
      out.scene = formats::decodedField(table.field(scene));
    else if (now != before + 1)
      table.failField(tick, "the row before is tick " + std::to_string(before) +
                                ", so that the path of the burr between them is not known; record the run again");
    before = now;
    if (now > last_tick) continue;
    ToolRow row{table.number(time), {}, table.count(spin, 1) == 1, {}};
    std::array<double, 7> v{};
    for (std::size_t k = 0; k < 7; ++k) v[k] = table.number(pose[k], 1e7);
    row.tool = {{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}};
    if (!(std::abs(row.tool.orientation.norm() - 1) < 1e-3)) table.failField(pose[3], "the quaternion is not of length 1");
    if (hinges) row.hinges = table.numbers(*hinges, 360);
    out.rows.push_back(std::move(row));
  }
  if (out.rows.empty()) table.fail("no step was recorded");
  if (last_tick != kWholeRun && before < last_tick)
    throw formats::FormatError(name + ": ends with tick " + std::to_string(before) + ", before tick " + std::to_string(last_tick) +
                               ". Name a tick of the recording.");
  return out;
}

/// The pose of an object in each row.
class ObjectPoses {
 public:
  ObjectPoses(const formats::SceneFile& scene, const fs::path& path, const formats::SceneItem& object) : rest_(object.pose) {
    std::size_t hinge = 0;
    for (const formats::SceneBody& body : scene.bodies) {
      if (body.name == object.body) {
        hinge_ = body.hinge;
        number_ = hinge;
        if (!body.hinge) poses_ = formats::readTrajectory(formats::scenePath(path, body.pose_csv)).poses;
      }
      hinge += body.hinge ? 1 : 0;
    }
  }
  Configuration at(const ToolRow& row) const {
    if (hinge_) {  // steered in the view, or on the path of the scene
      const double angle = number_ < row.hinges.size() ? row.hinges[number_] : formats::hingeAngle(*hinge_, row.time);
      return composed(formats::hingePose(*hinge_, angle), rest_);
    }
    if (poses_.empty()) return rest_;
    const double last = static_cast<double>(poses_.size() - 1);
    return composed(poses_[static_cast<std::size_t>(std::clamp(std::round(1000 * row.time), 0.0, last))], rest_);
  }

 private:
  Configuration rest_;
  std::optional<formats::Hinge> hinge_;
  std::size_t number_ = 0;  // of the hinge
  std::vector<Configuration> poses_;
};

std::vector<builder::BurrPath> pathsOf(std::span<const ToolRow> rows, const ObjectPoses& object, const formats::SceneItem& tool) {
  std::vector<builder::BurrPath> out;
  for (const Ball& ball : tool.burr) {
    const auto centreIn = [&](const ToolRow& row) {
      const Configuration pose = composed(inverse(object.at(row)), row.tool);
      return Eigen::Vector3d(pose.position + pose.orientation * (ball.centre - tool.reference_point_mm));
    };
    bool spun = false;
    for (std::size_t i = 1; i < rows.size(); ++i) {
      if (rows[i].spins && !spun) out.push_back({ball.radius, {centreIn(rows[i - 1])}});
      if (rows[i].spins) out.back().centres.push_back(centreIn(rows[i]));
      spun = rows[i].spins;
    }
  }
  return out;
}

TriangleMesh layerMesh(const formats::SceneFile& scene, const fs::path& path, const formats::SceneItem& object,
                       const formats::CutLayer& layer, std::vector<std::string>& notes, builder::Progress& progress) {
  const fs::path file = formats::scenePath(path, layer.mesh);
  const double unit = formats::unitInMm(object.unit.empty() ? scene.unit : object.unit);
  const formats::MeshFile read = formats::readMesh(file, unit, object.unit.empty() ? formats::unitInMm("m") : unit);
  std::vector<std::string> steps;
  TriangleMesh mesh = soundMesh(read.mesh, file.string(), builder::RepairKind::Auto, steps, progress).mesh;
  for (const std::string& step : steps) notes.push_back(file.string() + ": " + step);
  return mesh;
}

}  // namespace

CutRun readCutRun(const fs::path& recording, std::uint64_t last_tick, builder::Progress& progress) {
  progress.stage("read");
  const std::vector<std::byte> bytes = formats::readFile(recording);
  const ToolRows run = readRows({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, recording.string(), last_tick);
  progress.check();
  if (run.scene.empty() || run.scene == "sample")
    throw formats::FormatError(recording.string() + ": names no scene file in its first row. Record it again with haptic-player SCENE.");
  CutRun out;
  out.scene = (fs::absolute(recording).parent_path() / run.scene).lexically_normal();
  const formats::SceneFile scene = formats::readScene(out.scene);
  if (!formats::canCut(scene))
    throw formats::FormatError(out.scene.string() + ": has no burr, or no object that can be cut. Give the scene of the recording a " +
                               "\"burr\" and a \"cut\".");
  if (!scene.tool.reference_point.empty())
    throw formats::FormatError(out.scene.string() +
                               ": tool.reference_point is for spheretree batch. Record in the scene.json that it writes.");
  out.steps = run.rows.size();
  out.spinning = static_cast<std::size_t>(std::count_if(run.rows.begin(), run.rows.end(), [](const ToolRow& row) { return row.spins; }));
  for (const formats::SceneItem& object : scene.objects) {
    if (!object.cut) continue;
    CutRun::Object& made = out.objects.emplace_back();
    made.name = object.name;
    made.pose = object.pose;
    for (const formats::CutLayer& layer : object.cut->layers) {
      progress.check();
      made.layers.push_back({layer.name, layerMesh(scene, out.scene, object, layer, out.notes, progress)});
    }
    made.paths = pathsOf(run.rows, ObjectPoses(scene, out.scene, object), scene.tool);
  }
  return out;
}

}  // namespace spheretree::pipeline
