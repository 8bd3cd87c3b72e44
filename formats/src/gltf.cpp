// SPDX-License-Identifier: Apache-2.0
// Specification: Khronos, glTF 2.0, ISO/IEC 12113:2022. Section numbers below are of that.
// On the JSON itself rather than through tinygltf 2.7.0, which reads up to 8 bytes beyond a truncated GLB, recurses without limit into
// nested extras, takes properties of a wrong type for missing ones, and refuses a mesh for the sake of its images.
#include "spheretree/formats/gltf.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include "mesh_assembly.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "text_scan.h"

namespace spheretree::formats {
namespace {

using Json = nlohmann::json;

constexpr double kMetreMm = 1000;
constexpr int kMaxJsonDepth = 64;                   // glTF itself needs 8; extras are free
constexpr std::uint64_t kMinWorkLimit = 4'000'000;  // triangles, primitives and nodes that instances may add up to in a small file

std::uint64_t littleBits(const char* bytes, std::size_t size) {
  std::uint64_t bits = 0;
  for (std::size_t k = size; k-- > 0;) bits = bits << 8 | static_cast<unsigned char>(bytes[k]);
  return bits;
}

std::uint32_t littleUint32(const char* bytes) { return static_cast<std::uint32_t>(littleBits(bytes, 4)); }

enum Component : std::uint64_t { kInt8 = 5120, kUint8 = 5121, kInt16 = 5122, kUint16 = 5123, kUint32 = 5125, kFloat32 = 5126 };

std::size_t sizeOf(std::uint64_t component) {
  switch (component) {
    case kInt8:
    case kUint8:
      return 1;
    case kInt16:
    case kUint16:
      return 2;
    default:
      return 4;
  }
}

/// `components` numbers every `stride` bytes, `count` times, all within the memory of one buffer.
struct Elements {
  const char* first = nullptr;
  std::size_t stride = 0;
  std::uint64_t count = 0;
  std::uint64_t component = kFloat32;

  std::uint64_t unsignedAt(std::uint64_t i) const { return littleBits(first + i * stride, sizeOf(component)); }
  double numberAt(std::uint64_t i, std::size_t axis, bool normalised) const {
    const std::uint64_t bits = littleBits(first + i * stride + axis * sizeOf(component), sizeOf(component));
    switch (component) {  // 3.11: f = max(c / 127, -1), and so on
      case kInt8:
        return normalised ? std::max(static_cast<std::int8_t>(bits) / 127.0, -1.0) : static_cast<std::int8_t>(bits);
      case kUint8:
        return static_cast<double>(bits) / (normalised ? 255.0 : 1.0);
      case kInt16:
        return normalised ? std::max(static_cast<std::int16_t>(bits) / 32767.0, -1.0) : static_cast<std::int16_t>(bits);
      case kUint16:
        return static_cast<double>(bits) / (normalised ? 65535.0 : 1.0);
      default:
        return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    }
  }
};

struct Positions {
  std::string where;  // for messages
  std::uint64_t count = 0;
  bool normalised = false;
  std::optional<Elements> dense;  // none: zeros
  Elements sparse_indices, sparse_values;

  Eigen::Vector3d at(std::uint64_t i) const {
    std::uint64_t low = 0, high = sparse_indices.count;  // rising, as checked on opening
    while (low < high) {
      const std::uint64_t middle = low + (high - low) / 2;
      if (sparse_indices.unsignedAt(middle) < i)
        low = middle + 1;
      else
        high = middle;
    }
    const bool is_sparse = low < sparse_indices.count && sparse_indices.unsignedAt(low) == i;
    if (!is_sparse && !dense) return Eigen::Vector3d::Zero();
    const Elements& from = is_sparse ? sparse_values : *dense;
    const std::uint64_t place = is_sparse ? low : i;
    return {from.numberAt(place, 0, normalised), from.numberAt(place, 1, normalised), from.numberAt(place, 2, normalised)};
  }
};

class GltfReader {
 public:
  GltfReader(std::span<const char> bytes, const std::string& name, const std::filesystem::path& folder)
      : assembly_(name, kMetreMm), bytes_(bytes), folder_(folder), work_left_(std::max<std::uint64_t>(kMinWorkLimit, bytes.size())) {}

