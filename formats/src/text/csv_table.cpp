// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/csv_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <span>
#include <utility>

#include "spheretree/formats/errors.h"
#include "text/text_encoding.h"
#include "text/text_scan.h"

namespace spheretree::formats {
CsvTable::CsvTable(std::string_view text, std::string name) : name_(std::move(name)) {
  const std::span<const char> checked = asText(std::span<const char>(text.data(), text.size()), name_);
  rest_ = {checked.data(), checked.size()};
  line_end_ = rest_.find('\n') != std::string_view::npos ? '\n' : '\r';  // a lone CR ends lines only in files without any LF: old Macintosh
  std::string_view line;
  if (!takeLine(line)) throw FormatError(name_ + ": the file is empty: begin with a line that names the columns");
  split(line, columns_);
}

std::optional<std::size_t> CsvTable::find(std::string_view column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  if (found == columns_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns_.begin());
}

std::size_t CsvTable::require(std::string_view column, std::string_view advice) const {
  if (const std::optional<std::size_t> found = find(column)) return *found;
  fail("there is no column " + std::string(column) + ": " + std::string(advice));
}

bool CsvTable::next() {
  std::string_view line;
  do
    if (!takeLine(line)) return false;
  while (trimmed(line).empty());
  split(line, fields_);
  if (fields_.size() != columns_.size())
    fail(std::to_string(fields_.size()) + (fields_.size() == 1 ? " field" : " fields") + ", the header has " +
         std::to_string(columns_.size()));
  return true;
}

double CsvTable::number(std::size_t column, double limit) const {
  double value = 0;
  if (parseDouble(fields_[column], value) != NumberFault::None) failField(column, "write a number");
  if (!std::isfinite(value) || std::abs(value) > limit) failField(column, "write a finite number within " + shortest(limit));
  return value;
}

std::vector<double> CsvTable::numbers(std::size_t column, double limit) const {
  std::vector<double> out;
  for (std::string_view rest = fields_[column]; !rest.empty();) {
    const std::size_t end = std::min(rest.find(';'), rest.size());
    double value = 0;
    if (parseDouble(rest.substr(0, end), value) != NumberFault::None || !(std::abs(value) <= limit))
      failField(column, "write numbers within " + shortest(limit) + ", separated by semicolons");
    out.push_back(value);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return out;
}

std::uint64_t CsvTable::count(std::size_t column, std::uint64_t limit) const {
  const std::string_view word = fields_[column];
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || value > limit)
    failField(column, "write a whole number from 0 to " + std::to_string(limit));
  return value;
}

void CsvTable::fail(const std::string& what) const { throw FormatError(name_ + ", line " + std::to_string(line_) + ": " + what); }

void CsvTable::failField(std::size_t column, const std::string& what) const {
  fail("column " + std::to_string(column + 1) + " (" + std::string(columns_[column]) + ") is " + inQuotes(fields_[column]) + ": " + what);
}

bool CsvTable::takeLine(std::string_view& line) {
  if (rest_.empty()) return false;
  ++line_;
  const std::size_t end = std::min(rest_.find(line_end_), rest_.size());
  line = rest_.substr(0, end);
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  return true;
}

void CsvTable::split(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    fields.push_back(trimmed(line.substr(begin, end - begin)));
    if (end == line.size()) return;
    begin = end + 1;
  }
}

std::string encodedField(std::string_view text) {
  std::string field;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte > ' ' && byte != 0x7f && c != ',' && c != '"' && c != '%') {
      field += c;
      continue;
    }
    constexpr const char* kDigits = "0123456789ABCDEF";
    field += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
  }
  return field;
}

std::string decodedField(std::string_view field) {
  std::string text;
  for (std::size_t i = 0; i < field.size(); ++i) {
    unsigned byte = 0;
    const char* end = field.data() + std::min(i + 3, field.size());
    if (field[i] == '%' && i + 2 < field.size() && std::from_chars(field.data() + i + 1, end, byte, 16).ptr == end) {
      text += static_cast<char>(byte);
      i += 2;
    } else {
      text += field[i];
    }
  }
  return text;
}

}  // namespace spheretree::formats
