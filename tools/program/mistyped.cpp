// SPDX-License-Identifier: GPL-3.0-or-later
#include "mistyped.h"

#include <algorithm>
#include <vector>

#include "spheretree/formats/nearest_word.h"

namespace spheretree::tool {

std::string unknownOption(const CLI::App& app, const std::string& of, const std::string& command) {
  std::vector<std::string> known;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  const std::vector<std::string> left = app.remaining();
  const auto word = std::find_if(left.begin(), left.end(), [](const std::string& w) { return w.size() >= 2 && w[0] == '-'; });
  if (word == left.end()) return {};
  const std::string name = word->substr(0, word->find('='));
  return "unknown option '" + name + "'" + of + "; the nearest is '" + std::string(formats::nearestWord(name, known)) + "'. See " +
         command + " --help.";
}

}  // namespace spheretree::tool
