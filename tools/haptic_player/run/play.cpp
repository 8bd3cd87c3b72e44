// SPDX-License-Identifier: GPL-3.0-or-later
#include "run/play.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <thread>

#include "run/body_paths.h"
#include "run/real_time.h"
#include "run/sample_scene.h"
#include "run/servo_loop.h"
#include "scene/compiled_scene.h"
#include "spheretree/device/emergency_stop.h"
#include "spheretree/device/replay_device.h"
#include "spheretree/device/tool_mount.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/path_name.h"
#include "spheretree/formats/scene_file.h"
#include "spheretree/formats/trajectory.h"
#include "spheretree/scene/describe_scene.h"
#include "terminal.h"

namespace spheretree::player {
namespace {

using Json = nlohmann::ordered_json;

runtime::SceneDescription readDescription(const formats::SceneFile& file, const std::filesystem::path& path, builder::Progress& progress) {
  progress.stage("load " + tool::counted(file.objects.size() + 1, "tree"));
  return scene::describeScene(file, path, [&](double share) {
    progress.check();
    progress.advance(share);
  });
}

/// The pose at `t` of a path with a pose for each millisecond, constant beyond its ends. At a millisecond it is the one
/// of the path, bit for bit.
Configuration poseAt(const std::vector<Configuration>& poses, double t) {
  const double at = std::clamp(t * 1000, 0.0, static_cast<double>(poses.size() - 1)), nearest = std::round(at);
  if (std::abs(at - nearest) < 1e-6) return poses[static_cast<std::size_t>(nearest)];
  const auto begin = static_cast<std::size_t>(at);
  const Configuration &from = poses[begin], &to = poses[begin + 1];
  const double share = at - static_cast<double>(begin);
  return {from.position + share * (to.position - from.position), from.orientation.slerp(share, to.orientation)};
}

device::IntendedPath sampledPath(std::vector<Configuration> poses) {
  return [poses = std::move(poses)](double t) { return poseAt(poses, t); };
}

/// A pose for each step at `rate`.
std::vector<Configuration> resampled(const std::vector<Configuration>& poses, double rate) {
  std::vector<Configuration> out;
  const double length = static_cast<double>(poses.size() - 1) / 1000;
  for (std::size_t n = 0; static_cast<double>(n) / rate <= length + 1e-9; ++n) out.push_back(poseAt(poses, static_cast<double>(n) / rate));
  return out;
}

/// The mount of the tool on the handle and the pose of the device, from the scene. Absent if the scene specifies
/// neither, and for poses that are already those of the tool.
std::optional<device::ToolMount> mountOf(const formats::SceneFile& scene, DeviceKind device) {
  if (device == DeviceKind::Replay) return std::nullopt;
  if (isIdentity(scene.device) && isIdentity(scene.tool.pose)) return std::nullopt;
  return device::ToolMount{scene.device, scene.tool.pose};
}

std::vector<Configuration> posesOf(const PlaySettings& settings) {
  return settings.trajectory.empty() ? std::vector<Configuration>() : formats::readTrajectory(settings.trajectory).poses;
}

/// Opens a device that needs no hardware.
std::unique_ptr<device::Device> openInput(const PlaySettings& settings, const runtime::Scene& scene,
                                          const std::optional<device::ToolMount>& mount, PlayObserver* observer) {
  std::vector<Configuration> poses = posesOf(settings);
  if (settings.device == DeviceKind::Replay)
    return std::make_unique<device::ReplayDevice>(settings.rate == 1000 ? std::move(poses) : resampled(poses, settings.rate));
  device::SimulatedSettings simulated;
  simulated.hand = *device::findHand(settings.hand);
  simulated.duration = settings.seconds.value_or(poses.empty() ? 10.0 : static_cast<double>(poses.size()) / 1000);
  if (observer && !settings.seconds) simulated.duration = std::numeric_limits<double>::infinity();
  simulated.path = poses.empty() ? tourOf(scene, simulated.duration) : sampledPath(std::move(poses));
  if (observer) simulated.path = observer->handPath(std::move(simulated.path));
  if (mount) simulated.path = [mount = *mount, tool = std::move(simulated.path)](double t) { return device::handleOf(mount, tool(t)); };
  return std::make_unique<device::SimulatedDevice>(simulated);
}

/// Whether all memory is locked.
Json tryToLockMemory() {
  const std::string fault = lockMemory();
  if (!fault.empty()) tool::say("haptic-player: " + fault);
  return fault.empty();
}

void reportPriority(int error) {
  if (error > 0) tool::say("haptic-player: " + priorityAdvice(error));
}

/// The line of a run in at most `columns` - 1 characters: whole figures, the most important ones first.
std::string statusLine(const device::DeviceStatus& status, double rate, const ServoLoop& loop, int columns) {
  char figures[4][48];
  std::snprintf(figures[0], sizeof figures[0], "%8.1f s", static_cast<double>(status.ticks) / rate);
  std::snprintf(figures[1], sizeof figures[1], "  force %6.2f N", loop.force());
  std::snprintf(figures[2], sizeof figures[2], "  late %llu", static_cast<unsigned long long>(status.late_ticks));
  std::snprintf(figures[3], sizeof figures[3], "  step %6.0f us", loop.time());
  std::string line;
  for (const char* figure : figures)
    if (line.size() + std::strlen(figure) < static_cast<std::size_t>(columns)) line += figure;
  return line;
}

/// Runs until the device ends, the time is over, or a stop is requested.
void runDevice(device::Device& device, const PlaySettings& settings, ServoLoop& loop, PlayObserver* observer) {
  const auto limit = settings.seconds ? static_cast<std::uint64_t>(std::llround(*settings.seconds * settings.rate)) : ~std::uint64_t{0};
  auto shown = std::chrono::steady_clock::now();
  bool told = false;
  for (;;) {
    const device::DeviceStatus status = device.status();
    if (status.phase != device::Phase::Running || status.ticks >= limit) break;
    if (settings.clock == device::Clock::Stepped) device.step();
    if (observer && !observer->onTurn(device, loop)) break;
    if (settings.clock == device::Clock::Real && !observer) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (settings.clock == device::Clock::Real && !told && status.ticks > 0) {
      reportPriority(loop.priorityError());
      told = true;
    }
    const auto now = std::chrono::steady_clock::now();
    if (settings.status_line && now - shown > std::chrono::milliseconds(200)) {
      if (const int columns = tool::terminalColumns(); columns > 0)
        tool::drawProgressLine(statusLine(status, settings.rate, loop, columns), columns);
      shown = now;
    }
  }
  if (settings.status_line) tool::clearProgressLine();
}

const char* modeName(runtime::Mode mode) { return mode == runtime::Mode::Published ? "paper" : "constrained"; }

const char* endName(PlayEnd end) {
  return end == PlayEnd::Complete ? "complete" : end == PlayEnd::Interrupted ? "interrupted" : "device failed";
}

}  // namespace

std::unique_ptr<device::Device> openDeviceOf(const PlaySettings& settings) {
  if (settings.device == DeviceKind::Real) return device::openDevice(settings.device_name, settings.open);
  std::vector<Configuration> poses = posesOf(settings);
  if (settings.device == DeviceKind::Replay) return std::make_unique<device::ReplayDevice>(resampled(poses, settings.rate));
  device::SimulatedSettings simulated;
  simulated.hand = *device::findHand(settings.hand);
  if (!poses.empty()) simulated.path = sampledPath(std::move(poses));
  return std::make_unique<device::SimulatedDevice>(simulated);
}

device::SafetySettings safetyOf(const PlaySettings& settings) {
  device::SafetySettings safety;
  safety.period = 1 / settings.rate;
  safety.clutch_buttons = settings.clutch_buttons;
  safety.carried_weight = settings.carried_weight;
  return safety;
}

bool movesTissue(const PlaySettings& settings, const runtime::Scene& scene) {
  if (!settings.large_motion || settings.mode != runtime::Mode::Constrained) return false;
  for (std::size_t object = 0; object < scene.objectCount(); ++object)
    if (scene.tissue(object)) return true;
  return false;
}

bool controlsPassivity(const PlaySettings& settings, const formats::SceneFile& scene) {
  return settings.device != DeviceKind::Replay && (settings.passivity_control || scene.passivity_control);
}

RunIdentity identityOf(const PlaySettings& settings, const std::filesystem::path& recording, bool has_tissue) {
  RunIdentity identity{kSampleScene,
                       std::string("mode=") + modeName(settings.mode) +
                           " contact=" + (settings.contact == runtime::ContactSurface::Skin ? "skin" : "leaves"),
                       {"molar"}};
  identity.has_tissue = has_tissue;
  const formats::SceneFile scene = settings.scene.empty() ? formats::SceneFile() : formats::readScene(settings.scene);
  identity.has_passivity = controlsPassivity(settings, scene);
  if (has_tissue) identity.settings += " tissue=large";
  if (settings.rate != 1000) identity.settings += " rate=" + std::to_string(std::lround(settings.rate));
  if (settings.scene.empty()) return identity;
  identity.objects.clear();
  for (const formats::SceneItem& object : scene.objects) identity.objects.push_back(object.name);
  for (const formats::SceneBody& body : scene.bodies) identity.hinges += body.hinge ? 1 : 0;
  identity.hinges = std::min(identity.hinges, kMaxHinges);
  if (formats::canCut(scene))
    for (const formats::SceneItem& object : scene.objects)
      if (object.cut)
        for (const formats::CutLayer& layer : object.cut->layers) identity.layers.push_back(layer.name);
  identity.scene = formats::toUtf8(std::filesystem::proximate(settings.scene, std::filesystem::absolute(recording).parent_path()));
  if (identity.scene == kSampleScene) identity.scene = std::string("./") + kSampleScene;
  return identity;
}

runtime::SceneDescription describeScene(const std::filesystem::path& path, builder::Progress& progress) {
  return path.empty() ? sampleScene(progress) : readDescription(formats::readScene(path), path, progress);
}

runtime::Scene compiledScene(const runtime::SceneDescription& description, const std::filesystem::path& path) {
  runtime::Scene scene;
  std::string fault;
  if (!runtime::compileScene(description, scene, fault))
    throw formats::FormatError((path.empty() ? "sample scene" : formats::toUtf8(path)) + ": " + fault);
  return scene;
}

runtime::Scene loadScene(const std::filesystem::path& path, runtime::ContactSurface contact, builder::Progress& progress) {
  runtime::SceneDescription description = describeScene(path, progress);
  description.contact = contact;
  return compiledScene(description, path);
}

device::IntendedPath tourOf(const runtime::Scene& scene, double seconds) {
  // Finds where the tool, coming from above, first touches each object, with the runtime itself.
  struct Stop {
    Eigen::Vector3d high, touch;
  };
  std::vector<Stop> stops;
  runtime::Workspace workspace(scene);
  const runtime::CompiledScene& compiled = scene.compiled();
  double top = 0;
  for (std::size_t i = 0; i < compiled.objects.size(); ++i)
    top = std::max(top, compiled.objects[i].anchor.z() + compiled.shapeOf(i).radius + compiled.tool.reach + 5);
  // One more than the time allows, because the tool already approaches the next one.
  const double largest = std::floor(std::min(seconds, kLongestTourSeconds) / kTourStopSeconds) + 2;
  for (const runtime::CompiledObject& object : compiled.objects) {
    if (static_cast<double>(stops.size()) >= largest) break;
    const Eigen::Vector3d high(object.anchor.x(), object.anchor.y(), top);
    runtime::resetTo({high, {1, 0, 0, 0}}, workspace);
    Eigen::Vector3d touch = high;
    for (int n = 0; n < 20'000 && touch.z() > object.anchor.z(); ++n) {
      touch.z() -= 0.1;
      if (runtime::step(scene, {touch, {1, 0, 0, 0}}, runtime::Mode::Constrained, workspace).active > 0) break;
    }
    stops.push_back({touch + Eigen::Vector3d(0, 0, 5), touch});
  }
  if (stops.empty()) stops.push_back({Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});  // a scene without objects
  return [stops](double t) {
    constexpr double kStop = kTourStopSeconds;
    const std::size_t i = static_cast<std::size_t>(t / kStop) % stops.size();
    const double s = std::fmod(t, kStop) / kStop;  // 0..1: above, down, circle, up
    const Stop &now = stops[i], &next = stops[(i + 1) % stops.size()];
    const auto blend = [](double x) { return 0.5 - 0.5 * std::cos(std::numbers::pi * std::clamp(x, 0.0, 1.0)); };
    Eigen::Vector3d p = now.high;
    p.z() += (now.touch.z() - 2 - now.high.z()) * (blend(s / 0.2) - blend((s - 0.6) / 0.2));
    const double turn = 2 * std::numbers::pi * blend((s - 0.2) / 0.4);
    p.x() += 1 - std::cos(turn);
    p.y() += std::sin(turn);
    p += (next.high - now.high) * blend((s - 0.8) / 0.2);
    return Configuration{p, {1, 0, 0, 0}};
  };
}

namespace {

/// What a summary says before its figures.
Json headOf(const PlaySettings& settings, const device::DeviceInfo& device, PlayEnd end) {
  return {{"schema", "spheretree.run/1"},
          {"scene", settings.scene.empty() ? Json("sample") : Json(formats::toUtf8(settings.scene))},
          {"device", device.model},
          {"mode", modeName(settings.mode)},
          {"clock", settings.clock == device::Clock::Real ? "real" : "stepped"},
          {"rate_hz", settings.rate},
          {"renders_torque", device.renders_torque},
          {"end", endName(end)}};
}

PlayEnd endOf(const device::DeviceStatus& status, const PlayObserver* observer) {
  const bool was_closed = observer && device::EmergencyStop::signal() == 0;  // the user closed the window, which is a regular end
  if (device::EmergencyStop::requested() && !was_closed) return PlayEnd::Interrupted;
  return status.phase == device::Phase::Failed ? PlayEnd::DeviceFailed : PlayEnd::Complete;
}

}  // namespace

PlayEnd play(const PlaySettings& settings, builder::Progress& progress, nlohmann::ordered_json& summary, PlayObserver* observer) {
  const bool real = settings.clock == device::Clock::Real;
  std::unique_ptr<device::Device> device;
  if (settings.device == DeviceKind::Real) device = openDeviceOf(settings);  // reports errors at once
  const formats::SceneFile file = settings.scene.empty() ? formats::SceneFile() : formats::readScene(settings.scene);
  runtime::SceneDescription description = settings.scene.empty() ? sampleScene(progress) : readDescription(file, settings.scene, progress);
  description.contact = settings.contact;
  description.step_time = 1 / settings.rate;
  runtime::Scene scene = compiledScene(description, settings.scene);
  if (observer) observer->onScene(description);
  const std::optional<device::ToolMount> mount = mountOf(file, settings.device);
  if (!device) device = openInput(settings, scene, mount, observer);
  const bool has_tissue = movesTissue(settings, scene);
  std::unique_ptr<RecordingWriter> recording;
  if (!settings.record.empty())
    recording = std::make_unique<RecordingWriter>(settings.record, identityOf(settings, settings.record, has_tissue));
  const BodyPaths bodies(file, settings.scene);
  ServoLoop::Options options;
  options.bodies = &bodies;
  options.mount = mount;
  options.mode = settings.mode;
  options.wait = !real;
  options.cuts = formats::canCut(file) && settings.mode == runtime::Mode::Constrained;
  if (options.cuts && !settings.trajectory.empty()) options.spins = formats::readTrajectory(settings.trajectory).spins;
  options.spindle_buttons = settings.spindle_buttons;
  options.real_time_thread = real && settings.device_name != "phantom";  // the vendor's thread has a priority of its own
  std::optional<TissueMotion> tissue;
  if (has_tissue) tissue.emplace(scene, real ? TissueMotion::Clock::Real : TissueMotion::Clock::Stepped);
  options.tissue = tissue ? &*tissue : nullptr;
  options.tuned = observer ? &scene : nullptr;
  ServoLoop loop(scene, recording.get(), options, observer ? observer->streams() : nullptr);
  const device::EmergencyStop emergency_stop;  // from now on Ctrl-C first stops the device
  progress.check();
  const Json locked = real ? tryToLockMemory() : Json(nullptr);

  // ServoLoop passes on the wrench of the coupling, which a recording shows, and the device alone limits it.
  device::SafetySettings safety = safetyOf(settings);
  safety.max_force = scene.wrenchLimits().force;
  safety.max_torque = scene.wrenchLimits().torque;
  safety.passivity_control = controlsPassivity(settings, file);
  device->start(loop, safety, settings.clock);
  runDevice(*device, settings, loop, observer);
  const device::DeviceStatus status = device->status();
  device->stop();
  if (recording) recording->finish();

  const PlayEnd end = endOf(status, observer);
  summary = headOf(settings, device->info(), end);
  summary.update(loop.statistics().toJson());
  summary["missed_deadlines"] = status.late_ticks;
  if (has_tissue) summary["tissue_states"] = loop.tissueStates();
  summary["real_time"] = {{"priority", loop.priorityError() < 0 ? Json(nullptr) : Json(loop.priorityError() == 0)},
                          {"memory_locked", locked}};
  summary["safety_events"] = status.safety_so_far;
  if (safety.passivity_control) summary["passivity_control"] = loop.statistics().passivityJson();
  if (observer) observer->addTo(summary);
  if (recording) summary["recording"] = {{"file", formats::toUtf8(settings.record)}, {"rows_lost", recording->lost()}};
  return end;
}

}  // namespace spheretree::player
