// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/simulated_device.h"

#include <gtest/gtest.h>
