// SPDX-License-Identifier: GPL-3.0-or-later
// Messages about errors in a command line, since the messages of the parser are not meant for users.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace spheretree::tool {

/// The message about a word that `app` did not accept: an unknown option, with the nearest known one if one is close,
/// or an additional argument. Empty if every word was accepted. `of`: for example " of build"; `command`: the command
/// whose --help has details.
std::string unknownWord(const CLI::App& app, const std::string& of, const std::string& command);

/// @throws UsageError for an empty word, such as the value of an unset variable.
void refuseEmptyWords(const std::vector<std::string>& words);

/// The message of `error` about known options, as one sentence.
std::string explained(const CLI::ParseError& error);

/// For CLI::Option::check(): a finite number from `smallest` to `largest`.
std::function<std::string(const std::string&)> numberIn(double smallest, double largest);

}  // namespace spheretree::tool
