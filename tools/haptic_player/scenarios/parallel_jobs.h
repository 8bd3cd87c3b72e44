// SPDX-License-Identifier: GPL-3.0-or-later
// Runs the scenarios on several threads.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>

#include "scenarios/scenario.h"
#include "work_progress.h"

namespace spheretree::player {

/// Work that is independent of all other jobs, apart from the bodies, which they share.
struct Job {
  std::string name;  // shown while it runs
  std::function<void(ScenarioContext&)> run;
};

/// Runs the jobs on `threads` threads, which begin them in their order; each thread has a context of its own, with the
/// bodies and settings of `context`. `done(i)` is called on the calling thread, in the order of the jobs, once job i
/// and all before it have ended. After an exception, or when `progress` is cancelled, no job begins any more, and those
/// that run are cancelled. @throws builder::Cancelled; what a job or `done` throws
void runJobs(std::span<const Job> jobs, const ScenarioContext& context, int threads, tool::WorkProgress& progress,
             const std::function<void(std::size_t)>& done = {});

}  // namespace spheretree::player
