// SPDX-License-Identifier: GPL-3.0-or-later
// The builder rounds by roundUp() of core.
#pragma once

#include "spheretree/core/rounding.h"
