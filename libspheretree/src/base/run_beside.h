// SPDX-License-Identifier: GPL-3.0-or-later
// Two parts of a computation at the same time.
#pragma once

#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <exception>

#include "spheretree/builder/progress.h"

namespace spheretree::builder {

/// Calls `main()` on this thread, and `beside(part)` on another one or, if none is free, after it. An exception of
/// `main` cancels `part` and is thrown, otherwise that of `beside`. No exception passes through a task group: it would
/// make the loops of the other part end without having run, and that part would go on with their empty results.
template <class Main, class Beside>
void runBeside(const Progress& progress, Main&& main, Beside&& beside) {
  Progress part(&progress);
  std::exception_ptr fault;
  const auto caught = [](auto&& run) -> std::exception_ptr {
    try {
      run();
    } catch (...) {
      return std::current_exception();
    }
    return nullptr;
  };
  tbb::task_group group;
  group.run([&] { fault = caught([&] { beside(part); }); });
  // Isolated: while it waits for a loop of its own, it begins nothing that takes long.
  const std::exception_ptr main_fault = caught([&] { tbb::this_task_arena::isolate(main); });
  if (main_fault) part.cancel();
  group.wait();
  if (main_fault) std::rethrow_exception(main_fault);
  if (fault) std::rethrow_exception(fault);
}

}  // namespace spheretree::builder
