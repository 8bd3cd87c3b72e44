// SPDX-License-Identifier: GPL-3.0-or-later
#include "input/tree_input.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "program_end.h"
#include "run_files.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/sph_text.h"
#include "spheretree/formats/sphere_tree_file.h"
#include "spheretree/formats/tree_json.h"

namespace spheretree::tool {

namespace {

/// The kind of standard input, which has no extension.
std::string endingByContent(std::string_view text) {
  if (text.starts_with("\x89STREE")) return ".stree";
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && text[first] == '{' ? ".json" : ".sph";
}

}  // namespace

SphereTree readTree(const std::filesystem::path& path) {
  std::string ending = endingOf(path);
  if (!isDash(path) && ending != ".stree" && ending != ".soft" && ending != ".sph" && ending != ".json")
    throw UsageError(path.string() + ": the tree's name must end in .stree, .soft, .sph or .json.");
  constexpr std::uint64_t kMaxBytes = 64 << 20;  // a full tree takes less than 10 MB in any format
  const std::vector<std::byte> bytes = formats::readFile(path, kMaxBytes);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string name = formats::shownName(path);
  if (isDash(path)) ending = endingByContent(text);
  if (ending == ".stree" || ending == ".soft") return formats::parseSphereTree(bytes, name);
  return ending == ".sph" ? formats::parseSph(text, name) : formats::parseTreeJson(text, name);
}

SphereTree readSoftTree(const std::filesystem::path& path, Tissue& tissue) {
  if (!isDash(path) && endingOf(path) != ".soft")
    throw UsageError(path.string() + ": this needs a soft tree (.soft), as `spheretree soften` writes it.");
  SphereTree tree = formats::readSoftTree(path, tissue);
  if (tissue.empty())
    throw formats::FormatError(formats::shownName(path) + ": it contains no tissue. Make a soft tree with `spheretree soften`.");
  return tree;
}

std::string otherMeshWarning(const SphereTree& tree, const std::filesystem::path& tree_path, const TriangleMesh& mesh,
                             const std::filesystem::path& mesh_path) {
  const Hash128& made_of = tree.provenance.mesh_hash;
  if (made_of == Hash128{} || made_of == builder::meshHash(mesh)) return {};
  return formats::shownName(tree_path) + " was built from another mesh than " + formats::shownName(mesh_path) +
         " (or with another --unit, --parts or --repair). What is shown compares the two files as given.";
}

}  // namespace spheretree::tool
