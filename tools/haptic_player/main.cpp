// SPDX-License-Identifier: GPL-3.0-or-later
// haptic-player: plays scenes, and runs the stability scenarios. Options: docs/haptic_player.md
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>

#include "command_reference.h"
#include "generator.h"
#include "help_formatter.h"
#include "json_text.h"
#include "mistyped.h"
#include "model/view_error.h"
#include "program_end.h"
#include "progress_bar.h"
#include "run/measure_device.h"
#include "run/play.h"
#include "run/run_notes.h"
#include "run/serve_device.h"
#include "run_files.h"
#include "scenario_command.h"
#include "spheretree/device/device.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/path_name.h"
#include "system_calls.h"
#include "terminal.h"
#include "view/run_view.h"
#include "view/view_options.h"

namespace spheretree::player {
namespace {

using namespace spheretree::tool;

struct Options {
  PlaySettings play;
  ViewOptions view;
  ScenarioOptions bench;
  CuttingOptions cutting;
  ToolsOptions tools;
  std::string device, mode = "constrained", tissue = "large", contact = "skin", clock = "real", progress = "auto";
  std::filesystem::path measures;
  double seconds = 0;
  int clutch_button = -1, spindle_button = -1, serve = -1;
  bool measure = false, check_realtime = false, force = false, list = false, json = false, quiet = false, gimbal_torque = false,
       compare_cutting = false;
};

const std::string kProgram = "haptic-player";
constexpr double kCheckSeconds = 20;  // length of --check-realtime without another [s]

runtime::ContactSurface contactOf(const Options& options) {
  return options.contact == "skin" ? runtime::ContactSurface::Skin : runtime::ContactSurface::Leaves;
}

/// Refuses options that only a window or a picture uses, or only the other mode.
void refuseUnseenOptions(const CLI::App& cli, const Options& options) {
  for (const char* name : {"--size", "--theme", "--show", "--from", "--within", "--follow", "--panels", "--scale"})
    if (!options.view.isAsked() && cli.count(name) > 0) throw UsageError(std::string(name) + " is for --view and --picture");
  if (!options.view.view && cli.count("--hand-from") > 0) throw UsageError("--hand-from is for --view");
  if (options.mode == "paper" && cli.count("--contact") > 0)
    throw UsageError("--contact is for --mode constrained: the published algorithm knows only leaves");
  if (options.mode == "paper" && cli.count("--tissue") > 0)
    throw UsageError("--tissue is for --mode constrained: to the published algorithm everything is rigid");
  if (options.view.isAsked() && cli.count("--rate") > 0)
    throw UsageError("--rate is not for windows and pictures: they show a step for each millisecond");
  if (!options.view.picture.empty() && options.view.replay.empty() && options.clock == "real" && cli.count("--clock") > 0)
    throw UsageError("--clock real is not for --picture: pictures are those of a stepped run");
  if (options.force && options.bench.out.empty() && options.view.picture.empty()) throw UsageError("--force is for --out and --picture");
}

int runBench(const CLI::App& cli, const Options& options, WorkProgress& progress) {
  if (!options.device.empty() && options.device != "simulated") throw UsageError("--scenario runs on the simulated device");
  refuseUnseenOptions(cli, options);
  return runScenarioCommand(options.bench, options.play.rate, contactOf(options), options.json, options.view, progress);
}

/// Refuses all options but those `used`.
void refuseOthers(const CLI::App& cli, std::initializer_list<std::string_view> used, const char* command) {
  for (const CLI::Option* option : cli.get_options())
    if (option->count() > 0 && std::ranges::count(used, option->get_name()) == 0)
      throw UsageError(option->get_name() + " is not for " + command);
}

int runCutting(const CLI::App& cli, Options& options, builder::Progress& progress) {
  refuseOthers(cli, {"SCENE", "--trajectory", "--compare-cutting", "--voxel-mm", "--chart", "--cache", "--json", "--progress", "--quiet"},
               "--compare-cutting");
  options.cutting.scene = options.play.scene, options.cutting.trajectory = options.play.trajectory;
  options.cutting.chart = options.bench.chart, options.cutting.cache = options.bench.cache;
  return runCuttingCommand(options.cutting, options.json, progress);
}

int runTools(const CLI::App& cli, Options& options, WorkProgress& progress) {
  refuseOthers(cli, {"--compare-tools", "--depth-mm", "--chart", "--cache", "--json", "--progress", "--quiet"}, "--compare-tools");
  options.tools.chart = options.bench.chart, options.tools.cache = options.bench.cache;
  return runToolsCommand(options.tools, options.json, progress);
}

void printSummary(const nlohmann::ordered_json& s) {
  const auto& total = s["time_us"]["total"];
  printResult("%s on %s, %s mode, %s clock: %s\n", counted(s["steps"].get<std::uint64_t>(), "step").c_str(),
              s["device"].get<std::string>().c_str(), s["mode"].get<std::string>().c_str(), s["clock"].get<std::string>().c_str(),
              s["end"].get<std::string>().c_str());
  printResult("step time [us]     median %.1f, p99 %.1f, p99.9 %.1f, max %.1f; %llu deadlines missed\n", total["median"].get<double>(),
              total["p99"].get<double>(), total["p99_9"].get<double>(), total["max"].get<double>(),
              static_cast<unsigned long long>(s["missed_deadlines"].get<std::uint64_t>()));
  const auto& longest = s["longest_step"];
  printResult("longest step       at %.3f s, %s: %u pairs, %u contacts, %.1f us of processor time\n", longest["t_s"].get<double>(),
              longest["kind"].get<std::string>().c_str(), longest["pairs"].get<unsigned>(), longest["contacts"].get<unsigned>(),
              longest["processor_us"].get<double>());
  const auto by_clock = s["steps_over_ms"]["clock"].get<std::uint64_t>(),
             by_processor = s["steps_over_ms"]["processor"].get<std::uint64_t>();
  printResult("steps too long     %llu by the clock, %llu by processor time%s\n", static_cast<unsigned long long>(by_clock),
              static_cast<unsigned long long>(by_processor), by_clock > by_processor ? ": the others waited for other programs" : "");
  printResult("penetration [mm]   %.4g\n", s["largest_penetration_mm"].get<double>());
  printResult("force [N]          largest %.4g, largest step %.4g\n", s["largest_force_n"].get<double>(),
              s["wrench_step"]["force_n"].get<double>());
  printResult("energy [mJ]        smallest %.4g, final %.4g\n", s["energy_mj"]["smallest"].get<double>(),
              s["energy_mj"]["final"].get<double>());
  printResult("faults            ");
  for (const auto& [name, count] : s["faults"].items())
    printResult(" %s %llu", name.c_str(), static_cast<unsigned long long>(count.get<std::uint64_t>()));
  printResult("\n");
  for (const auto& note : s["notes"]) printResult("note               %s\n", plainText(note.get<std::string>()).c_str());
}

/// Whether every step of a run on the real clock began and ended in time; prints that, and what the system granted.
bool heldRealTime(nlohmann::ordered_json& summary, bool json) {
  auto& real_time = summary["real_time"];
  const auto late = summary["missed_deadlines"].get<std::uint64_t>(), too_long = summary["steps_over_ms"]["clock"].get<std::uint64_t>();
  const bool held = late == 0 && too_long == 0;
  real_time["held"] = held;
  if (json) return held;
  const auto granted = [](const nlohmann::ordered_json& value) { return value.is_null() ? "not asked" : value.get<bool>() ? "yes" : "no"; };
  printResult("granted            priority %s, locked memory %s\n", granted(real_time["priority"]), granted(real_time["memory_locked"]));
  printResult("real time          %s\n",
              held ? "held: each step began and ended within its period"
                   : (counted(late, "step") + " began late, " + counted(too_long, "step") + " took too long").c_str());
  return held;
}

/// Refuses options of a run beside a recording, which is shown as it was.
void refuseRunOptions(const CLI::App& cli) {
  for (const char* name : {"--device",
                           "--trajectory",
                           "--mode",
                           "--contact",
                           "--tissue",
                           "--clock",
                           "--seconds",
                           "--check-realtime",
                           "--hand",
                           "--passivity-control",
                           "--rate",
                           "--haply-host",
                           "--haply-device",
                           "--dhd-library",
                           "--allow-remote",
                           "--serve",
                           "--measure",
                           "--clutch-button",
                           "--spindle-button",
                           "--carried-weight",
                           "--hd-library",
                           "--hd-device",
                           "--hd-calibrate",
                           "--hd-gimbal-torque",
                           "--hand-from",
                           "--record",
                           "--json"})
    if (cli.count(name) > 0) throw UsageError(std::string(name) + " is for a run, and --replay shows one that was recorded");
}

/// Refuses options that only another device uses.
void refuseStrayOptions(const CLI::App& cli, const std::string& device) {
  for (const char* name : {"--hd-library", "--hd-device", "--hd-calibrate", "--hd-gimbal-torque"})
    if (device != "phantom" && cli.count(name) > 0) throw UsageError(std::string(name) + " is for --device phantom");
  for (const char* name : {"--haply-host", "--haply-device"})
    if (device != "haply" && cli.count(name) > 0) throw UsageError(std::string(name) + " is for --device haply");
  if (device != "dhd" && cli.count("--dhd-library") > 0) throw UsageError("--dhd-library is for --device dhd");
  if (device != "haply" && !device.starts_with("net:") && cli.count("--serve") == 0 && cli.count("--allow-remote") > 0)
    throw UsageError("--allow-remote is for --device haply, --device net:HOST:PORT and --serve");
  if (!device::isDeviceName(device))
    for (const char* name : {"--clutch-button", "--spindle-button", "--carried-weight"})
      if (cli.count(name) > 0)
        throw UsageError(std::string(name) + " is for devices that a hand holds: haply, dhd, phantom, net:HOST:PORT");
  if (device != "simulated" && cli.count("--hand") > 0) throw UsageError("--hand is for --device simulated");
}

/// Refuses options of a scene beside --serve and --measure, which have none.
void refuseSceneOptions(const CLI::App& cli, const std::string& action) {
  for (const char* name : {"SCENE", "--mode", "--contact", "--tissue", "--clock", "--check-realtime", "--passivity-control", "--hand-from",
                           "--record", "--replay", "--view", "--picture"})
    if (cli.count(name) > 0) throw UsageError(std::string(name) + " is not for " + action + ", which plays no scene");
}

void printMeasures(const nlohmann::ordered_json& m) {
  const auto text = [](const nlohmann::ordered_json& value) { return value.is_null() ? std::string("not found") : value.dump(); };
  const auto& jitter = m["jitter_us"];
  const auto& friction = m["friction_n"];
  printResult("%s: %s\n", plainText(m["device"].get<std::string>()).c_str(), m["end"].get<std::string>().c_str());
  printResult("rate [Hz]          %s, %s steps late\n", text(m["rate_hz"]).c_str(), text(m["late_steps"]).c_str());
  printResult("jitter [us]        median %s, p99 %s, max %s\n", text(jitter["median"]).c_str(), text(jitter["p99"]).c_str(),
              text(jitter["max"]).c_str());
  printResult("latency [ms]       %s\n", text(m["latency_ms"]).c_str());
  printResult("encoder count [mm] %s\n", text(m["encoder_count_mm"]).c_str());
  printResult("friction [N]       %s, %s, %s along x, y, z\n", text(friction[0]).c_str(), text(friction[1]).c_str(),
              text(friction[2]).c_str());
  printResult("temperature        %s of 1\n", text(m["temperature"]).c_str());
  if (!m.contains("proposed")) return;
  printResult("proposed           --rate %s, a stiffness of %s N/mm\n", text(m["proposed"]["rate_hz"]).c_str(),
              text(m["proposed"]["stiffness_n_per_mm"]).c_str());
}

int runMeasure(const CLI::App& cli, Options& options) {
  const RunFiles files;
  files.willWrite(options.measures, {".json"}, "the measures");
  if (!options.measures.empty()) formats::checkWritable(options.measures);
  if (options.play.device == DeviceKind::Simulated) {
    if (cli.count("--hand") == 0) options.play.hand = "released";  // as a handle that nobody holds
    options.play.clock = device::Clock::Stepped;
  }
  const nlohmann::ordered_json measures = measureDevice(options.play);
  if (!options.measures.empty()) formats::writeWhole(options.measures, jsonText(measures, 1) + "\n");
  if (options.json)
    printResult("%s\n", jsonText(measures, 1).c_str());
  else
    printMeasures(measures);
  return measures["end"] == "complete" ? kExitOk : kExitInterrupted;
}

/// What the options mean for the device and the mode, and which of them do not go together.
void settleDevice(const CLI::App& cli, Options& options) {
  PlaySettings& play_settings = options.play;
  // In a window the hand follows an input; the trajectory then gives its start or, with --hand-from file, its path.
  const bool is_driven = play_settings.trajectory.empty() || options.view.view;
  const std::string device = !options.device.empty() ? options.device : is_driven ? "simulated" : "replay";
  const bool is_real = device::isDeviceName(device);
  play_settings.device = device == "replay" ? DeviceKind::Replay : is_real ? DeviceKind::Real : DeviceKind::Simulated;
  play_settings.device_name = device;
  refuseStrayOptions(cli, device);
  refuseUnseenOptions(cli, options);
  if (device == "replay" && play_settings.passivity_control)
    throw UsageError("--passivity-control is not for --device replay: no hand takes up its energy");
  if (device == "replay" && play_settings.trajectory.empty()) throw UsageError("--device replay needs --trajectory IN.csv");
  if (is_real && !play_settings.trajectory.empty())
    throw UsageError("--trajectory is not for --device " + device + ": the hand moves the handle");
  if (is_real && options.clock == "stepped") throw UsageError("--clock stepped is not for --device " + device + ": a hand does not wait");
  if (options.clutch_button >= 0) play_settings.clutch_buttons = 1u << options.clutch_button;
  if (options.spindle_button >= 0) play_settings.spindle_buttons = 1u << options.spindle_button;
  if (options.serve >= 0) refuseSceneOptions(cli, "--serve");
  if (options.measure) {
    refuseSceneOptions(cli, "--measure");
    if (device == "replay" || !play_settings.trajectory.empty()) throw UsageError("--measure is for devices, and a trajectory is none");
  }
  if (options.gimbal_torque) play_settings.open.phantom.torque = device::TorqueConvention::Gimbal;
  play_settings.mode = options.mode == "paper" ? runtime::Mode::Published : runtime::Mode::Constrained;
  if (options.check_realtime) {
    if (options.clock == "stepped" || options.view.isAsked())
      throw UsageError("--check-realtime is not for --clock stepped, windows and pictures: it measures steps on the real clock, alone");
    if (options.seconds == 0 && play_settings.trajectory.empty()) options.seconds = kCheckSeconds;
  }
}

int runPlay(const CLI::App& cli, Options& options, builder::Progress& progress) {
  PlaySettings& play_settings = options.play;
  if (!options.view.replay.empty()) refuseRunOptions(cli);
  play_settings.contact = contactOf(options);
  settleDevice(cli, options);
  play_settings.clock = options.clock == "stepped" ? device::Clock::Stepped : device::Clock::Real;
  play_settings.large_motion = options.tissue == "large";
  if (std::error_code none; std::filesystem::is_directory(play_settings.scene, none)) play_settings.scene /= "scene.json";
  const RunFiles files;
  for (const std::filesystem::path& input : {play_settings.trajectory, play_settings.scene})
    if (!input.empty()) files.willRead(input);
  files.willWrite(play_settings.record, {".csv"}, "the recording");
  if (options.seconds > 0) play_settings.seconds = options.seconds;
  play_settings.status_line = !options.quiet && isTerminal(Stream::Error);
  if (options.serve >= 0) {
    if (options.json) throw UsageError("--json is not for --serve, which has no figures");
    serveDevice(play_settings, static_cast<std::uint16_t>(options.serve));
    return kExitOk;
  }
  if (options.measure) return runMeasure(cli, options);
  nlohmann::ordered_json summary;
  const PlayEnd end =
      options.view.isAsked() ? runView(options.view, play_settings, progress, summary) : play(play_settings, progress, summary);
  if (summary.is_null()) return kExitOk;  // it was a replay
  summary["notes"] = nlohmann::ordered_json::array();
  if (end == PlayEnd::Complete)
    for (const std::string& note : notesOn(play_settings, options.view.view, summary["steps"].get<std::uint64_t>(),
                                           summary["largest_force_n"].get<double>(), summary["renders_torque"].get<bool>()))
      summary["notes"].push_back(note);
  if (!options.json) printSummary(summary);
  const bool is_short = options.check_realtime && !heldRealTime(summary, options.json) && end == PlayEnd::Complete;
  if (options.json) printResult("%s\n", jsonText(summary, 1).c_str());
  if (end == PlayEnd::DeviceFailed)
    return explain(kProgram, kExitFile, "the device failed while running. Check its cable and power, then start again.");
  return end == PlayEnd::Interrupted ? kExitInterrupted : is_short ? kExitTargetMissed : kExitOk;
}

void addRunOptions(CLI::App& cli, Options& o, CLI::Option* scenario) {
  cli.add_option("--trajectory", o.play.trajectory,
                 "Poses of the haptic tool (CSV), interpolated where rows are more than 1 ms apart (at most 0.1 s); with --device "
                 "simulated the poses that the hand intends")
      ->type_name("FILE")
      ->excludes(scenario);
  cli.add_option("--seconds", o.seconds,
                 "Length of the run in s, 0.001 to 86400; default: the whole trajectory, 10 s for a simulated hand, or until Ctrl-C. "
                 "Scenarios have their own lengths")
      ->type_name("S")
      ->check(numberIn(0.001, 86400))
      ->excludes(scenario);
  cli.add_option("--record", o.play.record, "Write one row of CSV for each step; default: none")->type_name("FILE")->excludes(scenario);
  cli.add_option("--clock", o.clock,
                 "real: 1 kHz; stepped: as fast as possible, with the same bytes every time; default real. Scenarios are stepped")
      ->type_name("NAME")
      ->check(CLI::IsMember({"real", "stepped"}))
      ->excludes(scenario);
  std::vector<std::string> hands;
  std::string list;
  for (const device::Hand& hand : device::hands()) {
    hands.emplace_back(hand.name);
    list += (list.empty() ? "" : ", ") + hands.back();
  }
  cli.add_option("--hand", o.play.hand, "Hand on the simulated device: " + list + "; default fine")
      ->type_name("NAME")
      ->check(CLI::IsMember(hands))
      ->excludes(scenario);
  cli.add_option("--mode", o.mode, "constrained, or paper: the published algorithm; default constrained. Scenarios have --modes")
      ->type_name("NAME")
      ->check(CLI::IsMember({"constrained", "paper"}))
      ->excludes(scenario);
  cli.add_option("--contact", o.contact, "Contact surface in constrained mode: skin, for objects that have one, or leaves")
      ->type_name("NAME")
      ->check(CLI::IsMember({"skin", "leaves"}))
      ->capture_default_str();
  cli.add_option(
         "--tissue", o.tissue,
         "Motion of soft tissue in constrained mode: large, computed by a solver in its own thread; small, from its compliance at rest")
      ->type_name("NAME")
      ->check(CLI::IsMember({"large", "small"}))
      ->capture_default_str()
      ->excludes(scenario);
  cli.add_option("--rate", o.play.rate, "Servo steps in a second, 500 to 8000 Hz, of a run or of the scenarios S1 and S3; default 1000")
      ->type_name("HZ")
      ->check(numberIn(500, 8000));
  cli.add_flag("--check-realtime", o.check_realtime,
               "Say whether this machine keeps 1 kHz in this scene: on the real clock, for 20 s, --seconds or the trajectory; exit code 5 "
               "if a step began or ended late")
      ->excludes(scenario);
}

CLI::Validator knownDevice() {
  return CLI::Validator(
      [](const std::string& name) {
        const bool is_known = name == "simulated" || name == "replay" || device::isDeviceName(name);
        return is_known ? std::string() : "'" + name + "' is not one of simulated, replay, haply, dhd, phantom, net:HOST:PORT";
      },
      "");
}

void addVendorOptions(CLI::App& cli, Options& o, CLI::Option* scenario) {
  cli.add_flag("--allow-remote", o.play.open.allow_remote,
               "Also talk to other machines; only in a network that you trust. Default: this machine alone")
      ->excludes(scenario);
  cli.add_option("--haply-host", o.play.open.haply_host, "With --device haply: address of the vendor's service; default 127.0.0.1:10001")
      ->type_name("ADDRESS")
      ->excludes(scenario);
  cli.add_option("--haply-device", o.play.open.haply_device, "With --device haply: device_id of the Inverse3; default: the first one")
      ->type_name("ID")
      ->excludes(scenario);
  cli.add_option("--dhd-library", o.play.open.dhd_library,
                 "With --device dhd: path of the vendor's library; default: where the loader looks")
      ->type_name("FILE")
      ->excludes(scenario);
  cli.add_option("--hd-library", o.play.open.phantom.library,
                 "With --device phantom: path of the vendor's library; default: where the loader looks")
      ->type_name("FILE")
      ->excludes(scenario);
  cli.add_option("--hd-device", o.play.open.phantom.device,
                 "With --device phantom: name in the vendor's configuration; default: the first device")
      ->type_name("NAME")
      ->excludes(scenario);
  cli.add_flag("--hd-calibrate", o.play.open.phantom.calibrate,
               "With --device phantom: calibrate with the arm in its reset pose (once after power-up)")
      ->excludes(scenario);
  cli.add_flag(
         "--hd-gimbal-torque", o.gimbal_torque,
         "With --device phantom: send torques about the axes of the gimbal's joints, not as a vector; docs/device.md says how to find out")
      ->excludes(scenario);
}

void addDeviceOptions(CLI::App& cli, Options& o, CLI::Option* scenario) {
  cli.add_option("--clutch-button", o.clutch_button,
                 "Number of a button, 1 to 31: while it is held there is no force and the tool stands still, then it goes on from there; "
                 "default: none")
      ->type_name("N")
      ->check(CLI::Range(1, 31))
      ->excludes(scenario);
  cli.add_option("--spindle-button", o.spindle_button,
                 "Number of a button or pedal, 1 to 31: the burr of the scene spins while it is held; default: it always spins")
      ->type_name("N")
      ->check(CLI::Range(1, 31))
      ->excludes(scenario);
  cli.add_flag("--passivity-control", o.play.passivity_control,
               "Add damping that removes the energy which sampling and delay give to the hand; default: the setting of the scene. "
               "Not with --device replay")
      ->excludes(scenario);
  cli.add_option("--carried-weight", o.play.carried_weight, "Weight of the handle that the motors carry, 0 to 5 N; default 0")
      ->type_name("NEWTON")
      ->check(numberIn(0, 5))
      ->excludes(scenario);
  addVendorOptions(cli, o, scenario);
  cli.add_option(
         "--serve", o.serve,
         "Serve the device to a program that opens it by net:HOST:PORT, instead of playing a scene: the port, 0 to 65535; 0: one that is "
         "free. Until Ctrl-C, or for --seconds")
      ->type_name("PORT")
      ->check(CLI::Range(0, 65535))
      ->excludes(scenario);
  CLI::Option* const measure =
      cli.add_flag("--measure", o.measure,
                   "Measure the device instead of playing a scene: rate, jitter, latency, encoder count, friction; "
                   "half a minute with the handle free in the middle of its workspace, at most 1 N");
  measure->excludes(scenario);
  cli.add_option("-o,--output", o.measures, "With --measure: also write the figures (.json); default: none")
      ->type_name("FILE")
      ->needs(measure);
}

void addComparisonOptions(CLI::App& cli, Options& o, CLI::Option* scenario) {
  CLI::Option* const cutting =
      cli.add_flag("--compare-cutting", o.compare_cutting,
                   "Compare how the burr of a scene cuts along its --trajectory with drilling in voxels, as an open simulator does it; "
                   "without a scene: into a block. Prints a table, or --json")
          ->excludes(scenario);
  cli.add_option("--voxel-mm", o.cutting.voxel, "With --compare-cutting: edge of the voxels, 0.02 to 1; default 0.1")
      ->type_name("MM")
      ->check(numberIn(0.02, 1))
      ->needs(cutting);
  CLI::Option* const tools =
      cli.add_option("--compare-tools", o.tools.names,
                     "Compare tools of 8 to 4,096 leaves and of hulls with the exact answer for their meshes: all, or names separated by "
                     "commas of the tools ball, probe, mirror, bur and the bodies sphere, edge, groove, molar, side. Prints a table, or "
                     "--json")
          ->type_name("NAMES")
          ->delimiter(',')
          ->allow_extra_args(false)
          ->excludes(scenario)
          ->excludes(cutting);
  cli.add_option("--depth-mm", o.tools.depth,
                 "With --compare-tools: depth of the hand below where the tool would touch, 0.01 to 3; default 0.5")
      ->type_name("MM")
      ->check(numberIn(0.01, 3))
      ->needs(tools);
}

void addScenarioOptions(CLI::App& cli, Options& o, CLI::Option* scenario) {
  cli.add_flag("--list", o.list, "List the scenarios");
  addComparisonOptions(cli, o, scenario);
  cli.add_option("--out", o.bench.out, "With --scenario: folder for stability.json, recordings and models")
      ->type_name("DIR")
      ->needs(scenario);
  cli.add_option("--modes", o.bench.modes,
                 "With --scenario: renderers, separated by commas, of paper, constrained and the published methods points, volume, "
                 "continuous; default paper,constrained")
      ->type_name("NAMES")
      ->needs(scenario);
  cli.add_option("--chart", o.bench.chart,
                 "With --scenario: also compare the --modes on four bodies and three sizes, and cutting, and write one page (.html); with "
                 "--compare-cutting or --compare-tools: the page of that; default: none")
      ->type_name("FILE");
  cli.add_option("--cache", o.bench.cache,
                 "With --scenario and the comparisons: folder that keeps the trees for the next run; default: none")
      ->type_name("DIR");
  cli.add_option("--quality", o.bench.quality, "With --scenario: quality of the trees, quick or standard; default standard")
      ->type_name("NAME")
      ->check(CLI::IsMember({"quick", "standard"}))
      ->needs(scenario);
  cli.add_option("--share", o.bench.share, "With --scenario: share of the repetitions of the table of scenarios, 0.001 to 1; default 1")
      ->type_name("SHARE")
      ->check(numberIn(0.001, 1))
      ->needs(scenario);
  cli.add_option("--turned", o.bench.turned,
                 "With --scenario: number of additional runs, each with a fifth of the repetitions, on bodies that are rotated, scaled and "
                 "of other seeds, 0 to 20; default 1")
      ->type_name("N")
      ->check(CLI::Range(0, 20))
      ->needs(scenario);
  cli.add_option("--threads", o.bench.threads,
                 "With --scenario: threads, which run scenarios and modes at the same time, 0 to 1024; default 0: one for each processor. "
                 "Apart from times, results do not depend on it")
      ->type_name("N")
      ->check(CLI::Range(0, 1024))
      ->needs(scenario);
}

void addOutputOptions(CLI::App& cli, Options& o) {
  cli.add_flag("--json", o.json, "Print the summary, or the figures of the scenarios, as JSON");
  cli.add_flag(
      "--force", o.force,
      "With --out, or with several pictures: replace files that no earlier run wrote, or that were edited since; default: they are "
      "refused");
  cli.add_option("--progress", o.progress,
                 "Form of the progress on stderr: auto, bar, plain, json or none; default auto: a bar on a terminal")
      ->type_name("KIND")
      ->check(CLI::IsMember({"auto", "bar", "plain", "json", "none"}));
  cli.add_flag("-q,--quiet", o.quiet, "Write only errors to stderr");
  cli.set_help_flag("-h,--help", "Print this text");
  cli.set_version_flag("--version", kProgram + " " SPHERETREE_VERSION, "Print the version");
}

void addOptions(CLI::App& cli, Options& o) {
  cli.name(kProgram);
  cli.footer(
      "Examples:\n"
      "  haptic-player scene.json --view\n"
      "      a window, in which the mouse moves the hand\n"
      "  haptic-player scene.json --device haply\n"
      "      a hand on a device; also dhd, phantom, net:HOST:PORT\n"
      "  haptic-player scene.json --trajectory path.csv --clock stepped \\\n      --record run.csv\n"
      "      a recorded path, as fast as possible\n"
      "  haptic-player --view --replay run.csv --compare other.csv\n"
      "      two recordings side by side\n"
      "  haptic-player scene.json --picture out.png --at 2000\n"
      "      a picture, without a display\n"
      "  haptic-player --scenario all --out stability\n"
      "      every scenario, with recordings\n"
      "Exit codes: 0 ok, 1 internal error, 2 usage, 3 file or device cannot be used,\n"
      "  4 input refused, 5 a scenario or real time falls short, 130 interrupted.");
  // The help shows the groups in the order of their first options.
  const auto begin = [&](const char* group) { cli.option_defaults()->group(group); };
  const char *const run = "Run", *const device = "Device", *const window = "Window and pictures",
                    *const bench = "Scenarios and comparisons";
  begin(run);
  CLI::Option* const scene = cli.add_option("SCENE", o.play.scene,
                                            "Scene with trees, as `spheretree batch` writes it, or the folder of a batch; default: the "
                                            "built-in sample, a probe over a molar")
                                 ->type_name("FILE");
  begin(device);
  cli.add_option(
         "--device", o.device,
         "simulated, replay, haply, dhd, phantom or net:HOST:PORT; default simulated, or replay with --trajectory. Scenarios always use "
         "a simulated device")
      ->type_name("NAME")
      ->check(knownDevice());
  begin(window);
  addViewOptions(cli, o.view);
  begin(bench);
  CLI::Option* const scenario =
      cli.add_option("--scenario", o.bench.scenario,
                     "Run stability scenarios, in both modes, instead of a scene: all, or ids and names separated by commas")
          ->type_name("NAMES");
  scenario->excludes(scene);
  addScenarioOptions(cli, o, scenario);
  begin(run);
  addRunOptions(cli, o, scenario);
  begin(device);
  addDeviceOptions(cli, o, scenario);
  begin("Output");
  addOutputOptions(cli, o);
}

int run(const CLI::App& cli, Options& options) {
  if (options.list) return listScenarios();
  ProgressBar progress(options.progress, options.quiet);
  const InterruptGuard guard(progress);
  const RunFiles files(progress, kProgram, options.force);
  if (options.compare_cutting) return runCutting(cli, options, progress);
  if (!options.tools.names.empty()) return runTools(cli, options, progress);
  if (options.bench.scenario.empty())
    for (const char* name : {"--chart", "--cache"})
      if (cli.count(name) > 0) throw UsageError(std::string(name) + " is for --scenario, --compare-cutting and --compare-tools");
  return options.bench.scenario.empty() ? runPlay(cli, options, progress) : runBench(cli, options, progress);
}

int runProgram(std::vector<std::string> words) {
  CLI::App cli{"Plays a scene of sphere-trees with a haptic device, a simulated hand or a recorded path; measures stability."};
  cli.formatter(std::make_shared<HelpFormatter>());
  Options options;
  addOptions(cli, options);
  try {
    if (wroteReference(cli, words, kGenerator)) return kExitOk;
    refuseEmptyWords(words);
    const bool is_bare = words.empty();
    std::reverse(words.begin(), words.end());  // as the parser takes them
    cli.parse(std::move(words));
    // The parser makes a path of the bytes one by one, also where a path is UTF-16.
    PlaySettings& play = options.play;
    for (std::filesystem::path* path :
         {&play.scene, &play.trajectory, &play.record, &options.bench.out, &options.bench.cache, &options.bench.chart, &options.measures,
          &options.view.replay, &options.view.compare, &options.view.picture})
      *path = formats::toPath(std::string(path->native().begin(), path->native().end()));
    if (is_bare) {
      options.view.view = canShowWindow();
      if (!options.view.view) std::fprintf(stderr, "haptic-player: %s\n", whyNoWindow());
    }
    return run(cli, options);
  } catch (const CLI::Success& help) {
    return cli.exit(help);
  } catch (const CLI::ParseError& error) {
    const std::string mistake = unknownWord(cli, "", kProgram);
    return explain(kProgram, kExitUsage, mistake.empty() ? explained(error) + ". See haptic-player --help." : mistake);
  } catch (const view::ViewError& error) {
    return explain(kProgram, kExitFile, error.what());
  } catch (const device::DeviceError& error) {
    return explain(kProgram, kExitFile, error.what());
  }
}

}  // namespace
}  // namespace spheretree::player

int main(int argc, char** argv) {
  return spheretree::tool::runAndExplain(spheretree::player::kProgram,
                                         [&] { return spheretree::player::runProgram(spheretree::tool::commandLine(argc, argv)); });
}
