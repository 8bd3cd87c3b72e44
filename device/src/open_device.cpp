// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/open_device.h"

#include "links/dhd_link.h"
#include "links/haply_link.h"
#include "links/net_address.h"
#include "links/net_link.h"
#include "spheretree/device/linked_device.h"

namespace spheretree::device {
namespace {

constexpr std::string_view kNet = "net:";

}  // namespace

bool isDeviceName(std::string_view name) noexcept {
  return name == "haply" || name == "dhd" || name == "phantom" || name.starts_with(kNet);
}

std::unique_ptr<Device> openDevice(std::string_view name, const OpenSettings& settings) {
  if (name == "phantom") return std::make_unique<PhantomDevice>(settings.phantom);
  if (name == "dhd") return std::make_unique<LinkedDevice>(std::make_unique<DhdLink>(settings.dhd_library));
  if (name == "haply")
    return std::make_unique<LinkedDevice>(std::make_unique<HaplyLink>(addressOf(settings.haply_host, settings.allow_remote, "haply"),
                                                                      settings.haply_host, settings.haply_device));
  if (name.starts_with(kNet)) {
    const std::string server(name.substr(kNet.size()));
    return std::make_unique<LinkedDevice>(
        std::make_unique<NetLink>(addressOf(server, settings.allow_remote, std::string(name)), std::string(name)));
  }
  throw DeviceError(DeviceFault::Refused, "there is no device '" + std::string(name) + "': give haply, dhd, phantom or net:HOST:PORT");
}

}  // namespace spheretree::device
