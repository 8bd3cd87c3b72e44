// SPDX-License-Identifier: GPL-3.0-or-later
#include "output_path.h"

#include <system_error>

#include "program_end.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::tool {

void checkOutput(const std::filesystem::path& output, std::initializer_list<std::filesystem::path> inputs) {
  std::error_code none;  // what does not exist is not the same
  if (std::filesystem::is_regular_file(output, none))
    for (const std::filesystem::path& input : inputs)
      if (std::filesystem::equivalent(output, input, none))
        throw UsageError(output.string() + ": would be written over " + input.string() + ", which is read. Give another name.");
  formats::checkWritable(output);
}

}  // namespace spheretree::tool