  MeshFile read() {
    const bool is_binary = bytes_.size() >= 4 && std::string_view(bytes_.data(), 4) == "glTF";
    parse(is_binary ? openContainer() : asText(bytes_, assembly_.name()));
    checkVersion();
    checkExtensions();
    buffers_.resize(array("buffers").size());
    visitNodes();
    if (has_skin_) assembly_.note("Skins were not applied: the mesh is read in the pose in which it is stored.");
    if (skipped_modes_) assembly_.note(std::to_string(skipped_modes_) + " primitives of points or lines were left out.");
    if (!has_primitive_) assembly_.refuse("no node of its scene has a mesh. Export the scene again with its meshes.");
    return assembly_.finish(is_binary ? "GLB" : "glTF");
  }

 private:
  // --- container and JSON ---

  std::span<const char> openContainer() {
    constexpr std::uint32_t kJsonChunk = 0x4e4f534a, kBinChunk = 0x004e4942;
    if (bytes_.size() < 20)
      assembly_.refuse("is a GLB of only " + std::to_string(bytes_.size()) + " bytes. It is cut off: copy or export it again.");
    if (const std::uint32_t version = littleUint32(bytes_.data() + 4); version != 2)
      assembly_.refuse("is GLB of version " + std::to_string(version) + "; only version 2 is read. Export it as glTF 2.0.");
    const std::uint32_t length = littleUint32(bytes_.data() + 8);
    if (length > bytes_.size())
      assembly_.refuse("has " + std::to_string(bytes_.size()) + " of the " + std::to_string(length) +
                       " bytes that its header announces. It is cut off: copy or export it again.");
    if (length < bytes_.size()) assembly_.note(std::to_string(bytes_.size() - length) + " bytes after the end of the GLB were ignored.");
    std::span<const char> rest = bytes_.first(length), json;
    rest = rest.subspan(std::min<std::size_t>(12, rest.size()));
    for (int chunk = 0; !rest.empty(); ++chunk) {
      const std::string where = "chunk " + std::to_string(chunk);
      if (rest.size() < 8) assembly_.refuse(where + " has no room for its header. The file is damaged: export it again.");
      const std::uint32_t size = littleUint32(rest.data()), type = littleUint32(rest.data() + 4);
      rest = rest.subspan(8);
      if (size > rest.size())
        assembly_.refuse(where + " announces " + std::to_string(size) + " bytes, but " + std::to_string(rest.size()) +
                         " are left. The file is cut off or damaged: copy or export it again.");
      if ((chunk == 0) != (type == kJsonChunk))
        assembly_.refuse(where + " is of the wrong type: a GLB begins with one JSON chunk. Export it again.");
      if (chunk == 0) json = rest.first(size);
      if (chunk == 1 && type == kBinChunk) binary_chunk_ = rest.first(size);
      rest = rest.subspan(size);
    }
    return json;
  }

  void parse(std::span<const char> text) {
    if (text.empty()) assembly_.refuse("holds no JSON. Export it again.");
    // Counted beforehand: the parser's own callback takes quadratic time for long arrays.
    int depth = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
      const char c = text[i];
      if (in_string && c == '\\') ++i;
      if (c == '"') in_string = !in_string;
      if (in_string) continue;
      if (c == '[' || c == '{') ++depth;
      if (c == ']' || c == '}') --depth;
      if (depth > kMaxJsonDepth)
        assembly_.refuse("its JSON is nested more than " + std::to_string(kMaxJsonDepth) + " deep. Export it again.");
    }
    try {
      root_ = Json::parse(text.begin(), text.end());
    } catch (const Json::exception& error) {
      assembly_.refuse("its JSON is damaged: " + std::string(error.what()) + ". Export it again.");
    }
    if (!root_.is_object()) assembly_.refuse("its JSON is no object. Export it again.");
  }

