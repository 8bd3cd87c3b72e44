// SPDX-License-Identifier: GPL-3.0-or-later
// A self-contained HTML file: style, scripts, charts and the data of the 3D view. It opens from disk, and its content
// policy forbids every request.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace spheretree::tool {

using Json = nlohmann::ordered_json;

/// The data for the scripts of a page: one JSON object, and the arrays that it refers to.
class PageData {
 public:
  Json root = Json::object();
  /// Adds an array and returns a reference to put into `root`; page.js turns it into a typed array.
  Json add(std::span<const std::uint8_t> values) { return append("u8", values.data(), values.size(), 1); }
  Json add(std::span<const std::uint16_t> values) { return append("u16", values.data(), values.size(), 2); }
  Json add(std::span<const std::uint32_t> values) { return append("u32", values.data(), values.size(), 4); }
  Json add(std::span<const float> values) { return append("f32", values.data(), values.size(), 4); }
  /// Length of the JSON (u32), JSON, arrays; deflated, then base64.
  std::string packed() const;

 private:
  Json append(const char* type, const void* values, std::size_t count, std::size_t width);
  std::vector<std::byte> arrays_;
};

/// zlib at its highest level, then base64.
std::string deflatedBase64(std::string_view bytes);

/// A table whose columns are sorted by a click on their heads. Cells are HTML; the first cell of a row is its head. If
/// a row has fewer cells than the table, its last cell spans the rest of the width, and its text wraps. Numbers of a
/// column are aligned at the decimal point; columns without a number are set left.
struct HtmlTable {
  std::string caption;
  std::vector<std::string> heads;
  std::vector<std::vector<std::string>> rows;
  std::string html() const;
};

class Page {
 public:
  /// `lead`: the summary, HTML.
  Page(std::string title, std::string lead) : title_(std::move(title)), lead_(std::move(lead)) {}
  /// `body`: HTML. Sections appear in the order in which they are added, and make the table of contents.
  void addSection(std::string id, std::string heading, std::string body);
  PageData data;
  /// `scripts` follow page.js, in their order. Without any script, three.js and the data are left out.
  std::string html(std::span<const std::string_view> scripts) const;

 private:
  struct Section {
    std::string id, heading, body;
  };
  std::string title_, lead_;
  std::vector<Section> sections_;
};

}  // namespace spheretree::tool
