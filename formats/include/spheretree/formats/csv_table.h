// SPDX-License-Identifier: Apache-2.0
// Comma-separated values whose first line names the columns: recordings, trajectories, states of tissue.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace spheretree::formats {

/// Reads one row after the other. Lines end with LF, CRLF or CR; blanks round a field and empty lines do not count.
/// Cost: O(size). Every complaint is a FormatError that names file, line and column.
class CsvTable {
 public:
  /// Takes the first line. `text` has to outlive the table; `name`: of the file, for messages. @throws FormatError for
  /// what is no text, or empty.
  CsvTable(std::string_view text, std::string name);

  const std::vector<std::string_view>& columns() const { return columns_; }
  /// Nothing: the file has no such column.
  std::optional<std::size_t> find(std::string_view column) const;
  /// `advice`: what to do where it lacks. @throws FormatError
  std::size_t require(std::string_view column, std::string_view advice) const;

  /// Takes the next row; false at the end. @throws FormatError if it has more or fewer fields than the first line.
  bool next();
  std::string_view field(std::size_t column) const { return fields_[column]; }
  /// @throws FormatError for what is no finite number within `limit`
  double number(std::size_t column, double limit = 1e30) const;
  /// @throws FormatError for what is no whole number from 0 to `limit`
  std::uint64_t count(std::size_t column, std::uint64_t limit) const;

  /// "NAME, line 12: what". @throws FormatError
  [[noreturn]] void fail(const std::string& what) const;
  /// "NAME, line 12: column 3 (hx_mm) is "abc": what". @throws FormatError
  [[noreturn]] void failField(std::size_t column, const std::string& what) const;

 private:
  bool takeLine(std::string_view& line);
  static void split(std::string_view line, std::vector<std::string_view>& fields);

  std::string_view rest_;
  char line_end_;
  std::string name_;
  std::size_t line_ = 0;
  std::vector<std::string_view> columns_, fields_;
};

/// `text` as one field: control characters, blanks, quotes, commas and % as %XX.
std::string encodedField(std::string_view text);
/// What encodedField() was given.
std::string decodedField(std::string_view field);

}  // namespace spheretree::formats
