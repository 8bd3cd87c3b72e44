// SPDX-License-Identifier: Apache-2.0
// tinygltf 2.7.0 reads up to 8 bytes beyond a truncated GLB, recurses without limit into nested extras, takes
// properties of a wrong type for missing ones, narrows indices to 32 bits, and refuses a mesh for the sake of its
// images. What it is given is therefore a document made here: only what a mesh needs, every property of its right type,
// every index within its array, every buffer of its exact size.
#include "gltf_model.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "gltf_uris.h"
#include "little_endian.h"
#include "text_scan.h"

namespace spheretree::formats {
namespace {

using Json = nlohmann::json;

constexpr int kMaxJsonDepth = 64;                // glTF itself needs 8; extras are free
constexpr std::size_t kMaxElements = 1'000'000;  // nodes, meshes and so on: in tinygltf an empty one takes half a kilobyte
constexpr std::uint64_t kMaxInt = std::numeric_limits<int>::max();  // tinygltf's type for indices and for all numbers of `sparse`

class GltfDocument {
 public:
  GltfDocument(std::span<const char> bytes, const std::filesystem::path& folder, MeshAssembly& assembly)
      : assembly_(assembly), uris_(folder, assembly) {
    if (!isGlb(bytes) && std::find(bytes.begin(), bytes.end(), '\0') != bytes.end())
      assembly.refuse(
          "does not begin with \"glTF\", as a GLB does, and is no text, as a .gltf is. The file is damaged, of another kind, or in "
          "UTF-16.");
    parse(isGlb(bytes) ? openContainer(bytes) : asText(bytes, assembly.name()));
    checkVersion();
    checkExtensions();
  }

  tinygltf::Model load() {
    const std::string text = cleaned();
    if (text.size() > std::numeric_limits<unsigned>::max()) assembly_.refuse("its JSON is larger than 4 GiB. Export fewer nodes.");
    tinygltf::TinyGLTF loader;
    loader.SetFsCallbacks({.FileExists = [](const std::string&, void*) { return true; },
                           .ExpandFilePath = [](const std::string& name, void*) { return name; },
                           .ReadWholeFile =
                               [](std::vector<unsigned char>* data, std::string*, const std::string& name, void* document) {
                                 *data = static_cast<GltfDocument*>(document)->buffer(name);
                                 return true;
                               },
                           .WriteWholeFile = nullptr,
                           .user_data = this});
    tinygltf::Model model;
    std::string error, warning;
    if (!loader.LoadASCIIFromString(&model, &error, &warning, text.data(), static_cast<unsigned>(text.size()), "", tinygltf::NO_REQUIRE))
      assembly_.refuse("is not valid glTF 2.0: " + error.substr(0, error.find('\n')) + ". Export it again.");
    return model;
  }

 private:
  // --- container and JSON ---

