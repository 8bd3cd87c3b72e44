// SPDX-License-Identifier: Apache-2.0
#include "gltf/meshopt_view.h"

#include <meshoptimizer.h>

#include "gltf/gltf_json.h"
#include "text/text_scan.h"

namespace spheretree::formats {
namespace {

// Byte k of 16 consecutive vertices takes at least 2 bits, which give the number of bits for each of the 16.
constexpr std::uint64_t kMaxAttributeBytes = 64;  // for one compressed byte

class View {
 public:
  View(const MeshoptView& view, const MeshAssembly& assembly, const std::string& where) : view_(view), assembly_(assembly), where_(where) {}

  std::vector<unsigned char> decode() const {
    if (view_.bytes.empty() || view_.count == 0) refuse("has no element");
    if (view_.mode == "ATTRIBUTES") return attributes();
    if (view_.mode == "TRIANGLES" || view_.mode == "INDICES") return indices();
    refuse("has the mode " + inQuotes(view_.mode) + ", which does not exist");
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const { refuseElement(assembly_, where_, what); }

  /// `max_count`: largest number of elements that the compressed bytes can represent.
  std::vector<unsigned char> room(std::uint64_t max_count) const {
    if (view_.count > max_count)
      refuse("announces " + std::to_string(view_.count) + " elements, but its " + std::to_string(view_.bytes.size()) +
             " compressed bytes hold at most " + std::to_string(max_count));
    return std::vector<unsigned char>(view_.count * view_.stride);
  }

  void checkVersion(unsigned char header) const {  // in the low 4 bits
    if ((view_.bytes[0] & 0xf0) == header && (view_.bytes[0] & 0x0f) > (header == 0xa0 ? 0 : 1))
      assembly_.refuse(
          where_ + " is of version " + std::to_string(view_.bytes[0] & 0x0f) +
          " of meshoptimizer's format, which is newer than this program. Export it for EXT_meshopt_compression (gltfpack -ce ext).");
  }

  void checkResult(int result) const {
    if (result != 0) refuse("does not unpack to the " + std::to_string(view_.count) + " elements that it announces");
  }

  std::vector<unsigned char> attributes() const {
    if (view_.stride == 0 || view_.stride % 4 != 0 || view_.stride > 256)
      refuse("has a byteStride of " + std::to_string(view_.stride) + ", not a multiple of 4 from 4 to 256");
    checkVersion(0xa0);
    std::vector<unsigned char> data = room(view_.bytes.size() * kMaxAttributeBytes / view_.stride);
    checkResult(meshopt_decodeVertexBuffer(data.data(), view_.count, view_.stride, view_.bytes.data(), view_.bytes.size()));
    const auto needs = [&](bool fits) {
      if (!fits)
        refuse("has a byteStride of " + std::to_string(view_.stride) + ", which does not fit its filter " + inQuotes(view_.filter));
    };
    if (view_.filter == "OCTAHEDRAL") {
      needs(view_.stride == 4 || view_.stride == 8);
      meshopt_decodeFilterOct(data.data(), view_.count, view_.stride);
    } else if (view_.filter == "QUATERNION") {
      needs(view_.stride == 8);
      meshopt_decodeFilterQuat(data.data(), view_.count, view_.stride);
    } else if (view_.filter == "EXPONENTIAL") {
      meshopt_decodeFilterExp(data.data(), view_.count, view_.stride);
    } else if (view_.filter != "NONE") {
      refuse("has the filter " + inQuotes(view_.filter) + ", which does not exist");
    }
    return data;
  }

  std::vector<unsigned char> indices() const {
    const bool triangles = view_.mode == "TRIANGLES";
    if (view_.stride != 2 && view_.stride != 4) refuse("has a byteStride of " + std::to_string(view_.stride) + ", not 2 or 4");
    if (view_.filter != "NONE") refuse("has a filter, which only attributes may have");
    if (triangles && view_.count % 3 != 0) refuse("has " + std::to_string(view_.count) + " indices, which is not a multiple of 3");
    checkVersion(triangles ? 0xe0 : 0xd0);
    // At least a byte for each triangle, or index.
    std::vector<unsigned char> data = room(view_.bytes.size() * (triangles ? 3 : 1));
    const unsigned char* from = view_.bytes.data();
    const std::size_t size = view_.bytes.size(), count = view_.count, stride = view_.stride;
    checkResult(triangles ? meshopt_decodeIndexBuffer(data.data(), count, stride, from, size)
                          : meshopt_decodeIndexSequence(data.data(), count, stride, from, size));
    return data;
  }

  const MeshoptView& view_;
  const MeshAssembly& assembly_;
  const std::string& where_;
};

}  // namespace

std::vector<unsigned char> decodeMeshopt(const MeshoptView& view, const MeshAssembly& assembly, const std::string& where) {
  return View(view, assembly, where).decode();
}

}  // namespace spheretree::formats
