// SPDX-License-Identifier: GPL-3.0-or-later
#include "command_reference.h"

#include <algorithm>

#include "help_formatter.h"
#include "program_end.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

/// The options that --help shows, including positional arguments.
std::vector<const CLI::Option*> optionsOf(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return !option->get_group().empty(); });
}

/// The names of an option, such as "-o" and "--output".
std::vector<std::string> namesOf(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

bool isFlag(const CLI::Option& option) { return option.get_expected_max() == 0; }

/// The values that an option accepts, from the list in braces that CLI11 makes of IsMember; empty if it accepts any.
std::string valuesOf(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t open = type.find('{'), close = type.find('}');
  if (isFlag(option) || open == std::string::npos || close < open) return {};
  std::string words = type.substr(open + 1, close - open - 1);
  std::replace(words.begin(), words.end(), ',', ' ');
  return words;
}

std::string joined(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + word;
  return line;
}

std::string optionWords(const CLI::App& app) {
  std::vector<std::string> words;
  for (const CLI::Option* option : optionsOf(app))
    for (const std::string& name : namesOf(*option)) words.push_back(name);
  return joined(words);
}

std::vector<const CLI::App*> verbsOf(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::string verbWords(const CLI::App& app) {
  std::vector<std::string> words;
  for (const CLI::App* verb : verbsOf(app)) words.push_back(verb->get_name());
  if (!words.empty()) words.push_back("help");
  return joined(words);
}

std::string bashScript(const CLI::App& app) {
  const std::string name = app.get_name(), verbs = verbWords(app);
  std::string function = "_" + name;
  std::replace(function.begin(), function.end(), '-', '_');
  std::string values, options;
  const auto add = [&](const CLI::App& part, const std::string& verb) {
    options += "    '" + verb + "') words='" + optionWords(part) + "';;\n";
    for (const CLI::Option* option : optionsOf(part))
      if (const std::string words = valuesOf(*option); !words.empty())
        for (const std::string& spelling : namesOf(*option))
          values += "    '" + verb + " " + spelling + "') COMPREPLY=($(compgen -W '" + words + "' -- \"$cur\")); return;;\n";
  };
  add(app, "");
  std::string known;
  for (const CLI::App* verb : verbsOf(app)) {
    add(*verb, verb->get_name());
    known += (known.empty() ? "" : "|") + verb->get_name();
  }
  std::string out =
      "# Completion of " + name + " for bash\n" + function + "() {\n  local cur=${COMP_WORDS[COMP_CWORD]} verb= word words=\n";
  if (!known.empty())
    out += "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n    case $word in " + known + ") verb=$word; break;; esac\n  done\n";
  out += "  case \"$verb ${COMP_WORDS[COMP_CWORD-1]}\" in\n" + values + "  esac\n  case \"$verb\" in\n" + options + "  esac\n";
  out += "  if [[ $cur == -* ]]; then COMPREPLY=($(compgen -W \"$words\" -- \"$cur\")); return; fi\n";
  if (!known.empty()) out += "  if [[ -z $verb ]]; then COMPREPLY=($(compgen -W '" + verbs + "' -- \"$cur\")); return; fi\n";
  return out + "  compopt -o filenames 2>/dev/null\n  COMPREPLY=($(compgen -f -- \"$cur\"))\n}\ncomplete -F " + function + " " + name +
         "\n";
}

/// The first sentence of a help text, shown beside a completion.
std::string firstSentence(const std::string& text) {
  const std::size_t end = std::min(text.find(". "), text.find("; "));
  std::string line = text.substr(0, std::min(end, text.size()));
  line.erase(std::remove_if(line.begin(), line.end(), [](char c) { return c == '\'' || c == '\\' || c == '\n'; }), line.end());
  return line;
}

std::string fishScript(const CLI::App& app) {
  const std::string name = app.get_name();
  std::string out = "# Completion of " + name + " for fish\n";
  const auto add = [&](const CLI::App& part, const std::string& condition) {
    for (const CLI::Option* option : optionsOf(part)) {
      if (namesOf(*option).empty()) continue;
      out += "complete -c " + name + condition;
      for (const std::string& letter : option->get_snames()) out += " -s " + letter;
      for (const std::string& word : option->get_lnames()) out += " -l " + word;
      if (const std::string words = valuesOf(*option); !words.empty())
        out += " -x -a '" + words + "'";
      else if (!isFlag(*option))
        out += " -r";
      out += " -d '" + firstSentence(option->get_description()) + "'\n";
    }
  };
  const std::vector<const CLI::App*> verbs = verbsOf(app);
  add(app, verbs.empty() ? "" : " -n __fish_use_subcommand");
  for (const CLI::App* verb : verbs) {
    out += "complete -c " + name + " -n __fish_use_subcommand -f -a " + verb->get_name() + " -d '" +
           firstSentence(verb->get_description()) + "'\n";
    add(*verb, " -n '__fish_seen_subcommand_from " + verb->get_name() + "'");
  }
  return out;
}

/// Escapes text for troff, where a backslash, a hyphen, and a full stop at the start of a line have meanings.
std::string roff(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\')
      out += "\\e";
    else if (text[i] == '-')
      out += "\\-";
    else if ((text[i] == '.' || text[i] == '\'') && (i == 0 || text[i - 1] == '\n'))
      out += std::string("\\&") + text[i];
    else
      out += text[i];
  }
  return out;
}

/// Whether the program has this option, too: then the page describes it once, behind the verbs.
bool isOfEveryVerb(const CLI::App& app, const CLI::Option& option) {
  return app.get_parent() && !option.get_lnames().empty() && app.get_parent()->get_option_no_throw("--" + option.get_lnames()[0]);
}

/// Arguments first, then the groups of --help in its order, each after a heading: a request of troff.
std::string optionEntries(const CLI::App& app, const std::string& heading) {
  std::vector<const CLI::Option*> options = optionsOf(app);
  std::erase_if(options, [&](const CLI::Option* option) { return isOfEveryVerb(app, *option); });
  const std::vector<std::string> groups = app.get_groups();
  const auto placeOf = [&](const CLI::Option* option) {
    return option->get_positional() ? -1 : std::find(groups.begin(), groups.end(), option->get_group()) - groups.begin();
  };
  std::stable_sort(options.begin(), options.end(), [&](const auto* a, const auto* b) { return placeOf(a) < placeOf(b); });
  std::string out, group;
  for (const CLI::Option* option : options) {
    if (const std::string own = option->get_positional() ? "Arguments" : option->get_group(); own != group)
      out += heading + " " + roff(group = own) + "\n";
    std::string title;
    for (const std::string& name : namesOf(*option)) title += (title.empty() ? "" : ", ") + name;
    if (option->get_positional()) title = option->get_name(true, false) + (title.empty() ? "" : ", " + title);
    const std::string type = option->get_type_name(), plain = type.substr(0, type.find_first_of(":{"));
    if (!isFlag(*option) && !option->get_positional()) title += " " + plain;
    out += ".TP\n.B " + roff(title) + "\n" + roff(descriptionOf(*option, option->get_positional())) + "\n";
  }
  return out;
}

}  // namespace

