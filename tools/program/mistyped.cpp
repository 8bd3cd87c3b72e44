// SPDX-License-Identifier: GPL-3.0-or-later
#include "mistyped.h"

#include <algorithm>
#include <charconv>
#include <vector>

#include "program_end.h"
#include "spheretree/formats/nearest_word.h"

namespace spheretree::tool {
namespace {

std::string unknownOption(const CLI::App& app, const std::string& word, const std::string& of) {
  std::vector<std::string> known;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) known.push_back(name);
  const std::string name = word.substr(0, word.find('='));
  const auto nearest = name.starts_with("--") ? formats::nearestWord(std::string_view(name).substr(2), known) : std::nullopt;
  return "unknown option '" + name + "'" + of + (nearest ? "; the nearest is '--" + std::string(*nearest) + "'." : ".");
}

}  // namespace

std::string unknownWord(const CLI::App& app, const std::string& of, const std::string& command) {
  const std::vector<std::string> left = app.remaining();
  if (left.empty() || (left.size() == 1 && left[0] == "--")) return {};
  const std::string see = " See " + command + " --help.";
  const auto dashes = std::find(left.begin(), left.end(), "--");
  const auto option = std::find_if(left.begin(), dashes, [](const std::string& w) { return w.size() >= 2 && w[0] == '-'; });
  if (option != dashes) return unknownOption(app, *option, of) + see;
  const std::string& extra = left[left.front() == "--" && left.size() > 1 ? 1 : 0];
  if (dashes != left.end() && extra.starts_with('-'))
    return "unexpected argument '" + extra + "'" + of + ": after -- every word is a file name. Put the options before it." + see;
  return "unexpected argument '" + extra + "'" + of + "." + see;
}

void refuseEmptyWords(const std::vector<std::string>& words) {
  if (std::find(words.begin(), words.end(), "") != words.end())
    throw UsageError("an argument is an empty text. Leave it out, or check the variable that it comes from.");
}

std::string explained(const CLI::ParseError& error) {
  const std::string text = error.what();
  const std::string name = text.substr(0, text.find(':'));
  if (text.find("At Most 1 required") != std::string::npos) return name + " is given more than once; give it once";
  const std::size_t missing = text.find(" required ");
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) && missing != std::string::npos) {
    if (const std::size_t got = text.find(" but received "); got != std::string::npos) {  // "NAME: At least 3 required but ..."
      const std::size_t word = text.rfind(' ', missing - 1) + 1;
      return name + " needs " + text.substr(word, missing - word) + " values, and got " + text.substr(got + 14);
    }
    const std::string kind = text.substr(missing + 10, text.find(' ', missing + 10) - missing - 10);
    return name + " needs a value" + (kind.empty() ? "" : " (" + kind + ")");
  }
  const std::size_t excludes = text.find(" excludes ");
  if (excludes != std::string::npos) return text.substr(0, excludes) + " and " + text.substr(excludes + 10) + " do not go together";
  const std::size_t converts = text.find("Could not convert: ");
  if (converts != std::string::npos) {
    const std::string rest = text.substr(converts + 19);  // "NAME = VALUE"
    const std::size_t equals = rest.find(" = ");
    if (equals != std::string::npos) return rest.substr(0, equals) + ": " + rest.substr(equals + 3) + " is not a number that fits here";
  }
  return text;
}

std::function<std::string(const std::string&)> numberIn(double smallest, double largest) {
  return [smallest, largest](const std::string& text) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc() && end == text.data() + text.size() && value >= smallest && value <= largest)
      return std::string();  // excludes NaN
    char range[64];
    std::snprintf(range, sizeof range, " is not a number from %.9g to %.9g", smallest, largest);
    return text + range;
  };
}

}  // namespace spheretree::tool
