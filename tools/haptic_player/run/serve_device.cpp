// SPDX-License-Identifier: GPL-3.0-or-later
#include "run/serve_device.h"

#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>

#include "spheretree/device/device_server.h"
#include "spheretree/device/emergency_stop.h"

namespace spheretree::player {

void serveDevice(const PlaySettings& settings, std::uint16_t port) {
  const std::unique_ptr<device::Device> device = openDeviceOf(settings);
  device::DeviceServer server(port, settings.open.allow_remote, device->info());
  const device::EmergencyStop emergency_stop;
  device->start(server, safetyOf(settings), device::Clock::Real);
  std::printf("%s is served at net:127.0.0.1:%u\n", device->info().model.c_str(), unsigned{server.port()});
  std::fflush(stdout);
  const auto begin = std::chrono::steady_clock::now();
  for (device::DeviceStatus status; (status = device->status()).phase == device::Phase::Running;) {
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
    if (settings.seconds && spent.count() >= *settings.seconds) break;
    // The forces went off when the last client left; for the next one they return through guard and ramp.
    if ((status.safety & device::kForcesOff) && server.hasClient()) device->rearm();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const device::DeviceStatus last = device->status();
  device->stop();
  if (last.phase == device::Phase::Failed)
    throw device::DeviceError(last.fault, device->info().model + " failed while it was served (code " + std::to_string(last.vendor_code) +
                                              "). Check its cable and power, then start again");
}

}  // namespace spheretree::player
