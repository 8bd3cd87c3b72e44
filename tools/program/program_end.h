// SPDX-License-Identifier: GPL-3.0-or-later
// How a program ends: exit codes, and every failure as one line on stderr with the name of the program.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>

#include "generator.h"
#include "spheretree/builder/progress.h"

namespace spheretree::tool {

enum ExitCode : int {
  kExitOk = 0,
  kExitInternal = 1,
  kExitUsage = 2,
  kExitFile = 3,           // a file or device cannot be used
  kExitRefused = 4,        // input refused, with the reason
  kExitTargetMissed = 5,   // the best result was written
  kExitPartlyFailed = 6,   // of a batch: some objects failed
  kExitInterrupted = 130,  // Ctrl-C
};

/// Options that are valid individually but not together, or not in this version. The program exits with 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Prints `message` as one line on stderr, with a full stop, and returns `code`.
int explain(const std::string& program, int code, const std::string& message);

/// Runs the program proper, flushes stdout, and turns every exception into a message and an exit code.
int runAndExplain(const std::string& program, const std::function<int()>& run);

/// While an InterruptGuard exists, the first Ctrl-C (or SIGTERM) cancels `progress`, so that the program can finish
/// cleanly; the second one ends the program. Signals within 0.3 s of the first are taken for the same Ctrl-C, which
/// `timeout` and other wrappers send twice.
class InterruptGuard {
 public:
  explicit InterruptGuard(builder::Progress& progress);
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
};

}  // namespace spheretree::tool
