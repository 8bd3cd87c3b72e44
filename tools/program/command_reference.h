// SPDX-License-Identifier: GPL-3.0-or-later
// Manual page and shell completion of a program, made from the options that it takes, so that they cannot differ.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace spheretree::tool {

/// For people: what the option --completion takes.
inline const std::vector<std::string> kShells{"bash", "zsh", "fish"};

/// A script that a shell of kShells reads: verbs, options, their values where these are few; else names of files.
std::string completionScript(const CLI::App& app, const std::string& shell);

/// A page of section 1 for man(1): every verb and option with its help.
std::string manualPage(const CLI::App& app, const std::string& version);

/// If the words ask for one of these texts, `--completion SHELL` or `--manual`, writes it to stdout. `words` as in
/// argv, without the program's name. @throws UsageError for an unknown shell.
bool wroteReference(const CLI::App& app, const std::vector<std::string>& words, const std::string& version);

}  // namespace spheretree::tool
