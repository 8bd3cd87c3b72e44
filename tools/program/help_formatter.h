// SPDX-License-Identifier: GPL-3.0-or-later
// The text of --help, for 80 columns.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace spheretree::tool {

/// Names, kind of value and description of each option, wrapped. The description says range, choices and default, so
/// that the lists that CLI11 makes of its checks are left out. Give it to an app before its verbs are added.
class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter();
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
  std::string make_option(const CLI::Option* option, bool is_positional) const override;
  std::string make_subcommand(const CLI::App* verb) const override;
  std::string make_description(const CLI::App* app) const override;
};

/// What help and manual say of an option: its description, with a default that is not in it.
std::string descriptionOf(const CLI::Option& option, bool is_positional);

/// `text` in lines of at most `width` characters, where its words allow it; each but the first after `indent` blanks.
std::string wrapped(const std::string& text, std::size_t width, std::size_t indent);

}  // namespace spheretree::tool
