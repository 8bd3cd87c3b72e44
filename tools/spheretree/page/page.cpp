// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/page.h"

#include <zlib.h>

#include <bit>
#include <cstring>

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
  for (const std::string& head : heads) out += "<th scope=\"col\">" + head + "</th>";
  out += "</tr></thead><tbody>\n";
  for (const std::vector<std::string>& row : rows) {
    out += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) {
      const bool takes_rest = i > 0 && i + 1 == row.size() && row.size() < heads.size();
      const std::string cell = takes_rest ? "<td class=\"rest\" colspan=\"" + std::to_string(heads.size() - i) + "\">" : "<td>";
      out += (i == 0 ? "<th scope=\"row\">" : cell) + row[i] + (i == 0 ? "</th>" : "</td>");
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