  std::span<const char> openContainer(std::span<const char> bytes) {
    constexpr std::uint32_t kJsonChunk = 0x4e4f534a, kBinChunk = 0x004e4942;
    if (bytes.size() < 20)
      assembly_.refuse("is a GLB of only " + std::to_string(bytes.size()) + " bytes. It is cut off: copy or export it again.");
    if (const std::uint32_t version = littleUint32(bytes.data() + 4); version != 2)
      assembly_.refuse("is GLB of version " + std::to_string(version) + "; only version 2 is read. Export it as glTF 2.0.");
    const std::uint32_t length = littleUint32(bytes.data() + 8);
    if (length > bytes.size())
      assembly_.refuse("has " + std::to_string(bytes.size()) + " of the " + std::to_string(length) +
                       " bytes that its header announces. It is cut off: copy or export it again.");
    if (length < bytes.size()) assembly_.note(std::to_string(bytes.size() - length) + " bytes after the end of the GLB were ignored.");
    std::span<const char> rest = bytes.first(length), json;
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

  [[noreturn]] void refuse(const std::string& where, const std::string& what) const { refuseElement(assembly_, where, what); }

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

  // --- the document for tinygltf ---

  std::string cleaned() {
    // What no mesh needs keeps its place, so that indices stay, but nothing of its contents.
    std::size_t elements = 0;
    const auto reserve = [&](const char* key, const Json& nothing) {
      const std::size_t size = array(key).size();
      spend(elements, size);
      clean_[key] = Json::array_t(size, nothing);
    };
    clean_ = {{"asset", {{"version", "2.0"}}}};
    reserve("buffers", {{"byteLength", 1}, {"uri", kUnused}});
    reserve("bufferViews", {{"buffer", 0}, {"byteLength", 1}});
    reserve("accessors", {{"componentType", 5126}, {"count", 1}, {"type", "SCALAR"}});
    reserve("meshes", Json::object());
    reserve("nodes", Json::object());
    reserve("scenes", Json::object());
    std::vector<bool> is_used(array("meshes").size());
    for (std::uint64_t n = 0; n < array("nodes").size(); ++n) {
      const std::optional<std::uint64_t> mesh = addNode(n);
      if (!mesh || is_used[*mesh]) continue;
      is_used[*mesh] = true;
      addMesh(*mesh, place("nodes", n), elements);
    }
    const std::optional<std::uint64_t> scene = findUnsigned(root_, "scene", "the file");
    if (scene || !array("scenes").empty()) {
      const std::uint64_t index = scene.value_or(0);
      copyIndices(clean_["scenes"][checked("scenes", index, "\"scene\"")], element("scenes", index, "\"scene\""), "nodes", "nodes",
                  place("scenes", index));
      if (scene) clean_["scene"] = index;
    }
    const std::string text = clean_.dump();
    clean_ = nullptr;
    return text;
  }

  void spend(std::size_t& elements, std::size_t more) const {
    if (more > kMaxElements - elements)
      assembly_.refuse("has more than " + std::to_string(kMaxElements) +
                       " nodes, meshes, primitives and accessors. Export one mesh alone.");
    elements += more;
  }

  std::uint64_t checked(const char* key, std::uint64_t index, const std::string& from) const {
    element(key, index, from);
    return index;
  }

  void copyUnsigned(Json& to, const Json& object, const char* key, const std::string& where,
                    std::uint64_t largest = std::numeric_limits<std::uint64_t>::max()) const {
    const std::optional<std::uint64_t> found = findUnsigned(object, key, where);
    if (!found) return;
    if (*found > largest) refuse(where + "." + key, "is " + std::to_string(*found) + ", which is too large");
    to[key] = *found;
  }

  void copyIndices(Json& to, const Json& object, const char* key, const char* array_key, const std::string& where) const {
    const Json* found = find(object, key);
    if (!found) return;
    if (!found->is_array()) refuse(where + "." + key, "is not an array");
    Json list = Json::array();
    for (const Json& entry : *found) list.push_back(checked(array_key, asUnsigned(entry, where + "." + key), where));
    to[key] = std::move(list);
  }

  bool copyNumbers(Json& to, const Json& node, const char* key, std::size_t size, const std::string& where) const {
    const Json* found = find(node, key);
    if (!found) return false;
    if (!found->is_array() || found->size() != size ||
        !std::all_of(found->begin(), found->end(), [](const Json& n) { return n.is_number(); }))
      refuse(where + "." + key, "is not an array of " + std::to_string(size) + " numbers");
    to[key] = *found;
    return true;
  }

  /// Its mesh.
  std::optional<std::uint64_t> addNode(std::uint64_t index) {
    const Json& node = element("nodes", index, "");
    const std::string where = place("nodes", index);
    Json& clean = clean_["nodes"][index];
    if (const std::string name = findText(node, "name"); !name.empty()) clean["name"] = name;
    if (find(node, "skin")) clean["skin"] = 0;
    if (!copyNumbers(clean, node, "matrix", 16, where)) {
      copyNumbers(clean, node, "rotation", 4, where);
      copyNumbers(clean, node, "scale", 3, where);
      copyNumbers(clean, node, "translation", 3, where);
    }
    copyIndices(clean, node, "children", "nodes", where);
    const std::optional<std::uint64_t> mesh = findUnsigned(node, "mesh", where);
    if (mesh) clean["mesh"] = checked("meshes", *mesh, where);
    return mesh;
  }

  void addMesh(std::uint64_t index, const std::string& from, std::size_t& elements) {
    const Json& mesh = element("meshes", index, from);
    const std::string where = place("meshes", index);
    Json& clean = clean_["meshes"][index];
    if (const std::string name = findText(mesh, "name"); !name.empty()) clean["name"] = name;
    const Json* primitives = find(mesh, "primitives");
    if (!primitives || !primitives->is_array()) refuse(where, "has no array \"primitives\"");
    spend(elements, primitives->size());
    clean["primitives"] = Json::array();
    for (std::size_t k = 0; k < primitives->size(); ++k)
      clean["primitives"].push_back(primitive((*primitives)[k], where + "." + place("primitives", k)));
  }

  Json primitive(const Json& object, const std::string& where) {
    if (!object.is_object()) refuse(where, "is not an object");
    const std::uint64_t mode = findUnsigned(object, "mode", where).value_or(4);
    if (mode > 6) refuse(where + ".mode", "is " + std::to_string(mode) + ", which does not exist");
    Json clean = {{"mode", mode}, {"attributes", Json::object()}};
    if (mode < 4) return clean;  // points and lines
    const Json* attributes = find(object, "attributes");
    if (!attributes || !attributes->is_object()) refuse(where, "has no \"attributes\"");
    const std::uint64_t positions = getUnsigned(*attributes, "POSITION", where + ".attributes");
    addPositions(positions, where);
    clean["attributes"]["POSITION"] = positions;
    if (const std::optional<std::uint64_t> indices = findUnsigned(object, "indices", where)) {
      addIndices(*indices, where);
      clean["indices"] = *indices;
    }
    return clean;
  }

  void addPositions(std::uint64_t index, const std::string& from) {
    const Json& object = element("accessors", index, from);
    const std::string where = place("accessors", index);
    if (findText(object, "type") != "VEC3") refuse(where, "holds positions, but is not of type VEC3");
    Json clean = accessor(object, {kFloat32, kInt8, kUint8, kInt16, kUint16}, where);
    if (const Json* normalised = find(object, "normalized")) {
      if (!normalised->is_boolean()) refuse(where + ".normalized", "is not true or false");
      clean["normalized"] = *normalised;
    }
    if (const Json* sparse = find(object, "sparse")) {
      const std::string sparse_where = where + ".sparse";
      if (!sparse->is_object()) refuse(sparse_where, "is not an object");
      const std::uint64_t count = getUnsigned(*sparse, "count", sparse_where), all = clean["count"].get<std::uint64_t>();
      const Json *indices = find(*sparse, "indices"), *values = find(*sparse, "values");
      if (!indices || !indices->is_object() || !values || !values->is_object()) refuse(sparse_where, "lacks its indices or values");
      if (count == 0 || count > std::min(all, kMaxInt))
        refuse(sparse_where, "replaces " + std::to_string(count) + " of " + std::to_string(all) + " elements");
      Json& to = clean["sparse"] = {{"count", count}, {"indices", Json::object()}, {"values", Json::object()}};
      const std::string indices_where = sparse_where + ".indices", values_where = sparse_where + ".values";
      to["indices"]["bufferView"] = addView(getUnsigned(*indices, "bufferView", indices_where), indices_where);
      to["indices"]["componentType"] = componentOf(*indices, {kUint8, kUint16, kUint32}, indices_where);
      copyUnsigned(to["indices"], *indices, "byteOffset", indices_where, kMaxInt);
      to["values"]["bufferView"] = addView(getUnsigned(*values, "bufferView", values_where), values_where);
      copyUnsigned(to["values"], *values, "byteOffset", values_where, kMaxInt);
    }
    clean_["accessors"][index] = std::move(clean);
  }

  void addIndices(std::uint64_t index, const std::string& from) {
    const Json& object = element("accessors", index, from);
    const std::string where = place("accessors", index);
    if (findText(object, "type") != "SCALAR") refuse(where, "holds indices, but is not of type SCALAR");
    if (find(object, "sparse")) refuse(where, "holds indices in sparse form, which is not read here");
    getUnsigned(object, "bufferView", where);
    clean_["accessors"][index] = accessor(object, {kUint8, kUint16, kUint32}, where);
  }

  Json accessor(const Json& object, std::initializer_list<std::uint64_t> components, const std::string& where) {
    Json clean = {{"type", findText(object, "type")},
                  {"componentType", componentOf(object, components, where)},
                  {"count", getUnsigned(object, "count", where)}};
    if (clean["count"] == 0) refuse(where, "has no element");
    if (const std::optional<std::uint64_t> view = findUnsigned(object, "bufferView", where)) clean["bufferView"] = addView(*view, where);
    copyUnsigned(clean, object, "byteOffset", where);
    return clean;
  }

  std::uint64_t componentOf(const Json& object, std::initializer_list<std::uint64_t> allowed, const std::string& where) const {
    const std::uint64_t component = getUnsigned(object, "componentType", where);
    if (std::find(allowed.begin(), allowed.end(), component) == allowed.end())
      refuse(where, "has componentType " + std::to_string(component) + ", which does not fit its use");
    return component;
  }

  std::uint64_t addView(std::uint64_t index, const std::string& from) {
    const Json& view = element("bufferViews", index, from);
    const std::string where = place("bufferViews", index);
    const std::uint64_t buffer = getUnsigned(view, "buffer", where);
    Json clean = {{"buffer", buffer}, {"byteLength", getUnsigned(view, "byteLength", where)}};
    copyUnsigned(clean, view, "byteOffset", where);
    if (const std::optional<std::uint64_t> stride = findUnsigned(view, "byteStride", where)) {
      if (*stride == 0 || *stride > 252 || *stride % 4 != 0)
        refuse(where, "has a byteStride of " + std::to_string(*stride) + ", not a multiple of 4 from 4 to 252");
      clean["byteStride"] = *stride;
    }
    if (const Json* extensions = find(view, "extensions"); extensions && extensions->is_object())
      for (const char* name : kCompressedViews)
        if (extensions->contains(name)) clean["extensions"][name] = Json::object();
    const std::uint64_t length = getUnsigned(element("buffers", buffer, where), "byteLength", place("buffers", buffer));
    if (length == 0) refuse(place("buffers", buffer), "has no bytes");
    clean_["buffers"][buffer] = {{"byteLength", length}, {"uri", std::to_string(buffer)}};
    clean_["bufferViews"][index] = std::move(clean);
    return index;
  }

  // --- buffers ---

  /// Stands for all of tinygltf's access to files: `name` is what addView() wrote for a URI.
  std::vector<unsigned char> buffer(const std::string& name) {
    if (name == kUnused) return {0};
    std::uint64_t index = 0;
    std::from_chars(name.data(), name.data() + name.size(), index);
    const Json& object = element("buffers", index, "");
    const std::string where = place("buffers", index);
    const std::uint64_t length = getUnsigned(object, "byteLength", where);
    const Json* uri = find(object, "uri");
    if (uri && !uri->is_string()) refuse(where + ".uri", "is not text");
    if (!uri && (index != 0 || binary_chunk_.empty()))
      refuse(where, "has no data" + std::string(find(object, "extensions") ? " without its extensions" : ""));
    std::vector<unsigned char> data;
    if (uri)
      data = uris_.open(uri->get_ref<const std::string&>(), where);
    else
      data.assign(binary_chunk_.begin(), binary_chunk_.end());
    if (data.size() < length) refuse(where, "announces " + std::to_string(length) + " bytes, but has " + std::to_string(data.size()));
    data.resize(length);
    return data;
  }

  static constexpr const char* kUnused = "unused";

  MeshAssembly& assembly_;
  std::span<const char> binary_chunk_;
  GltfUris uris_;
  Json root_, clean_;
};

}  // namespace

bool isGlb(std::span<const char> bytes) { return bytes.size() >= 4 && std::string_view(bytes.data(), 4) == "glTF"; }

std::string place(const std::string& key, std::uint64_t index) { return key + "[" + std::to_string(index) + "]"; }

void refuseElement(const MeshAssembly& assembly, const std::string& where, const std::string& what) {
  assembly.refuse(where + " " + what + ". The file is damaged or not valid glTF 2.0: export it again.");
}

tinygltf::Model loadGltfModel(std::span<const char> bytes, const std::filesystem::path& folder, MeshAssembly& assembly) {
  return GltfDocument(bytes, folder, assembly).load();
}

}  // namespace spheretree::formats
