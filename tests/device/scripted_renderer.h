// SPDX-License-Identifier: Apache-2.0
// A renderer that gives the answers of a test and keeps its calls; some poses.
#pragma once

#include <functional>
#include <vector>

#include "spheretree/device/device.h"
#include "support/random.h"

namespace spheretree::device::test {

struct Answer final : Renderer {
  std::function<Rendered(const DeviceState&)> answer = [](const DeviceState&) { return Rendered(); };
  std::vector<DeviceState> seen;
  Rendered render(const DeviceState& state) noexcept override {
    seen.push_back(state);
    return answer(state);
  }
};

inline std::vector<Configuration> somePoses(int count) {
  spheretree::test::Random random(3);
  std::vector<Configuration> poses;
  for (int n = 0; n < count; ++n) poses.push_back({random.inCube(1), rotationOf(random.inCube(1))});
  return poses;
}

}  // namespace spheretree::device::test
