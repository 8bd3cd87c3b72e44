// SPDX-License-Identifier: GPL-3.0-or-later
// Serves a device to another program, by spheretree.device/1.
#pragma once

#include <cstdint>

#include "run/play.h"

namespace spheretree::player {

/// Until the device ends, `settings.seconds` are over or a stop is requested; the forces that the client asks for pass
/// the safety rules here, too. Prints the address on stdout first. Without a trajectory the simulated hand rests.
/// @throws device::DeviceError, formats::FileError, formats::FormatError
void serveDevice(const PlaySettings& settings, std::uint16_t port);

}  // namespace spheretree::player
