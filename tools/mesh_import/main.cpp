// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree-import: converts a mesh file of a format that spheretree does not read itself to OBJ or PLY.
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "assimp_mesh.h"
#include "command_reference.h"
#include "generator.h"
#include "help_formatter.h"
#include "mistyped.h"
#include "program_end.h"
#include "run_files.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_writer.h"
#include "terminal.h"

namespace spheretree::mesh_import {
namespace {

using namespace tool;

const std::string kProgram = "spheretree-import";
constexpr rlim_t kMaxMemory = rlim_t{8} << 30;  // [bytes] of address space; files that need more are refused

struct Options {
  std::filesystem::path input, output;
  std::string unit;
  bool trusted = false;
};

int runImport(const Options& options) {
  if (!options.trusted)
    throw UsageError("Assimp's readers are not made for hostile files, which may crash them or worse. If you trust where " +
                     options.input.string() + " comes from, add --trusted");
  if (!options.unit.empty() && endingOf(options.input) == ".dae") throw UsageError("a DAE file says its unit itself. Leave --unit out");
  const rlimit limit{kMaxMemory, kMaxMemory};
  (void)::setrlimit(RLIMIT_AS, &limit);
  const RunFiles files;
  files.willRead(options.input);
  files.willWrite(options.output, {".obj", ".ply"}, "the mesh", false);
  const std::vector<std::byte> bytes = formats::readFile(options.input);
  const std::optional<double> unit = options.unit.empty() ? std::nullopt : std::optional(formats::unitInMm(options.unit));
  const formats::MeshFile file = readByAssimp(bytes, options.input, unit);
  const bool is_obj = endingOf(options.output) == ".obj";
  formats::writeWhole(options.output, is_obj ? formats::encodeObj(file.mesh) : formats::encodePly(file.mesh));
  if (isDash(options.output)) return kExitOk;
  for (const std::string& note : file.notes) say(kProgram + ": note: " + note);
  printResult("%s: %s, %s; one unit of the file was %g mm\n", plainText(options.output.string()).c_str(),
              counted(file.mesh.triangles.size(), "triangle").c_str(),
              counted(std::max<std::size_t>(file.mesh.part_names.size(), 1), "part").c_str(), file.unit_mm);
  return kExitOk;
}

int run(int argc, char** argv) {
  CLI::App cli{
      "Turns a mesh file of another format (3DS, 3MF, AMF, DAE, FBX, X3D and more, by Assimp) into OBJ or PLY in mm, which spheretree "
      "reads. For files that you trust.",
      kProgram};
  cli.formatter(std::make_shared<tool::HelpFormatter>());
  cli.footer("Example: spheretree-import jaw.fbx -o jaw.obj --trusted");
  Options options;
  cli.add_option("INPUT", options.input, "Mesh to read; its ending tells the format")->required()->type_name("FILE");
  cli.add_option("-o,--output", options.output, "Mesh to write, in mm: .obj, which keeps the names of parts, or .ply; - is PLY")
      ->required()
      ->type_name("FILE");
  cli.add_option("--unit", options.unit, "Unit of the file: mm, cm, m or in; default: as an FBX says, else mm; a DAE has its own")
      ->type_name("UNIT")
      ->check(CLI::IsMember({"mm", "cm", "m", "in"}));
  cli.add_flag("--trusted", options.trusted,
               "You trust where INPUT comes from. Needed, because Assimp's readers are not made for hostile files; they run in this "
               "program alone, read no other file, and have at most 8 GiB of memory");
  cli.set_help_flag("-h,--help", "Print this text");
  cli.set_version_flag("--version", kProgram + " " SPHERETREE_VERSION, "Print the version");
  try {
    if (wroteReference(cli, {argv + 1, argv + argc}, kGenerator)) return kExitOk;
    cli.parse(argc, argv);
    return runImport(options);
  } catch (const CLI::Success& help) {
    return cli.exit(help);
  } catch (const CLI::ParseError& error) {
    const std::string mistake = unknownWord(cli, "", kProgram);
    return explain(kProgram, kExitUsage, mistake.empty() ? explained(error) + ". See spheretree-import --help." : mistake);
  }
}

}  // namespace
}  // namespace spheretree::mesh_import

int main(int argc, char** argv) {
  return spheretree::tool::runAndExplain(spheretree::mesh_import::kProgram, [&] { return spheretree::mesh_import::run(argc, argv); });
}
