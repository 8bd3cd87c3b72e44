// SPDX-License-Identifier: Apache-2.0
// Feeds any text to the reader of the labels of scans: it is refused with a reason that names the text, or gives labels
// within their range.
#include <algorithm>

#include "fuzz/fuzz_target.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/scan_labels.h"

namespace spheretree::fuzz {

std::vector<std::string> seeds() {
  return {R"({"id_patient": "P1", "jaw": "upper", "labels": [0, 0, 11, 21.0, 999], "instances": [0, 0, 1, 2, 3]})",
          R"({"jaw": "Mandible", "labels": [44]})", R"({"labels": [0, 17, 18], "source": {"scanner": [1, 2]}})"};
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace spheretree;
  try {
    const formats::ScanLabels read = formats::parseScanLabels({reinterpret_cast<const char*>(data), size}, "input");
    fuzz::require(!read.labels.empty() && read.labels.size() <= size, "no more labels than bytes");
    fuzz::require(
        std::all_of(read.labels.begin(), read.labels.end(), [](int label) { return label >= 0 && label <= formats::kMaxScanLabel; }),
        "a label is within its range");
    fuzz::require(read.jaw.empty() || read.jaw == "upper" || read.jaw == "lower", "a jaw is upper, lower or not stated");
  } catch (const formats::FormatError& error) {
    fuzz::require(std::string(error.what()).starts_with("input"), "a refusal names the text");
  }
  return 0;
}
