// SPDX-License-Identifier: GPL-3.0-or-later
// make_scans FOLDER [PROPERTY...]: writes the sample mouth as labelled intraoral scans. The same meshes on every
// machine, byte for byte.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>

#include "mouth.h"
#include "mouth_files.h"
#include "program_end.h"
#include "run_files.h"
#include "scan.h"
#include "spheretree/formats/file_io.h"

namespace {

using namespace spheretree;

/// Properties such as "noise=0.02".
samples::ScanSettings scanSettings(int argc, char** argv) {
  samples::ScanSettings settings;
  const std::map<std::string, std::function<void(const std::string&)>> known{
      {"edge", [&](const std::string& value) { settings.edge_mm = std::stod(value); }},
      {"noise", [&](const std::string& value) { settings.noise_mm = std::stod(value); }},
      {"seed", [&](const std::string& value) { settings.seed = std::stoull(value); }},
      {"holes", [&](const std::string& value) { settings.holes = std::stoi(value); }},
      {"missing", [&](const std::string& value) { settings.missing_fdi = std::stoi(value); }},
      {"crowding", [&](const std::string& value) { settings.crowding_mm = std::stod(value); }},
      {"double", [&](const std::string&) { settings.double_layer = true; }},
      {"supernumerary", [&](const std::string&) { settings.supernumerary = true; }},
      {"braces", [&](const std::string&) { settings.braces = true; }},
      {"jagged", [&](const std::string&) { settings.jagged = true; }},
      {"all-faces", [&](const std::string&) { settings.hidden_removed = false; }}};
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    const std::size_t equals = std::min(word.find('='), word.size());
    const auto found = known.find(word.substr(0, equals));
    if (found == known.end()) throw std::invalid_argument(word + " is no property of a scan");
    try {
      found->second(word.substr(std::min(equals + 1, word.size())));
    } catch (const std::logic_error&) {  // of std::stod and the like
      throw std::invalid_argument(word + " needs a number: " + found->first + "=NUMBER");
    }
  }
  if (!(settings.edge_mm >= 0.05 && settings.edge_mm <= 2)) throw std::invalid_argument("edge is a length from 0.05 to 2 mm");
  return settings;
}

void writeScans(const std::filesystem::path& folder, samples::ScanSettings settings) {
  const samples::Mouth mouth = samples::makeMouth();
  for (const bool upper : {true, false}) {
    settings.upper = upper;
    const std::string name = upper ? "upper" : "lower";
    const samples::SampleScan scan = samples::makeScan(mouth, settings);
    std::string mesh = samples::objText({{"", &scan.mesh}}, "Scan of the " + name + " jaw");
    formats::writeWhole(folder / (name + ".obj"), mesh.erase(mesh.find("g \n"), 3));
    formats::writeWhole(folder / (name + ".json"), samples::labelsText(scan, "sample", upper));
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const bool force = argc > 1 && std::string(argv[1]) == "--force";
  argc -= force, argv += force;
  const std::string first = argc > 1 ? argv[1] : "";
  const bool help = first == "--help" || first == "-h";
  if (help || first.empty() || first[0] == '-') {
    std::fputs(
        "Usage: make_scans FOLDER [edge=MM] [noise=MM] [seed=N] [holes=N] [missing=FDI] [crowding=MM] [double] [supernumerary] "
        "[braces] [jagged] [all-faces]\nWrites the sample mouth as labelled scans: upper.obj, upper.json, lower.obj, lower.json.\n"
        "With --force as the first word, files that were edited or came from elsewhere are replaced.\n",
        help ? stdout : stderr);
    return help ? 0 : 2;
  }
  const samples::ScanSettings settings = scanSettings(argc, argv);
  const builder::Progress progress;
  const tool::RunFiles files(progress, "make_scans", force);
  formats::makeFolder(first);
  for (const char* name : {"upper.obj", "upper.json", "lower.obj", "lower.json"}) files.willMake(std::filesystem::path(first) / name);
  writeScans(first, settings);
  return 0;
} catch (const tool::UsageError& error) {
  return tool::explain("make_scans", tool::kExitUsage, error.what());
} catch (const std::exception& error) {
  std::fprintf(stderr, "make_scans: %s\n", error.what());
  return 3;
}