  /// Says what is wrong with an element, as "meshes[3].primitives[0]".
  [[noreturn]] void refuse(const std::string& where, const std::string& what) const {
    assembly_.refuse(where + " " + what + ". The file is damaged or not valid glTF 2.0: export it again.");
  }

  const Json* find(const Json& object, const char* key) const {
    const auto found = object.find(key);
    return found == object.end() ? nullptr : &*found;
  }

  /// A top-level array; empty if it is missing.
  const Json& array(const char* key) const {
    static const Json empty = Json::array();
    const Json* found = find(root_, key);
    if (!found) return empty;
    if (!found->is_array()) refuse(key, "is not an array");
    return *found;
  }

  const Json& element(const char* key, std::uint64_t index, const std::string& from) const {
    const Json& all = array(key);
    if (index >= all.size()) refuse(from, "names " + place(key, index) + ", but there are only " + std::to_string(all.size()));
    if (!all[index].is_object()) refuse(place(key, index), "is not an object");
    return all[index];
  }

  static std::string place(const std::string& key, std::uint64_t index) { return key + "[" + std::to_string(index) + "]"; }

  std::uint64_t asUnsigned(const Json& value, const std::string& where) const {
    if (value.is_number_unsigned()) return value.get<std::uint64_t>();
    if (value.is_number_float()) {  // JSON has one kind of number: 3.0 is whole, too
      const double number = value.get<double>();
      if (number >= 0 && number <= 0x1p53 && number == std::floor(number)) return static_cast<std::uint64_t>(number);
    }
    refuse(where, "is not a whole number of 0 or more");
  }

  std::optional<std::uint64_t> findUnsigned(const Json& object, const char* key, const std::string& where) const {
    const Json* found = find(object, key);
    if (!found) return std::nullopt;
    return asUnsigned(*found, where + "." + key);
  }

  std::uint64_t getUnsigned(const Json& object, const char* key, const std::string& where) const {
    const std::optional<std::uint64_t> found = findUnsigned(object, key, where);
    if (!found) refuse(where, "has no \"" + std::string(key) + "\"");
    return *found;
  }

  std::string findText(const Json& object, const char* key) const {
    const Json* found = find(object, key);
    return found && found->is_string() ? found->get<std::string>() : std::string();
  }

  void checkVersion() const {
    const Json* asset = find(root_, "asset");
    if (!asset || !asset->is_object()) refuse("asset", "is missing");
    const std::string version = findText(*asset, "version"), least = findText(*asset, "minVersion");
    if (!version.starts_with("2."))
      assembly_.refuse("is glTF of version " + inQuotes(version) + "; only 2.0 is read. Export it as glTF 2.0.");
    if (!least.empty() && least != "2.0") assembly_.refuse("needs glTF " + inQuotes(least) + "; only 2.0 is read. Export it as glTF 2.0.");
  }

