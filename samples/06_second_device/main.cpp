// SPDX-License-Identifier: Apache-2.0
// Two hands in one scene: two servo loops, each with a device of its own, in which the tool of the other is a moving
// body. Usage: second_device TOOL.stree [DEVICE DEVICE]      DEVICE: haply, dhd, phantom, net:HOST:PORT or simulated
#include <chrono>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "../05_engine/haptic_actor.h"

namespace {

constexpr double kApart = 200;  // between the two hands at the beginning [mm]

std::vector<char> bytesOf(const char* path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(std::string(path) + " cannot be opened: give the file of a tree");
  return {std::istreambuf_iterator<char>(file), {}};
}

/// A scene with the tool, and as its only object, which is body 1, the tool of the other hand.
void start(HapticActor& actor, const std::vector<char>& tool, const char* device, double x) {
  st_scene* const scene = st_scene_create();
  const double origin[3] = {0, 0, 0};
  const st_pose home = {{0, 0, 0}, {1, 0, 0, 0}};
  st_servo_options options = ST_SERVO_OPTIONS_INIT;
  options.device_in_world.position_mm[0] = x;
  const bool ok = st_scene_set_tool(scene, tool.data(), tool.size(), origin) == 0 &&
                  st_scene_add_object(scene, tool.data(), tool.size(), &home) == 0 && st_scene_set_body(scene, 0, 1) == 0;
  const std::string fault = ok ? "" : st_scene_error(scene);
  try {
    if (!ok) throw std::runtime_error(fault);
    actor.start(scene, device, options);
  } catch (...) {
    st_scene_destroy(scene);
    throw;
  }
  st_scene_destroy(scene);  // the servo has its own
}

int meet(int argc, char** argv) {
  if (argc != 2 && argc != 4) {
    std::fprintf(stderr, "usage: second_device TOOL.stree [DEVICE DEVICE]\n");
    return 2;
  }
  const std::vector<char> tool = bytesOf(argv[1]);
  HapticActor left, right;
  start(left, tool, argc == 4 ? argv[2] : "simulated", -kApart / 2);
  start(right, tool, argc == 4 ? argv[3] : "simulated", kApart / 2);
  double way = 0;
  for (int picture = 0; picture < 1500; ++picture) {
    std::this_thread::sleep_for(std::chrono::milliseconds(16));
    left.tick();
    right.tick();
    if (left.state().step == 0 || right.state().step == 0) continue;
    // Each sees the other's graphic tool: those never pass through each other by more than a picture's motion.
    left.move(1, right.state().graphic_tool);
    right.move(1, left.state().graphic_tool);
    const bool is_ready = ((left.state().safety | right.state().safety) & (ST_SERVO_START_GUARD | ST_SERVO_RAMP)) == 0;
    if (is_ready) way += 0.5;  // simulated hands come together; real ones do what they want
    left.moveHand({{-kApart / 2 + way, 0, 0}, {1, 0, 0, 0}});
    right.moveHand({{kApart / 2 - way, 0, 0}, {1, 0, 0, 0}});
    const double on_left = left.state().wrench.force_n[0], on_right = right.state().wrench.force_n[0];
    if (on_left > -0.3 || on_right < 0.3) continue;
    std::printf("they touch: %.2f N on the left hand, %.2f N on the right one\n", on_left, on_right);
    return 0;
  }
  std::printf("they did not meet\n");
  return 5;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return meet(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "second_device: %s\n", error.what());
    return 3;
  }
}
