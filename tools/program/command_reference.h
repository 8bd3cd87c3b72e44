// SPDX-License-Identifier: GPL-3.0-or-later
// Manual page and shell completion of a program, generated from its options, so that they always agree.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace spheretree::tool {

/// The values of the option --completion.
inline const std::vector<std::string> kShells{"bash", "zsh", "fish"};

/// A script for a shell of kShells that completes verbs, options, their values if these are few, and otherwise file
/// names.
std::string completionScript(const CLI::App& app, const std::string& shell);

/// A page of section 1 for man(1): every verb and option with its help.
std::string manualPage(const CLI::App& app, const std::string& version);

/// If the words request one of these texts (`--completion SHELL` or `--manual`), writes it to stdout. `words` as in
/// argv, without the program's name. @throws UsageError for an unknown shell.
bool wroteReference(const CLI::App& app, const std::vector<std::string>& words, const std::string& version);

}  // namespace spheretree::tool