  void checkExtensions() {
    static constexpr std::string_view kHarmless[] = {"KHR_mesh_quantization", "KHR_lights_punctual", "KHR_animation_pointer",
                                                     "KHR_xmp_json_ld"};
    static constexpr std::string_view kHarmlessKinds[] = {"KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "EXT_lights_"};
    for (const Json& entry : array("extensionsRequired")) {
      if (!entry.is_string()) refuse("extensionsRequired", "holds something other than names");
      const std::string name = entry.get<std::string>();
      const auto is_kind = [&](std::string_view kind) { return name.starts_with(kind); };
      if (std::find(std::begin(kHarmless), std::end(kHarmless), name) != std::end(kHarmless)) continue;
      if (std::any_of(std::begin(kHarmlessKinds), std::end(kHarmlessKinds), is_kind)) continue;
      const bool is_compressed =
          name == "KHR_draco_mesh_compression" || name == "EXT_meshopt_compression" || name == "KHR_meshopt_compression";
      assembly_.refuse("requires the extension " + inQuotes(name) + ", which is not read here. " +
                       (is_compressed ? "Export the mesh without compression, or unpack the file with a glTF tool."
                                      : "Export the mesh without it, or convert it to OBJ, STL or PLY."));
    }
    for (const Json& entry : array("extensionsUsed"))
      if (entry == "EXT_mesh_gpu_instancing") assembly_.note("Instances by EXT_mesh_gpu_instancing were left out: each node counts once.");
  }

  // --- buffers and accessors ---

  std::span<const char> buffer(std::uint64_t index, const std::string& from) {
    const Json& object = element("buffers", index, from);
    const std::string where = place("buffers", index);
    const std::uint64_t length = getUnsigned(object, "byteLength", where);
    Buffer& entry = buffers_[index];
    if (!entry.is_open) {
      const Json* uri = find(object, "uri");
      if (uri && !uri->is_string()) refuse(where + ".uri", "is not text");
      if (uri) {
        openUri(uri->get_ref<const std::string&>(), where, entry);
      } else {
        if (index != 0 || binary_chunk_.empty())
          refuse(where, "has no data" + std::string(find(object, "extensions") ? " without its extensions" : ""));
        entry.data = binary_chunk_;
      }
      entry.is_open = true;
    }
    if (entry.data.size() < length)
      refuse(where, "announces " + std::to_string(length) + " bytes, but has " + std::to_string(entry.data.size()));
    return entry.data.first(length);
  }

  struct Buffer {
    bool is_open = false;
    std::vector<char> decoded;
    std::span<const char> data;
  };

  void openUri(const std::string& uri, const std::string& where, Buffer& entry) {
    if (uri.starts_with("data:")) {
      const std::size_t comma = uri.find(',');
      if (comma == std::string::npos || !std::string_view(uri).substr(0, comma).ends_with(";base64"))
        refuse(where + ".uri", "is a data URI, but not of base64");
      entry.decoded = decodeBase64(std::string_view(uri).substr(comma + 1), where);
      entry.data = entry.decoded;
      return;
    }
    const std::filesystem::path path = resolve(percentDecoded(uri, where), where);
    const auto [file, is_new] = files_.try_emplace(path.string());
    if (is_new) {
      if (external_bytes_ >= kMaxFileBytes) refuse(where, "is one of buffers of more than 4 GiB together");
      file->second = readFile(path, kMaxFileBytes - external_bytes_);
      external_bytes_ += file->second.size();
    }
    entry.data = {reinterpret_cast<const char*>(file->second.data()), file->second.size()};
  }

  std::vector<char> decodeBase64(std::string_view text, const std::string& where) const {
    while (!text.empty() && text.back() == '=') text.remove_suffix(1);
    std::vector<char> bytes;
    bytes.reserve(text.size() / 4 * 3 + 2);
    std::uint32_t bits = 0;
    int filled = 0;
    for (const char c : text) {
      const int value = c >= 'A' && c <= 'Z'   ? c - 'A'
                        : c >= 'a' && c <= 'z' ? c - 'a' + 26
                        : c >= '0' && c <= '9' ? c - '0' + 52
                        : c == '+'             ? 62
                        : c == '/'             ? 63
                                               : -1;
      if (value < 0) refuse(where + ".uri", "has " + inQuotes(std::string_view(&c, 1)) + " in its base64 data");
      bits = (bits << 6 | static_cast<std::uint32_t>(value)) & 0xffffff;
      if ((filled += 6) >= 8) bytes.push_back(static_cast<char>(bits >> (filled -= 8)));
    }
    return bytes;
  }

  std::string percentDecoded(std::string_view uri, const std::string& where) const {
    const auto digit = [](char c) {
      return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
    };
    std::string result;
    for (std::size_t i = 0; i < uri.size(); ++i) {
      char c = uri[i];
      if (c == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
        c = static_cast<char>(digit(uri[i + 1]) * 16 + digit(uri[i + 2]));
        i += 2;
      }
      if (c == '\0') refuse(where + ".uri", "has a zero character");
      result += c;
    }
    return result;
  }

  /// The file beside or below the glTF file that a URI names; also after all symbolic links.
  std::filesystem::path resolve(const std::string& uri, const std::string& where) const {
    const auto refuseUri = [&](const std::string& why) {
      assembly_.refuse(where + " lies in " + inQuotes(uri) + ", which " + why +
                       ". Put the buffer into the folder of the glTF file, or export a GLB.");
    };
    if (folder_.empty()) refuseUri("is another file, and none is read here");
    if (uri.find("://") != std::string::npos) refuseUri("is not a file on this machine");
    const std::filesystem::path relative(uri);
    if (relative.empty() || relative.is_absolute() || std::find(relative.begin(), relative.end(), "..") != relative.end())
      refuseUri("does not stay within the folder of the glTF file");
    std::error_code error;
    const std::filesystem::path path = std::filesystem::canonical(folder_ / relative, error);
    if (error)
      throw FileError((folder_ / relative).string() + ": cannot be read: " + error.message() + ". " + assembly_.name() +
                      " needs this buffer: put it beside, or export a GLB.");
    const std::filesystem::path base = std::filesystem::canonical(folder_, error);
    if (error || std::mismatch(base.begin(), base.end(), path.begin(), path.end()).first != base.end())
      refuseUri("leads out of the folder of the glTF file through a link");
    if (!std::filesystem::is_regular_file(path, error)) refuseUri("is not a plain file");
    return path;
  }

  /// `count` elements in a bufferView from `offset` on.
  Elements open(const Json& object, std::uint64_t view_index, std::uint64_t count, std::uint64_t component, std::size_t components,
                bool may_stride, const std::string& where) {
    const Json& view = element("bufferViews", view_index, where);
    const std::string view_where = place("bufferViews", view_index);
    if (const Json* extensions = find(view, "extensions"); extensions && extensions->is_object())
      for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
        if (extensions->contains(name)) assembly_.note(view_where + " was read as its fallback without " + name + ".");
    const std::span<const char> data = buffer(getUnsigned(view, "buffer", view_where), view_where);
    const std::uint64_t offset = findUnsigned(view, "byteOffset", view_where).value_or(0),
                        length = getUnsigned(view, "byteLength", view_where);
    if (offset > data.size() || length > data.size() - offset)
      refuse(view_where, "(offset " + std::to_string(offset) + ", length " + std::to_string(length) + ") reaches beyond the " +
                             std::to_string(data.size()) + " bytes of its buffer");
    const std::size_t size = sizeOf(component) * components;
    const std::optional<std::uint64_t> stride = findUnsigned(view, "byteStride", view_where);
    if (stride && !may_stride) refuse(view_where, "has a byteStride, which only vertex attributes may have");
    if (stride && (*stride < size || *stride > 252))
      refuse(view_where,
             "has a byteStride of " + std::to_string(*stride) + ", not within " + std::to_string(size) + " (the element) and 252");
    const std::uint64_t start = findUnsigned(object, "byteOffset", where).value_or(0), step = stride.value_or(size);
    // In this order no sum or product can overflow.
    if (start > length || count > (length - start) / step + 1 || (count - 1) * step + size > length - start)
      refuse(where, "(offset " + std::to_string(start) + ", " + std::to_string(count) + " elements of " + std::to_string(step) +
                        " bytes) reaches beyond the " + std::to_string(length) + " bytes of " + view_where);
    return {data.data() + offset + start, static_cast<std::size_t>(step), count, component};
  }

  std::uint64_t componentOf(const Json& object, std::initializer_list<std::uint64_t> allowed, const std::string& where) const {
    const std::uint64_t component = getUnsigned(object, "componentType", where);
    if (std::find(allowed.begin(), allowed.end(), component) == allowed.end())
      refuse(where, "has componentType " + std::to_string(component) + ", which does not fit its use");
    return component;
  }

  const Positions& positions(std::uint64_t index, const std::string& from) {
    const auto [entry, is_new] = positions_.try_emplace(index);
    if (!is_new) return entry->second;
    Positions& result = entry->second;
    const Json& object = element("accessors", index, from);
    const std::string where = result.where = place("accessors", index);
    if (findText(object, "type") != "VEC3") refuse(where, "holds positions, but is not of type VEC3");
    const std::uint64_t component = componentOf(object, {kFloat32, kInt8, kUint8, kInt16, kUint16}, where);
    if (const Json* normalised = find(object, "normalized")) {
      if (!normalised->is_boolean()) refuse(where + ".normalized", "is not true or false");
      result.normalised = normalised->get<bool>();
    }
    result.count = getUnsigned(object, "count", where);
    if (result.count == 0) refuse(where, "has no element");
    const std::optional<std::uint64_t> view = findUnsigned(object, "bufferView", where);
    if (view) result.dense = open(object, *view, result.count, component, 3, true, where);
    const Json* sparse = find(object, "sparse");
    if (!view && !sparse) refuse(where, "has no data without extensions");
    if (!sparse) return result;

    const std::string sparse_where = where + ".sparse";
    if (!sparse->is_object()) refuse(sparse_where, "is not an object");
    const std::uint64_t count = getUnsigned(*sparse, "count", sparse_where);
    const Json *indices = find(*sparse, "indices"), *values = find(*sparse, "values");
    if (!indices || !indices->is_object() || !values || !values->is_object()) refuse(sparse_where, "lacks its indices or values");
    if (count == 0 || count > result.count)
      refuse(sparse_where, "replaces " + std::to_string(count) + " of " + std::to_string(result.count) + " elements");
    const std::string indices_where = sparse_where + ".indices", values_where = sparse_where + ".values";
    result.sparse_indices = open(*indices, getUnsigned(*indices, "bufferView", indices_where), count,
                                 componentOf(*indices, {kUint8, kUint16, kUint32}, indices_where), 1, false, indices_where);
    result.sparse_values = open(*values, getUnsigned(*values, "bufferView", values_where), count, component, 3, false, values_where);
    spend(count);
    for (std::uint64_t k = 0; k < count; ++k) {
      const std::uint64_t at = result.sparse_indices.unsignedAt(k);
      if (at >= result.count || (k > 0 && at <= result.sparse_indices.unsignedAt(k - 1)))
        refuse(indices_where, "element " + std::to_string(k) + " is " + std::to_string(at) + "; they must rise and stay below " +
                                  std::to_string(result.count));
    }
    return result;
  }

  // --- scene ---

  struct Pose {
    Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
    Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // [m]
  };

  template <std::size_t kSize>
  bool findNumbers(const Json& node, const char* key, const std::string& where, std::array<double, kSize>& numbers) const {
    const Json* found = find(node, key);
    if (!found) return false;
    if (!found->is_array() || found->size() != kSize) refuse(where + "." + key, "is not an array of " + std::to_string(kSize) + " numbers");
    for (std::size_t i = 0; i < kSize; ++i) {
      if (!(*found)[i].is_number()) refuse(where + "." + key, "is not an array of " + std::to_string(kSize) + " numbers");
      numbers[i] = (*found)[i].template get<double>();
    }
    return true;
  }

  Pose poseOf(const Json& node, const std::string& where) const {
    Pose pose;
    if (std::array<double, 16> m; findNumbers(node, "matrix", where, m)) {
      if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1) refuse(where + ".matrix", "is not affine: its last row must be 0 0 0 1");
      pose.linear << m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10];
      pose.offset << m[12], m[13], m[14];
      return pose;
    }
    if (std::array<double, 4> q; findNumbers(node, "rotation", where, q)) {
      const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
      const double norm = rotation.norm();
      if (!(std::abs(norm - 1) < 0.01)) refuse(where + ".rotation", "is not a unit quaternion");
      pose.linear = rotation.normalized().toRotationMatrix();  // stored as float32, hence rounded
    }
    if (std::array<double, 3> s; findNumbers(node, "scale", where, s))
      pose.linear = pose.linear * Eigen::Vector3d(s[0], s[1], s[2]).asDiagonal();
    if (std::array<double, 3> t; findNumbers(node, "translation", where, t)) pose.offset << t[0], t[1], t[2];
    return pose;
  }

