// SPDX-License-Identifier: GPL-3.0-or-later
// "Did you mean ...?" for the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace spheretree::tool {

/// CLI11 names the first rule that is broken, often a missing argument, where the user mistyped an option: the sentence for the first
/// word among `app`'s leftovers that looks like one, with the nearest that there is; empty if there is none. `of`: " of VERB" or empty;
/// `command`: what to ask for help.
std::string unknownOption(const CLI::App& app, const std::string& of, const std::string& command);

}  // namespace spheretree::tool
