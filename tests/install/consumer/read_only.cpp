// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "spheretree/device/simulated_device.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace {

struct Nothing final : spheretree::device::Renderer {
  spheretree::device::Rendered render(const spheretree::device::DeviceState&) noexcept override { return {}; }
};

bool deviceRuns() {
  spheretree::device::SimulatedDevice device({});
  Nothing nothing;
  device.start(nothing, {}, spheretree::device::Clock::Stepped);
  return device.step();
}

}  // namespace

int main(int, char** argv) {
  const spheretree::SphereTree tree = spheretree::formats::readSphereTree(argv[1]);
  const std::string fault = spheretree::findFault(tree);
  std::printf("%d levels, %s\n", tree.levelCount(), fault.empty() ? "sound" : fault.c_str());
  return fault.empty() && tree.levelCount() == 3 && deviceRuns() ? 0 : 1;
}