  std::vector<std::uint64_t> indexList(const Json& object, const char* key, const std::string& where) const {
    std::vector<std::uint64_t> result;
    const Json* found = find(object, key);
    if (!found) return result;
    if (!found->is_array()) refuse(where + "." + key, "is not an array");
    for (const Json& entry : *found) result.push_back(asUnsigned(entry, where + "." + key));
    return result;
  }

  std::vector<std::uint64_t> rootNodes() {
    const std::size_t scene_count = array("scenes").size();
    const std::optional<std::uint64_t> scene = findUnsigned(root_, "scene", "the file");
    if (scene || scene_count > 0) {
      if (!scene && scene_count > 1)
        assembly_.note("No default scene is named; the first of " + std::to_string(scene_count) + " was read.");
      if (scene && scene_count > 1)
        assembly_.note("The default scene " + std::to_string(*scene) + " of " + std::to_string(scene_count) + " was read.");
      return indexList(element("scenes", scene.value_or(0), "\"scene\""), "nodes", place("scenes", scene.value_or(0)));
    }
    std::vector<bool> is_child(array("nodes").size());
    for (std::uint64_t n = 0; n < is_child.size(); ++n)
      for (const std::uint64_t child : indexList(element("nodes", n, ""), "children", place("nodes", n))) {
        if (child >= is_child.size())
          refuse(place("nodes", n), "names " + place("nodes", child) + ", but there are only " + std::to_string(is_child.size()));
        is_child[child] = true;
      }
    std::vector<std::uint64_t> roots;
    for (std::uint64_t n = 0; n < is_child.size(); ++n)
      if (!is_child[n]) roots.push_back(n);
    if (roots.size() > 1) assembly_.note("No scene is named; all " + std::to_string(roots.size()) + " root nodes were read.");
    return roots;
  }

