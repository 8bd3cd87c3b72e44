// SPDX-License-Identifier: Apache-2.0
// Opens a device that people hold, by its name. Nothing of the vendors is needed for a build: docs/device.md
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "spheretree/device/device.h"
#include "spheretree/device/phantom_device.h"

namespace spheretree::device {

struct OpenSettings {
  PhantomSettings phantom;
  std::string haply_host = "127.0.0.1:10001";  // address and port of the vendor's service
  std::string haply_device;                    // its device_id; empty: the first one
  std::string dhd_library;                     // path of the vendor's library; empty: libdhd.so or one of its known versions
  bool allow_remote = false;                   // also addresses of other machines, from which anyone could send forces
};

/// Whether openDevice() knows the name: haply (an Inverse3), dhd (Force Dimension and Novint Falcon), phantom, or
/// net:HOST:PORT (a device that another program serves by spheretree.device/1).
bool isDeviceName(std::string_view name) noexcept;

/// @throws DeviceError with a sentence that says what to do
std::unique_ptr<Device> openDevice(std::string_view name, const OpenSettings& settings);

}  // namespace spheretree::device
