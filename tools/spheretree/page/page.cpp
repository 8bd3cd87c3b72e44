// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/page.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>

#include "page/chart.h"
#include "page/embedded.h"

namespace spheretree::tool {
namespace {

static_assert(std::endian::native == std::endian::little, "the arrays of a page are little-endian");

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

std::string section(const std::string& id, const std::string& heading, const std::string& body) {
  return "<section id=\"" + id + "\" aria-labelledby=\"" + id + "-h\"><h2 id=\"" + id + "-h\">" + escaped(heading) + "</h2>\n" + body +
         "</section>\n";
}

/// The number that a cell begins with, markup aside; followed by nothing else, or by a mark such as a tick.
struct CellNumber {
  std::size_t end = 0;       // index behind its last digit
  std::size_t decimals = 0;  // digits behind the point
  bool has_point = false;
};

bool isDigit(char c) { return c >= '0' && c <= '9'; }

std::optional<CellNumber> numberIn(const std::string& cell) {
  std::size_t at = 0;
  while (at < cell.size() && cell[at] == '<') at = std::min(cell.find('>', at), cell.size() - 1) + 1;
  if (at < cell.size() && cell[at] == '-') ++at;
  if (at == cell.size() || !isDigit(cell[at])) return std::nullopt;
  CellNumber out;
  for (; at < cell.size() && (isDigit(cell[at]) || (cell[at] == '.' && !out.has_point)); ++at) {
    out.decimals += out.has_point;
    out.has_point = out.has_point || cell[at] == '.';
  }
  out.end = at;
  std::string rest;
  for (bool is_markup = false; at < cell.size(); ++at) {
    is_markup = is_markup || cell[at] == '<';
    if (!is_markup) rest += cell[at];
    if (cell[at] == '>') is_markup = false;
  }
  return rest.empty() || rest == " \u2713" || rest == " \u2717" ? std::optional(out) : std::nullopt;
}

/// How the cells of a column are set.
struct ColumnStyle {
  bool is_text = true;
  std::size_t decimals = 0;  // most of a number in it

  std::string open(const char* tag) const { return std::string("<") + tag + (is_text ? " class=\"text\">" : ">"); }
  /// The cell with the digits that its number lacks, which are not seen.
  std::string aligned(const std::string& cell) const {
    const auto number = numberIn(cell);
    if (!number || number->decimals == decimals) return cell;
    const std::string pad = (number->has_point ? "" : ".") + std::string(decimals - number->decimals, '0');
    return cell.substr(0, number->end) + "<i class=\"pad\" aria-hidden=\"true\">" + pad + "</i>" + cell.substr(number->end);
  }
};

ColumnStyle styleOf(const HtmlTable& table, std::size_t column) {
  ColumnStyle out;
  for (const std::vector<std::string>& row : table.rows) {
    if (column >= row.size() || (column + 1 == row.size() && row.size() < table.heads.size())) continue;
    const auto number = numberIn(row[column]);
    out.is_text = out.is_text && !number && row[column] != "\u2013";
    if (number) out.decimals = std::max(out.decimals, number->decimals);
  }
  return out;
}

}  // namespace

std::string deflatedBase64(std::string_view bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string out(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()),
                9) != Z_OK)
    throw std::bad_alloc();
  out.resize(size);
  return base64(out);
}

Json PageData::append(const char* type, const void* values, std::size_t count, std::size_t width) {
  arrays_.resize((arrays_.size() + 3) / 4 * 4);  // typed arrays need their alignment
  const std::size_t at = arrays_.size();
  arrays_.resize(at + count * width);
  if (count > 0) std::memcpy(arrays_.data() + at, values, count * width);
  return {{"type", type}, {"at", at}, {"count", count}};
}

std::string PageData::packed() const {
  std::string text = root.dump(-1, ' ', false, Json::error_handler_t::replace);  // names of files need not be UTF-8
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto length = static_cast<std::uint32_t>(text.size());
  std::string all(reinterpret_cast<const char*>(&length), 4);
  all += text;
  all.append(reinterpret_cast<const char*>(arrays_.data()), arrays_.size());
  return deflatedBase64(all);
}

std::string HtmlTable::html() const {
  constexpr std::size_t kTall = 40;  // number of rows from which the table scrolls separately
  std::string out = "<p class=\"caption\">" + escaped(caption) + "</p><div class=\"scroll" + (rows.size() > kTall ? " tall" : "") +
                    "\" tabindex=\"0\" role=\"region\" aria-label=\"" + escaped(caption) + "\"><table><thead><tr>";
  std::vector<ColumnStyle> columns;
  for (std::size_t i = 0; i < heads.size(); ++i) {
    columns.push_back(styleOf(*this, i));
    out += columns[i].open("th scope=\"col\"") + heads[i] + "</th>";
  }
  out += "</tr></thead><tbody>\n";
  for (const std::vector<std::string>& row : rows) {
    out += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) {
      const bool takes_rest = i > 0 && i + 1 == row.size() && row.size() < heads.size();
      const std::string cell =
          takes_rest ? "<td class=\"rest\" colspan=\"" + std::to_string(heads.size() - i) + "\">" : columns[i].open("td");
      out += (i == 0 ? "<th scope=\"row\">" : cell) + (takes_rest ? row[i] : columns[i].aligned(row[i])) + (i == 0 ? "</th>" : "</td>");
    }
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

void Page::addSection(std::string id, std::string heading, std::string body) {
  sections_.push_back({std::move(id), std::move(heading), std::move(body)});
}

std::string Page::html(std::span<const std::string_view> scripts) const {
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
      "img-src data:\">\n<link rel=\"icon\" href=\"data:,\">\n<title>" +
      escaped(title_) + "</title>\n<style>" + std::string(embedded::pageStyle()) + std::string(chartStyle()) +
      "</style>\n</head>\n<body>\n" + "<a class=\"skip\" href=\"#main\">Skip to the content</a>\n<header><h1>" + escaped(title_) +
      "</h1>\n<div class=\"lead\">" + lead_ + "</div>\n<nav aria-label=\"Contents\">";
  for (const Section& s : sections_) out += "<a href=\"#" + s.id + "\">" + escaped(s.heading) + "</a>";
  out += "</nav></header>\n<main id=\"main\">\n";
  for (const Section& s : sections_) out += section(s.id, s.heading, s.body);
  out += "</main>\n<footer>Made by spheretree " SPHERETREE_VERSION
         ". This file holds everything that it shows and makes no request.</footer>\n";
  if (!scripts.empty()) {
    out += "<script type=\"text/plain\" id=\"three\">" + deflatedBase64(embedded::three()) + "</script>\n";
    out += "<script type=\"text/plain\" id=\"data\">" + data.packed() + "</script>\n";
  }
  out += "<script>" + std::string(embedded::pageScript()) + "</script>\n";
  for (const std::string_view script : scripts) out += "<script>" + std::string(script) + "</script>\n";
  return out + "</body>\n</html>\n";
}

}  // namespace spheretree::tool