  void visitNodes() {
    struct Visit {
      std::uint64_t node;
      Pose parent;
      std::string from;
    };
    std::vector<Visit> stack;  // own stack: a file may nest nodes deeper than the machine's stack allows
    const std::vector<std::uint64_t> roots = rootNodes();
    for (std::size_t k = roots.size(); k-- > 0;) stack.push_back({roots[k], Pose{}, "the scene"});
    std::vector<bool> visited(array("nodes").size());
    while (!stack.empty()) {
      const Visit visit = std::move(stack.back());
      stack.pop_back();
      const Json& node = element("nodes", visit.node, visit.from);
      const std::string where = place("nodes", visit.node);
      if (visited[visit.node]) refuse(where, "is reached twice: nodes must form trees, without cycles");
      visited[visit.node] = true;
      const Pose local = poseOf(node, where);
      const Pose pose{visit.parent.linear * local.linear, visit.parent.linear * local.offset + visit.parent.offset};
      if (const std::optional<std::uint64_t> mesh = findUnsigned(node, "mesh", where)) addMesh(*mesh, node, pose, where);
      const std::vector<std::uint64_t> children = indexList(node, "children", where);
      spend(children.size());
      for (std::size_t k = children.size(); k-- > 0;) stack.push_back({children[k], pose, where});
    }
  }

