// SPDX-License-Identifier: Apache-2.0
// Devices of Force Dimension (omega, delta, sigma, lambda) and the Novint Falcon, through the vendor's library.
#pragma once

#include <string>

#include "links/dhd_api.h"
#include "spheretree/device/linked_device.h"

namespace spheretree::device {

class DhdLink final : public Link {
 public:
  /// Opens the first device. @throws DeviceError
  explicit DhdLink(const std::string& library);
  ~DhdLink() override;
  DhdLink(const DhdLink&) = delete;
  DhdLink& operator=(const DhdLink&) = delete;

  DeviceInfo info() const override;
  void begin() override;
  bool read(LinkState& state) noexcept override;
  void send(const Wrench& wrench) noexcept override;
  void end() noexcept override;

 private:
  std::string lastError() const;

  DhdApi api_;
  char id_ = -1;
  bool has_wrist_ = false;
  int failed_ = 0, warning_ = 0;  // results of calls
};

}  // namespace spheretree::device
