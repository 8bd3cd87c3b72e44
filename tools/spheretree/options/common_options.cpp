// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/common_options.h"

#include <charconv>

#include "spheretree/core/sphere_tree.h"
#include "spheretree/formats/mesh_file.h"

namespace spheretree::tool {

void addUnit(CLI::App& app, std::string& unit) {
  app.add_option("--unit", unit, "Unit of the numbers in the mesh file: mm, cm, m or in; default mm, and m for glTF")
      ->type_name("UNIT")
      ->check(CLI::IsMember({"mm", "cm", "m", "in"}));
}

void addSpheresUnit(CLI::App& app, std::string& unit) {
  app.add_option("--spheres-unit", unit,
                 "Unit of the numbers in a file of spheres: mm, cm, m or in; default: as the file states it, which lists of convert do, "
                 "else m")
      ->type_name("UNIT")
      ->check(CLI::IsMember({"mm", "cm", "m", "in"}));
}

std::optional<double> spheresUnit(const std::string& unit) { return unit.empty() ? std::nullopt : std::optional(formats::unitInMm(unit)); }

void addParts(CLI::App& app, std::string& parts) {
  app.add_option("--parts", parts,
                 "merge: all parts as one object; NAME: that part; #N: the connected component N, counted from 0 as by `check "
                 "--list-parts`; default merge")
      ->type_name("NAME");
}

void addTreeSize(CLI::App& app, int& levels, int& branching) {
  app.add_option("--levels", levels, "Levels of a tree, the root included, 2 to 6; default 4")
      ->type_name("N")
      ->check(CLI::Range(kMinLevels, kMaxLevels));
  app.add_option("--branching", branching, "Largest number of children of a node, 2 to 8; default 8")
      ->type_name("N")
      ->check(CLI::Range(kMinBranching, kMaxBranching));
}

void addSeed(CLI::App& app, std::uint64_t& seed, const std::string& of) {
  app.add_option("--seed", seed, "Seed of " + of + ", 0 to 2^64 - 1; default 1")
      ->type_name("N")
      ->check([](const std::string& text) {  // CLI11 would convert -1 to 2^64 - 1
        std::uint64_t value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        return error == std::errc() && end == text.data() + text.size() ? std::string()
                                                                        : text + " is not a whole number from 0 to 2^64 - 1";
      });
}

void addThreads(CLI::App& app, int& threads) {
  app.add_option("-j,--threads", threads,
                 "Number of threads, 0 to 1024; 0: one for each processor; default 0. The result does not depend on it")
      ->type_name("N")
      ->check(CLI::Range(0, 1024));
}

}  // namespace spheretree::tool
