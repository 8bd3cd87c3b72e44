// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/tree_json.h"

#include <limits>
#include <nlohmann/json.hpp>

#include "spheretree/formats/errors.h"
#include "text/json_element.h"
#include "tree/skin_json.h"

namespace spheretree::formats {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr const char* kTreeSchema = "spheretree.tree/1";

OrderedJson toJson(const Sphere& s) { return OrderedJson::array({s.x, s.y, s.z, s.radius}); }

Hash128 readHash(const JsonElement& e) {
  const std::string hex = e.text();
  Hash128 hash{};
  const auto digit = [&](char c) -> unsigned {
    if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
    if (c >= 'a' && c <= 'f') return static_cast<unsigned>(c - 'a') + 10;
    e.fail("is not 32 digits 0-9 a-f");
  };
  if (hex.size() != 2 * hash.size()) e.fail("is not 32 digits 0-9 a-f");
  for (std::size_t i = 0; i < hash.size(); ++i) hash[i] = static_cast<std::uint8_t>(digit(hex[2 * i]) << 4 | digit(hex[2 * i + 1]));
  return hash;
}

Sphere readSphere(const JsonElement& e) {
  if (e.size() != 4) e.fail("is not [x, y, z, radius]");
  Sphere s{};
  s.x = e.item(0).smallNumber();
  s.y = e.item(1).smallNumber();
  s.z = e.item(2).smallNumber();
  s.radius = e.item(3).smallNumber();
  return s;
}

Provenance readProvenance(const JsonElement& e) {
  Provenance p;
  p.builder = e.at("builder").text();
  p.quality = e.at("quality").text();
  p.generator = e.at("generator").text();
  p.unit_mm = e.at("unit_mm").number();
  p.diagonal_mm = e.at("diagonal_mm").number();
  p.volume_mm3 = e.at("volume_mm3").number();
  p.area_mm2 = e.at("area_mm2").number();
  p.tolerance_mm = e.at("tolerance_mm").number();
  if (e.has("work_overhang_mm")) p.work_overhang_mm = e.at("work_overhang_mm").smallNumber();
  p.triangle_count = e.at("triangle_count").whole(std::numeric_limits<std::uint64_t>::max());
  p.seed = e.at("seed").whole(std::numeric_limits<std::uint64_t>::max());
  p.mesh_hash = readHash(e.at("mesh_hash"));
  p.settings_hash = readHash(e.at("settings_hash"));
  return p;
}

}  // namespace

std::string writeTreeJson(const SphereTree& tree) {
  const Provenance& p = tree.provenance;
  OrderedJson head;
  head["schema"] = kTreeSchema;
  head["unit"] = "mm";
  head["branching"] = tree.branching;
  head["origin_mm"] = tree.origin_mm;
  head["provenance"] = {{"builder", p.builder},
                        {"quality", p.quality},
                        {"generator", p.generator},
                        {"unit_mm", p.unit_mm},
                        {"diagonal_mm", p.diagonal_mm},
                        {"volume_mm3", p.volume_mm3},
                        {"area_mm2", p.area_mm2},
                        {"tolerance_mm", p.tolerance_mm},
                        {"triangle_count", p.triangle_count},
                        {"seed", p.seed},
                        {"mesh_hash", toHex(p.mesh_hash)},
                        {"settings_hash", toHex(p.settings_hash)}};
  if (p.work_overhang_mm > 0) head["provenance"]["work_overhang_mm"] = p.work_overhang_mm;
  OrderedJson levels = OrderedJson::array();
  for (const LevelStatistics& s : tree.statistics) {
    OrderedJson level;
    level["spheres"] = s.sphere_count;
    level["overhang_bound_mm"] = s.overhang_bound == kUnproven ? OrderedJson(nullptr) : OrderedJson(s.overhang_bound);
    level["smallest_radius_mm"] = s.smallest_radius;
    level["largest_radius_mm"] = s.largest_radius;
    levels.push_back(std::move(level));
  }
  head["levels"] = std::move(levels);

  std::string text = head.dump(1);
  text.resize(text.size() - 2);  // removes "\n}", which follows after the nodes, one on each line
  text += ",\n \"nodes\": [\n";
  for (std::size_t i = 0; i < tree.nodeCount(); ++i) {
    OrderedJson node;
    node["cover"] = toJson(tree.cover[i]);
    node["child_count"] = tree.child_count[i];
    if (!tree.isLeaf(i)) {
      node["first_child"] = tree.first_child[i];
      node["bound"] = toJson(tree.bound[tree.bound_index[i]]);
    }
    text += "  " + node.dump() + (i + 1 < tree.nodeCount() ? ",\n" : "\n");
  }
  text += " ]";
  if (!tree.search.empty()) text += ",\n \"search\": " + writeSearchJson(tree.search);
  if (!tree.skin.empty()) text += ",\n \"skin\": " + writeSkinJson(tree.skin);
  if (!tree.hulls.empty()) text += ",\n \"hulls\": " + writeHullsJson(tree.hulls);
  return text + "\n}\n";
}

