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

/// Reads one row after the other. Lines end with LF, CRLF or CR; blanks around a field and empty lines are ignored.
/// Cost: O(size). Every error is a FormatError that names file, line and column.
class CsvTable {
 public:
  /// Reads the first line. `text` must outlive the table; `name` of the file, for messages. @throws FormatError if the
  /// text is empty or not text.
  CsvTable(std::string_view text, std::string name);

  const std::vector<std::string_view>& columns() const { return columns_; }
  /// The index of a column; empty if the file does not have it.
  std::optional<std::size_t> find(std::string_view column) const;
  /// The index of a column. `advice`: what to do if it is missing. @throws FormatError
  std::size_t require(std::string_view column, std::string_view advice) const;

  /// Moves to the next row; false at the end. @throws FormatError if it has more or fewer fields than the first line.
  bool next();
  std::string_view field(std::size_t column) const { return fields_[column]; }
  /// @throws FormatError unless the field is a finite number with an absolute value of at most `limit`.
  double number(std::size_t column, double limit = 1e30) const;
  /// The numbers of a field, which semicolons separate; none for an empty one. @throws FormatError as number() does.
  std::vector<double> numbers(std::size_t column, double limit = 1e30) const;
  /// @throws FormatError unless the field is a whole number from 0 to `limit`.
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

/// `text` as one field: control characters, blanks, quotes, commas and % are encoded as %XX.
std::string encodedField(std::string_view text);
/// The inverse of encodedField().
std::string decodedField(std::string_view field);

}  // namespace spheretree::formats
