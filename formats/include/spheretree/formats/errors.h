// SPDX-License-Identifier: Apache-2.0
// The kinds of errors of a file. A message names the file, the element and the value, and says what to do.
#pragma once

#include <stdexcept>

namespace spheretree::formats {

/// A file cannot be read or written: missing, no permission, disk full. The program exits with 3.
struct FileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A file was read, but its content is refused. The program exits with 4.
struct FormatError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The file is a mesh without a triangle. Robots have such files as placeholders.
struct NoTriangleError : FormatError {
  using FormatError::FormatError;
};

}  // namespace spheretree::formats
