// SPDX-License-Identifier: GPL-3.0-or-later
// Long computations called from Python: without the GIL, with progress out and Ctrl-C in.
#pragma once

#include <pybind11/pybind11.h>

#include <functional>

#include "spheretree/builder/progress.h"

namespace spheretree::python {

/// Runs `work` on a thread of its own, without the GIL. Meanwhile this thread, which holds the GIL on entry, gives
/// Python its signals, and calls `callback(stage, fraction)` (or nothing, if it is None) at each stage and about 20
/// times a second. What either raises, as KeyboardInterrupt, cancels the work and is raised here; else what the work
/// throws is thrown.
void runInterruptibly(const pybind11::object& callback, const std::function<void(builder::Progress&)>& work);

}  // namespace spheretree::python
