// SPDX-License-Identifier: GPL-3.0-or-later
// How a program ends: exit codes, and every failure as one line on stderr that names the program.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <stdexcept>
#include <string>

#include "spheretree/builder/progress.h"

namespace spheretree::tool {

enum ExitCode : int {
  kExitOk = 0,
  kExitInternal = 1,
  kExitUsage = 2,
  kExitFile = 3,           // or device: cannot be used
  kExitRefused = 4,        // input refused, with the reason
  kExitTargetMissed = 5,   // best result written
  kExitPartlyFailed = 6,   // of a batch
  kExitInterrupted = 130,  // Ctrl-C
};

/// Options that are fine one by one but not together, or not in this version. The program exits with 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What is built from this source tree calls itself so, in files too.
inline const std::string kGenerator = "spheretree " SPHERETREE_VERSION;

/// Says `message` on stderr and returns `code`.
int explain(const std::string& program, int code, const std::string& message);

/// Runs the program proper, flushes stdout, and turns whatever goes wrong into a message and an exit code.
int runAndExplain(const std::string& program, const std::function<int()>& run);

/// While one lives, the first Ctrl-C (or SIGTERM) cancels `progress`, so that nothing is left half done; the second ends the program.
class InterruptGuard {
 public:
  explicit InterruptGuard(builder::Progress& progress);
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
};

/// CLI11 names the first rule that is broken, often a missing argument, where the user mistyped an option: the sentence for the first
/// word among `app`'s leftovers that looks like one, with the nearest that there is; empty if there is none. `of`: " of VERB" or empty;
/// `command`: what to ask for help.
std::string unknownOption(const CLI::App& app, const std::string& of, const std::string& command);

}  // namespace spheretree::tool
