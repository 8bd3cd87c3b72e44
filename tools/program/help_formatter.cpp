// SPDX-License-Identifier: GPL-3.0-or-later
#include "help_formatter.h"

#include <sstream>

namespace spheretree::tool {

namespace {

constexpr std::size_t kWidth = 80, kColumn = 26, kVerbColumn = 12;

std::string labelOf(const CLI::Option& option, bool is_positional) {
  std::string label;
  if (is_positional) label = option.get_name(true, false);
  for (const std::string& name : option.get_snames())
    if (!is_positional) label += (label.empty() ? "-" : ", -") + name;
  for (const std::string& name : option.get_lnames())
    if (!is_positional) label += (label.empty() ? "--" : ", --") + name;
  const std::string type = option.get_type_name();
  if (option.get_type_size() != 0 && !is_positional) label += " " + type.substr(0, type.find(':'));
  return label;
}

// A label, and its text beside it from `column` on, or below a label that is too long.
std::string rowOf(std::string label, const std::string& text, std::size_t column) {
  if (label.size() + 2 > column)
    label += "\n" + std::string(column, ' ');
  else
    label.append(column - label.size(), ' ');
  return label + wrapped(text, kWidth, column) + "\n";
}

}  // namespace

std::string descriptionOf(const CLI::Option& option, bool is_positional) {
  if (option.get_positional() && !is_positional) return "In place of " + option.get_name(true, false);
  std::string text = option.get_description();
  if (const std::string value = option.get_default_str(); !value.empty() && text.find("default") == std::string::npos)
    text += "; default " + value;
  if (option.get_required() && !is_positional) text += "; required";
  return text;
}

std::string wrapped(const std::string& text, std::size_t width, std::size_t indent) {
  std::istringstream words(text);
  std::string out, word;
  std::size_t column = indent;
  while (words >> word) {
    if (column > indent && column + 1 + word.size() > width) {
      out += "\n" + std::string(indent, ' ');
      column = indent;
    }
    if (column > indent) out += " ", ++column;
    out += word;
    column += word.size();
  }
  return out;
}

HelpFormatter::HelpFormatter() {
  label("Positionals", "Arguments");
  label("SUBCOMMAND", "VERB");
}

std::string HelpFormatter::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const {
  std::string help = CLI::Formatter::make_help(app, std::move(name), mode);
  for (std::size_t at = help.find("\n\n\n"); at != std::string::npos; at = help.find("\n\n\n", at)) help.erase(at, 1);
  return help;
}

std::string HelpFormatter::make_option(const CLI::Option* option, bool is_positional) const {
  return rowOf("  " + labelOf(*option, is_positional), descriptionOf(*option, is_positional), kColumn);
}

std::string HelpFormatter::make_subcommand(const CLI::App* verb) const {
  return rowOf("  " + verb->get_name(), verb->get_description(), kVerbColumn);
}

std::string HelpFormatter::make_description(const CLI::App* app) const { return wrapped(app->get_description(), kWidth, 0) + "\n"; }

}  // namespace spheretree::tool
