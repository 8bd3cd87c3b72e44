// SPDX-License-Identifier: GPL-3.0-or-later
// What is wrong with a command line, in words of our own: the parser's are not meant for users.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace spheretree::tool {

/// Of a word that `app` did not take: an option that is unknown, with the nearest known one if one is close, or an
/// argument too many.
/// `of`: " of build"; `command`: whose --help tells more. Empty if every word was taken.
std::string unknownWord(const CLI::App& app, const std::string& of, const std::string& command);

/// @throws UsageError for a word that is empty, as that of a variable which is not set.
void refuseEmptyWords(const std::vector<std::string>& words);

/// What `error` says of options that are known, as one sentence.
std::string explained(const CLI::ParseError& error);

/// For CLI::Option::check(): a finite number from `least` to `most`.
std::function<std::string(const std::string&)> numberIn(double least, double most);

}  // namespace spheretree::tool
