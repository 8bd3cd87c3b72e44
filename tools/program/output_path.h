// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a file may be written, found out before long work.
#pragma once

#include <filesystem>
#include <initializer_list>

namespace spheretree::tool {

/// @throws UsageError if `output` is one of `inputs`, which it would replace; formats::FileError as formats::checkWritable() does.
void checkOutput(const std::filesystem::path& output, std::initializer_list<std::filesystem::path> inputs);

}  // namespace spheretree::tool