  void addMesh(std::uint64_t index, const Json& node, const Pose& pose, const std::string& from) {
    const Json& mesh = element("meshes", index, from);
    const std::string where = place("meshes", index);
    const std::string node_name = findText(node, "name");
    assembly_.beginPart(node_name.empty() ? findText(mesh, "name") : node_name);
    if (find(node, "skin")) has_skin_ = true;
    const Json* primitives = find(mesh, "primitives");
    if (!primitives || !primitives->is_array()) refuse(where, "has no array \"primitives\"");
    for (std::size_t k = 0; k < primitives->size(); ++k) addPrimitive((*primitives)[k], pose, where + "." + place("primitives", k));
  }

  void addPrimitive(const Json& primitive, const Pose& pose, const std::string& where) {
    spend(1);
    if (!primitive.is_object()) refuse(where, "is not an object");
    has_primitive_ = true;
    const std::uint64_t mode = findUnsigned(primitive, "mode", where).value_or(4);
    if (mode > 6) refuse(where + ".mode", "is " + std::to_string(mode) + ", which does not exist");
    if (mode < 4) {  // points and lines
      ++skipped_modes_;
      return;
    }
    const Json* attributes = find(primitive, "attributes");
    if (!attributes || !attributes->is_object()) refuse(where, "has no \"attributes\"");
    const Positions& points = positions(getUnsigned(*attributes, "POSITION", where + ".attributes"), where);

    std::optional<Elements> indices;
    if (const std::optional<std::uint64_t> accessor = findUnsigned(primitive, "indices", where)) {
      const Json& object = element("accessors", *accessor, where);
      const std::string indices_where = place("accessors", *accessor);
      if (findText(object, "type") != "SCALAR") refuse(indices_where, "holds indices, but is not of type SCALAR");
      if (find(object, "sparse")) refuse(indices_where, "holds indices in sparse form, which is not read here");
      const std::uint64_t count = getUnsigned(object, "count", indices_where);
      if (count == 0) refuse(indices_where, "has no element");
      indices = open(object, getUnsigned(object, "bufferView", indices_where), count,
                     componentOf(object, {kUint8, kUint16, kUint32}, indices_where), 1, false, indices_where);
    }
    const std::uint64_t corners = indices ? indices->count : points.count;
    if (mode == 4 ? corners % 3 != 0 : corners < 3)
      refuse(where, "has " + std::to_string(corners) + " corners, which make no whole number of triangles");
    const std::uint64_t triangles = mode == 4 ? corners / 3 : corners - 2;
    spend(triangles);

    const bool is_mirrored = pose.linear.determinant() < 0;
    for (std::uint64_t t = 0; t < triangles; ++t) {
      std::array<std::uint64_t, 3> corner = mode == 4   ? std::array{3 * t, 3 * t + 1, 3 * t + 2}
                                            : mode == 5 ? std::array{t, t + 1 + t % 2, t + 2 - t % 2}
                                                        : std::array{t + 1, t + 2, std::uint64_t{0}};
      if (indices) {
        for (std::uint64_t& c : corner) {
          c = indices->unsignedAt(c);
          if (c >= points.count)
            refuse(where, "names vertex " + std::to_string(c) + " in triangle " + std::to_string(t) + ", but there are only " +
                              std::to_string(points.count));
        }
      }
      // Strips repeat vertices to turn a corner; such triangles are not meant.
      if (mode == 5 && (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0])) continue;
      if (is_mirrored) std::swap(corner[1], corner[2]);
      for (const std::uint64_t c : corner) {
        // Equal corners give equal places, and so are welded in the end.
        const Eigen::Vector3d p = pose.linear * points.at(c) + pose.offset;
        if (!assembly_.addVertex(p.x(), p.y(), p.z()))
          refuse(where, "has a vertex (" + std::to_string(c) + " of " + points.where + ") that is not a finite point in mm");
      }
      const std::uint32_t last = assembly_.vertexCount();
      assembly_.addTriangle(last - 3, last - 2, last - 1);
    }
  }

  /// Bounds time and memory: small files can name the same mesh very often.
  void spend(std::uint64_t work) {
    if (work > work_left_)
      assembly_.refuse("its nodes repeat meshes to more than " + std::to_string(std::max<std::uint64_t>(kMinWorkLimit, bytes_.size())) +
                       " triangles. Export one mesh without instances.");
    work_left_ -= work;
  }

  MeshAssembly assembly_;
  std::span<const char> bytes_, binary_chunk_;
  std::filesystem::path folder_;
  std::uint64_t work_left_, external_bytes_ = 0;
  Json root_;
  std::vector<Buffer> buffers_;
  std::map<std::string, std::vector<std::byte>> files_;
  std::map<std::uint64_t, Positions> positions_;
  std::size_t skipped_modes_ = 0;
  bool has_skin_ = false, has_primitive_ = false;
};

}  // namespace

MeshFile readGltf(std::span<const char> bytes, const std::string& name, const std::filesystem::path& folder) {
  return GltfReader(bytes, name, folder).read();
}

}  // namespace spheretree::formats