std::string completionScript(const CLI::App& app, const std::string& shell) {
  if (shell == "fish") return fishScript(app);
  const std::string bash = bashScript(app);
  return shell == "bash" ? bash : "#compdef " + app.get_name() + "\nautoload -U +X bashcompinit && bashcompinit\n" + bash;
}

std::string manualPage(const CLI::App& app, const std::string& version) {
  const std::string name = app.get_name();
  const std::vector<const CLI::App*> verbs = verbsOf(app);
  std::string out =
      ".TH " + roff(name) + " 1 \"\" \"" + roff(version) + "\"\n.SH NAME\n" + roff(name) + " \\- " + roff(app.get_description()) + "\n";
  out += ".SH SYNOPSIS\n.B " + roff(name) + (verbs.empty() ? "\n[OPTION]... [SCENE]\n" : "\nVERB [OPTION]... FILE...\n");
  for (const CLI::App* verb : verbs)
    out += (verb == verbs.front() ? std::string(".SH VERBS\n") : std::string()) + ".SS " + roff(verb->get_name()) + "\n" +
           roff(verb->get_description()) + "\n" + optionEntries(*verb, ".PP\n.I") + ".PP\n.nf\n" + roff(verb->get_footer()) + "\n.fi\n";
  out += ".SH OPTIONS\n" + optionEntries(app, ".SS");
  return out + ".PP\n.nf\n" + roff(app.get_footer()) + "\n.fi\n";
}

bool wroteReference(const CLI::App& app, const std::vector<std::string>& words, const std::string& version) {
  if (words.size() == 1 && words[0] == "--manual") {
    writeResult(manualPage(app, version));
    return true;
  }
  if (words.empty() || words[0] != "--completion") return false;
  if (words.size() != 2 || std::find(kShells.begin(), kShells.end(), words[1]) == kShells.end())
    throw UsageError("--completion takes the name of a shell: bash, zsh or fish");
  writeResult(completionScript(app, words[1]));
  return true;
}

}  // namespace spheretree::tool
