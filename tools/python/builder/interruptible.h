// SPDX-License-Identifier: GPL-3.0-or-later
// Long computations called from Python: without the GIL, with progress reports and Ctrl-C.
#pragma once

#include <pybind11/pybind11.h>

#include <functional>

#include "spheretree/builder/progress.h"

namespace spheretree::python {

/// Runs `work` in a separate thread, without the GIL. Meanwhile this thread, which must hold the GIL on entry, handles
/// Python's signals and calls `callback(stage, fraction)` (unless it is None) at each stage and about 20 times a
/// second. An exception of either, such as KeyboardInterrupt, cancels the work and is raised here; otherwise an
/// exception of the work is thrown.
void runInterruptibly(const pybind11::object& callback, const std::function<void(builder::Progress&)>& work);

}  // namespace spheretree::python
