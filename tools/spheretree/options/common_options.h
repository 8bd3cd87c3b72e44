// SPDX-License-Identifier: GPL-3.0-or-later
// Options that several verbs share: each with one range, one default and one help text.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

namespace spheretree::tool {

/// --unit; `unit` stays empty if it is not given. formats::unitInMm() converts it to mm.
void addUnit(CLI::App& app, std::string& unit);

/// --spheres-unit; `unit` stays empty if it is not given.
void addSpheresUnit(CLI::App& app, std::string& unit);
std::optional<double> spheresUnit(const std::string& unit);  // [mm]; for robot::readSphereFile()

/// --parts, for choosePart().
void addParts(CLI::App& app, std::string& parts);

/// --levels and --branching.
void addTreeSize(CLI::App& app, int& levels, int& branching);

/// --seed; `of`: what the random numbers choose.
void addSeed(CLI::App& app, std::uint64_t& seed, const std::string& of);

/// --threads.
void addThreads(CLI::App& app, int& threads);

}  // namespace spheretree::tool
