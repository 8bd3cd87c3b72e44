// SPDX-License-Identifier: Apache-2.0
#include "tree/skin_json.h"

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>

namespace spheretree::formats {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// "[a,b,...]" of the texts of `count` records, with as many on a line as fit into 120 characters.
template <class RecordText>
std::string arrayOf(std::size_t count, RecordText&& recordText) {
  constexpr std::size_t kMaxColumns = 120;
  std::string text = "[", line;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string record = recordText(i) + (i + 1 < count ? "," : "");
    if (line.empty() || line.size() + record.size() > kMaxColumns) {
      text += line;
      line = "\n  ";
    }
    line += record;
  }
  return text + line + "]";
}

std::string nodesOf(const SearchTree& search) {
  return arrayOf(search.inner.size(), [&](std::size_t i) {
    const Sphere& s = search.inner[i];
    return OrderedJson::array({s.x, s.y, s.z, s.radius, search.inner_children[i], search.item_children[i]}).dump();
  });
}

JsonElement record(const JsonElement& array, std::size_t index, std::size_t size) {
  const JsonElement element = array.item(index);
  if (element.size() != size) element.fail("does not have " + std::to_string(size) + " numbers");
  return element;
}

template <class Number>
Number whole(const JsonElement& element) {
  return static_cast<Number>(element.integer(std::numeric_limits<Number>::min(), std::numeric_limits<Number>::max()));
}

void readNodes(const JsonElement& nodes, SearchTree& search) {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const JsonElement e = record(nodes, i, 6);
    search.inner.push_back({e.item(0).smallNumber(), e.item(1).smallNumber(), e.item(2).smallNumber(), e.item(3).smallNumber()});
    search.inner_children.push_back(whole<std::uint8_t>(e.item(4)));
    search.item_children.push_back(whole<std::uint8_t>(e.item(5)));
  }
}

PackedNormal readNormal(const JsonElement& e, std::size_t first) {
  return {whole<std::int16_t>(e.item(first)), whole<std::int16_t>(e.item(first + 1))};
}

}  // namespace

std::string writeSearchJson(const SearchTree& search) {
  return "{\"inner\": " + nodesOf(search) +
         ",\n  \"item\": " + arrayOf(search.item.size(), [&](std::size_t i) { return std::to_string(search.item[i]); }) + "}";
}

std::string writeSkinJson(const Skin& skin) {
  OrderedJson head;
  head["low_mm"] = skin.low;
  head["step_mm"] = skin.step;
  head["offset_step_mm"] = skin.offset_step;
  head["tolerance_mm"] = skin.tolerance;
  head["mesh_distance_mm"] = skin.mesh_distance;
  head["crease_angle_rad"] = skin.crease_angle;
  std::string text = head.dump();
  text.pop_back();  // removes the brace, which follows after the arrays
  text += ",\n  \"triangles\": " + arrayOf(skin.triangles.size(), [&](std::size_t i) {
            const SkinTriangle& t = skin.triangles[i];
            return OrderedJson::array({t.vertex[0], t.vertex[1], t.vertex[2], t.edge[0], t.edge[1], t.edge[2]}).dump();
          });
  text += ",\n  \"vertices\": " + arrayOf(skin.vertices.size(), [&](std::size_t i) {
            const SkinVertex& v = skin.vertices[i];
            return OrderedJson::array({v.position[0], v.position[1], v.position[2], v.normal[0], v.normal[1]}).dump();
          });
  text += ",\n  \"edges\": " + arrayOf(skin.edges.size(), [&](std::size_t i) {
            const SkinEdge& e = skin.edges[i];
            return OrderedJson::array({e.offset[0], e.offset[1], e.offset[2], e.is_sharp, e.normal[0], e.normal[1]}).dump();
          });
  return text + ",\n  \"inner\": " + nodesOf(skin.search) + "}";
}

SearchTree readSearchJson(const JsonElement& element) {
  SearchTree search;
  readNodes(element.at("inner"), search);
  const JsonElement item = element.at("item");
  for (std::size_t i = 0; i < item.size(); ++i) search.item.push_back(whole<std::uint16_t>(item.item(i)));
  return search;
}

Skin readSkinJson(const JsonElement& element) {
  Skin skin;
  const JsonElement low = element.at("low_mm");
  if (low.size() != 3) low.fail("is not [x, y, z]");
  for (std::size_t axis = 0; axis < 3; ++axis) skin.low[axis] = low.item(axis).smallNumber();
  skin.step = element.at("step_mm").smallNumber();
  skin.offset_step = element.at("offset_step_mm").smallNumber();
  skin.tolerance = element.at("tolerance_mm").smallNumber();
  skin.mesh_distance = element.at("mesh_distance_mm").smallNumber();
  skin.crease_angle = element.at("crease_angle_rad").smallNumber();
  const JsonElement triangles = element.at("triangles"), vertices = element.at("vertices"), edges = element.at("edges");
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const JsonElement e = record(triangles, i, 6);
    SkinTriangle& t = skin.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) t.vertex[k] = whole<std::uint16_t>(e.item(k)), t.edge[k] = whole<std::uint16_t>(e.item(3 + k));
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const JsonElement e = record(vertices, i, 5);
    SkinVertex& v = skin.vertices.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis) v.position[axis] = whole<std::uint32_t>(e.item(axis));
    v.normal = readNormal(e, 3);
  }
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const JsonElement e = record(edges, i, 6);
    SkinEdge& edge = skin.edges.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis) edge.offset[axis] = whole<std::int8_t>(e.item(axis));
    edge.is_sharp = whole<std::uint8_t>(e.item(3));
    edge.normal = readNormal(e, 4);
  }
  readNodes(element.at("inner"), skin.search);
  return skin;
}

std::string writeHullsJson(const Hulls& hulls) {
  OrderedJson head;
  head["overhang_bound_mm"] = hulls.overhang_bound;
  head["count"] = hulls.count;
  std::string text = head.dump();
  text.pop_back();  // removes the brace, which follows after the arrays
  text += ",\n  \"balls\": " + arrayOf(hulls.balls.size(), [&](std::size_t i) {
            const Sphere& s = hulls.balls[i];
            return OrderedJson::array({s.x, s.y, s.z, s.radius}).dump();
          });
  text +=
      ",\n  \"parts\": " + arrayOf(hulls.parts.size(), [&](std::size_t i) {
        const HullPart& part = hulls.parts[i];
        return OrderedJson(std::vector<std::uint16_t>(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(ballCount(part)))).dump();
      });
  return text + ",\n  \"search\": " + writeSearchJson(hulls.search) + "}";
}

Hulls readHullsJson(const JsonElement& element) {
  Hulls hulls;
  hulls.overhang_bound = element.at("overhang_bound_mm").smallNumber();
  hulls.count = whole<std::uint32_t>(element.at("count"));
  const JsonElement balls = element.at("balls"), parts = element.at("parts");
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const JsonElement e = record(balls, i, 4);
    hulls.balls.push_back({e.item(0).smallNumber(), e.item(1).smallNumber(), e.item(2).smallNumber(), e.item(3).smallNumber()});
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const JsonElement e = parts.item(i);
    if (e.size() < 1 || e.size() > 3) e.fail("does not have 1 to 3 balls");
    HullPart& part = hulls.parts.emplace_back(HullPart{kNoHullBall, kNoHullBall, kNoHullBall});
    for (std::size_t k = 0; k < e.size(); ++k) part[k] = whole<std::uint16_t>(e.item(k));
  }
  hulls.search = readSearchJson(element.at("search"));
  return hulls;
}

}  // namespace spheretree::formats