SphereTree parseTreeJson(std::string_view text, const std::string& name) {
  const JsonSource source{name, "a sphere-tree as JSON"};
  const nlohmann::json parsed = parseJson(text, source);
  const JsonElement root(parsed, "", source);
  if (const JsonElement schema = root.at("schema"); schema.text() != kTreeSchema)
    schema.fail(std::string("is not \"") + kTreeSchema + "\"");
  if (root.has("unit") && root.at("unit").text() != "mm") root.at("unit").fail("is not \"mm\"");

  SphereTree tree;
  tree.branching = static_cast<std::uint8_t>(root.at("branching").whole(kMaxBranching));
  if (root.has("origin_mm")) {
    const JsonElement origin = root.at("origin_mm");
    if (origin.size() != 3) origin.fail("is not [x, y, z]");
    for (std::size_t axis = 0; axis < 3; ++axis) tree.origin_mm[axis] = origin.item(axis).number();
  }
  if (root.has("provenance")) tree.provenance = readProvenance(root.at("provenance"));

  const JsonElement nodes = root.at("nodes");
  const std::size_t count = nodes.size();
  if (count < 1 || count > kMaxNodes) nodes.fail("has " + std::to_string(count) + " nodes, not 1 to " + std::to_string(kMaxNodes));
  for (std::size_t i = 0; i < count; ++i) {
    const JsonElement node = nodes.item(i);
    tree.cover.push_back(readSphere(node.at("cover")));
    tree.child_count.push_back(static_cast<std::uint8_t>(node.at("child_count").whole(kMaxBranching)));
    if (node.has("bound")) {
      if (tree.child_count.back() == 0) node.at("bound").fail("belongs to a node without children");
      tree.bound.push_back(readSphere(node.at("bound")));
    }
  }
  if (!linkNodes(tree)) nodes.fail("do not make one tree of at most 6 levels, breadth first, inner siblings ahead of leaves");
  for (std::size_t i = 0; i < count; ++i)
    if (nodes.item(i).has("first_child") && nodes.item(i).at("first_child").whole(kMaxNodes) != tree.first_child[i])
      nodes.item(i).at("first_child").fail("is not " + std::to_string(tree.first_child[i]) + ", the place of its children");
  for (std::size_t i = 0; i < count; ++i) {  // encloseDescendants() computes with these
    if (!(tree.cover[i].radius > 0)) nodes.item(i).at("cover").item(3).fail("is not above 0");
  }
  if (tree.bound.empty()) encloseDescendants(tree);
  if (root.has("levels")) {
    const JsonElement levels = root.at("levels");
    for (std::size_t i = 0; i < levels.size(); ++i) {
      const JsonElement level = levels.item(i);
      LevelStatistics s;
      s.sphere_count = static_cast<std::uint32_t>(level.at("spheres").whole(kMaxNodes));
      const JsonElement overhang = level.at("overhang_bound_mm");
      s.overhang_bound = overhang.isNull() ? kUnproven : overhang.smallNumber();
      s.smallest_radius = level.at("smallest_radius_mm").smallNumber();
      s.largest_radius = level.at("largest_radius_mm").smallNumber();
      tree.statistics.push_back(s);
    }
  } else {
    countLevels(tree);
  }
  if (root.has("search")) tree.search = readSearchJson(root.at("search"));
  if (root.has("skin")) tree.skin = readSkinJson(root.at("skin"));
  if (root.has("hulls")) tree.hulls = readHullsJson(root.at("hulls"));
  if (const std::string fault = findFault(tree); !fault.empty()) throw FormatError(name + ": " + fault + ". Export the tree again.");
  return tree;
}

}  // namespace spheretree::formats
