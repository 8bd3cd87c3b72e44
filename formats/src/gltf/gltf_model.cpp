// SPDX-License-Identifier: Apache-2.0
#include "gltf/gltf_model.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <map>
#include <set>
#include <string_view>

#include "gltf/draco_mesh.h"
#include "gltf/gltf_buffers.h"
#include "gltf/gltf_json.h"
#include "gltf/meshopt_view.h"
#include "text/text_scan.h"

namespace spheretree::formats {
namespace {

constexpr std::size_t kMaxElements = 1'000'000;  // nodes, meshes and so on: an empty one takes up to 200 bytes here
constexpr std::uint64_t kMinWorkLimit =
    4'000'000;                             // total number of triangles, primitives and nodes that instances may have in a small file
constexpr std::uint64_t kMaxSkinSets = 8;  // with four joints each
constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

using Components = std::initializer_list<std::uint64_t>;
constexpr Components kPositionTypes = {kFloat32, kInt8, kUint8, kInt16, kUint16};
constexpr Components kJointTypes = {kUint8, kUint16};
constexpr Components kWeightTypes = {kFloat32, kUint8, kUint16};
constexpr Components kIndexTypes = {kUint8, kUint16, kUint32};

bool isOneOf(Components allowed, std::uint64_t component) { return std::find(allowed.begin(), allowed.end(), component) != allowed.end(); }

class GltfDocument : private GltfJson {
 public:
  GltfDocument(std::span<const char> bytes, const std::filesystem::path& folder, MeshAssembly& assembly)
      : GltfJson(bytes, assembly), assembly_(assembly), buffers_(*this, folder, assembly), triangles_left_(gltfWorkLimit(bytes.size())) {
    if (bytesAfterEnd()) assembly_.note(std::to_string(bytesAfterEnd()) + " bytes after the end of the GLB were ignored.");
    checkVersion();
    checkExtensions();
  }

  GltfModel load() {
    // Unneeded elements keep their index, but have no content.
    const auto reserve = [&](const char* key, auto& elements) {
      spend(array(key).size());
      elements.resize(array(key).size());
    };
    reserve("buffers", model_.buffers);
    reserve("bufferViews", model_.views);
    reserve("accessors", model_.accessors);
    reserve("meshes", model_.meshes);
    reserve("nodes", model_.nodes);
    reserve("scenes", model_.scenes);
    reserve("skins", model_.skins);
    for (std::size_t n = 0; n < model_.nodes.size(); ++n) {
      addNode(n);
      if (model_.nodes[n].mesh && !model_.nodes[n].weights.empty()) weighted_nodes_.emplace(*model_.nodes[n].mesh, n);
    }
    std::vector<bool> is_used(model_.meshes.size());
    for (std::size_t n = 0; n < model_.nodes.size(); ++n) {
      const std::optional<std::size_t> mesh = model_.nodes[n].mesh;
      if (!mesh || is_used[*mesh]) continue;
      is_used[*mesh] = true;
      addMesh(*mesh, place("nodes", n));
    }
    model_.scene = findUnsigned(root(), "scene", "the file");
    if (model_.scene || !model_.scenes.empty()) {
      const std::size_t index = model_.scene.value_or(0);
      const Json& scene = element("scenes", index, "\"scene\"");
      model_.scenes[index] = indices(scene, "nodes", "nodes", place("scenes", index));
    }
    model_.animations = array("animations").size();
    buffers_.moveInto(model_.opened);
    return std::move(model_);
  }

 private:
  void checkVersion() const {
    const Json* asset = find(root(), "asset");
    if (!asset || !asset->is_object()) refuse("asset", "is missing");
    const std::string version = findText(*asset, "version"), smallest = findText(*asset, "minVersion");
    if (!version.starts_with("2."))
      assembly_.refuse("is glTF of version " + inQuotes(version) + "; only 2.0 is read. Export it as glTF 2.0.");
    if (!smallest.empty() && smallest != "2.0")
      assembly_.refuse("needs glTF " + inQuotes(smallest) + "; only 2.0 is read. Export it as glTF 2.0.");
  }

  void checkExtensions() const {
    static constexpr std::string_view kKnown[] = {
        "KHR_mesh_quantization",      "EXT_meshopt_compression", "KHR_meshopt_compression", "EXT_mesh_gpu_instancing",
        "KHR_draco_mesh_compression", "KHR_lights_punctual",     "KHR_animation_pointer",   "KHR_xmp_json_ld",
        "KHR_node_visibility"};
    static constexpr std::string_view kHarmlessKinds[] = {"KHR_materials_", "KHR_texture_", "EXT_texture_", "MSFT_texture_", "EXT_lights_"};
    for (const Json& entry : array("extensionsRequired")) {
      if (!entry.is_string()) refuse("extensionsRequired", "holds something other than names");
      const std::string name = entry.get<std::string>();
      const auto is_kind = [&](std::string_view kind) { return name.starts_with(kind); };
      if (std::find(std::begin(kKnown), std::end(kKnown), name) != std::end(kKnown)) continue;
      if (std::any_of(std::begin(kHarmlessKinds), std::end(kHarmlessKinds), is_kind)) continue;
      assembly_.refuse("requires the extension " + inQuotes(name) +
                       ", which is not supported. Export the mesh without it, or convert it to OBJ, STL or PLY.");
    }
  }

  void spend(std::size_t more) {
    if (more > kMaxElements - elements_)
      assembly_.refuse("has more than " + std::to_string(kMaxElements) +
                       " nodes, meshes, primitives and accessors. Export one mesh alone.");
    elements_ += more;
  }

  // --- values ---

  /// Indices into the array `of`; empty if `object` has no `key`.
  std::vector<std::size_t> indices(const Json& object, const char* key, const char* of, const std::string& where) const {
    std::vector<std::size_t> list;
    const Json* found = find(object, key);
    if (!found) return list;
    if (!found->is_array()) refuse(where + "." + key, "is not an array");
    for (const Json& entry : *found) list.push_back(checked(of, asUnsigned(entry, where + "." + key), where));
    return list;
  }

  std::size_t checked(const char* of, std::uint64_t index, const std::string& from) const {
    element(of, index, from);
    return index;
  }

  std::vector<double> numbers(const Json& node, const char* key, std::size_t size, const std::string& where) const {
    const Json* found = find(node, key);
    if (!found) return {};
    if (!found->is_array() || found->size() != size ||
        !std::all_of(found->begin(), found->end(), [](const Json& n) { return n.is_number(); }))
      refuse(where + "." + key, "is not an array of " + std::to_string(size) + " numbers");
    return found->get<std::vector<double>>();
  }

  /// The weights of morph targets; empty if there are none that are numbers.
  static std::vector<double> weights(const Json& object) {
    const Json* found = find(object, "weights");
    const bool are_numbers =
        found && found->is_array() && std::all_of(found->begin(), found->end(), [](const Json& n) { return n.is_number(); });
    return are_numbers ? found->get<std::vector<double>>() : std::vector<double>();
  }

  std::uint64_t componentOf(const Json& object, Components allowed, const std::string& where) const {
    const std::uint64_t component = getUnsigned(object, "componentType", where);
    if (!isOneOf(allowed, component)) refuse(where, "has componentType " + std::to_string(component) + ", which does not fit its use");
    return component;
  }

  // --- nodes and meshes ---

  void addNode(std::size_t index) {
    const Json& from = element("nodes", index, "");
    const std::string where = place("nodes", index);
    GltfModel::Node& node = model_.nodes[index];
    node.name = findText(from, "name");
    node.matrix = numbers(from, "matrix", 16, where);
    if (node.matrix.empty()) {
      node.rotation = numbers(from, "rotation", 4, where);
      node.scale = numbers(from, "scale", 3, where);
      node.translation = numbers(from, "translation", 3, where);
    }
    node.children = indices(from, "children", "nodes", where);
    node.weights = weights(from);
    if (const Json* visibility = findExtension(from, "KHR_node_visibility"))
      if (const Json* visible = find(*visibility, "visible")) node.is_visible = !visible->is_boolean() || visible->get<bool>();
    const std::optional<std::uint64_t> mesh = findUnsigned(from, "mesh", where);
    if (!mesh) return;
    node.mesh = checked("meshes", *mesh, where);
    if (const Json* instancing = findExtension(from, kInstancing)) node.instances = instances(*instancing, where + "." + kInstancing);
    if (const std::optional<std::uint64_t> skin = findUnsigned(from, "skin", where)) {
      addSkin(*skin, where);
      node.skin = *skin;
    }
  }

  GltfModel::Instances instances(const Json& instancing, const std::string& where) {
    const Json& attributes = getObject(instancing, "attributes", where);
    const auto numbersOf = [&](const char* key, const char* type) -> std::optional<std::size_t> {
      const std::optional<std::uint64_t> accessor = findUnsigned(attributes, key, where);
      if (accessor) addAccessor(*accessor, type, kPositionTypes, where);
      return accessor;
    };
    const GltfModel::Instances result{numbersOf("TRANSLATION", "VEC3"), numbersOf("ROTATION", "VEC4"), numbersOf("SCALE", "VEC3")};
    if (!result.translation && !result.rotation && !result.scale) refuse(where, "has neither TRANSLATION nor ROTATION nor SCALE");
    return result;
  }

  void addSkin(std::uint64_t index, const std::string& from) {
    const Json& skin = element("skins", index, from);
    const std::string where = place("skins", index);
    GltfModel::Skin result{indices(skin, "joints", "nodes", where), findUnsigned(skin, "inverseBindMatrices", where)};
    if (result.joints.empty()) refuse(where, "has no joints");
    if (result.inverse_bind_matrices) addAccessor(*result.inverse_bind_matrices, "MAT4", {kFloat32}, where);
    model_.skins[index] = std::move(result);
  }

  void addMesh(std::size_t index, const std::string& from) {
    const Json& mesh = element("meshes", index, from);
    const std::string where = place("meshes", index);
    model_.meshes[index].name = findText(mesh, "name");
    model_.meshes[index].weights = weights(mesh);
    moving_targets_.clear();
    const auto addWeights = [&](const std::vector<double>& all) {
      for (std::size_t k = 0; k < all.size(); ++k)
        if (all[k] != 0) moving_targets_.insert(k);
    };
    addWeights(model_.meshes[index].weights);
    const auto [first, last] = weighted_nodes_.equal_range(index);
    for (auto at = first; at != last; ++at) addWeights(model_.nodes[at->second].weights);
    const Json* primitives = find(mesh, "primitives");
    if (!primitives || !primitives->is_array()) refuse(where, "has no array \"primitives\"");
    spend(primitives->size());
    for (std::size_t k = 0; k < primitives->size(); ++k)
      model_.meshes[index].primitives.push_back(primitive((*primitives)[k], where + "." + place("primitives", k)));
  }

  GltfModel::Primitive primitive(const Json& object, const std::string& where) {
    if (!object.is_object()) refuse(where, "is not an object");
    GltfModel::Primitive result;
    result.mode = findUnsigned(object, "mode", where).value_or(4);
    if (result.mode > 6) refuse(where + ".mode", "is " + std::to_string(result.mode) + ", which does not exist");
    if (result.mode < 4) return result;  // points and lines
    const Json& attributes = getObject(object, "attributes", where);
    if (const Json* draco = findExtension(object, "KHR_draco_mesh_compression")) {
      result = unpacked(*draco, attributes, result.mode, where);
      result.colour = baseColour(object);
      result.morph_targets = morphTargets(object, where);
      return result;
    }
    result.colour = baseColour(object);
    result.positions = getUnsigned(attributes, "POSITION", where + ".attributes");
    addAccessor(result.positions, "VEC3", kPositionTypes, where);
    const std::vector<std::string> keys = skinAttributes(attributes);
    for (std::size_t k = 0; k < keys.size(); k += 2) {
      const auto accessor = [&](const std::string& key, Components allowed) {
        const std::uint64_t index = getUnsigned(attributes, key.c_str(), where + ".attributes");
        addAccessor(index, "VEC4", allowed, where);
        return index;
      };
      const std::size_t joints = accessor(keys[k], kJointTypes);
      result.skin_sets.emplace_back(joints, accessor(keys[k + 1], kWeightTypes));
    }
    result.indices = findUnsigned(object, "indices", where);
    if (result.indices) addIndices(*result.indices, where);
    result.morph_targets = morphTargets(object, where);
    return result;
  }

  /// The base colour of its material (section 3.9.2). Colours are only for viewing: one that is missing or invalid is
  /// white.
  std::array<std::uint8_t, 3> baseColour(const Json& primitive) const {
    std::array<std::uint8_t, 3> out{255, 255, 255};
    const Json *index = find(primitive, "material"), *materials = find(root(), "materials");
    if (!index || !index->is_number_unsigned() || !materials || !materials->is_array()) return out;
    const auto at = index->get<std::size_t>();
    const Json* surface = at < materials->size() ? find((*materials)[at], "pbrMetallicRoughness") : nullptr;
    const Json* factor = surface ? find(*surface, "baseColorFactor") : nullptr;
    if (!factor || !factor->is_array() || factor->size() != 4) return out;
    for (std::size_t k = 0; k < 3; ++k)
      if ((*factor)[k].is_number())  // linear
        out[k] = static_cast<std::uint8_t>(std::lround(255 * std::sqrt(std::clamp((*factor)[k].get<double>(), 0.0, 1.0))));
    return out;
  }

  /// Those that some weight moves; others are not read.
  std::vector<std::optional<std::size_t>> morphTargets(const Json& primitive, const std::string& where) {
    std::vector<std::optional<std::size_t>> targets;
    const Json* found = find(primitive, "targets");
    if (!found) return targets;
    for (const std::size_t k : moving_targets_) {
      if (!found->is_array()) refuse(where + ".targets", "is not an array");
      if (k >= found->size()) break;
      const Json& target = (*found)[k];
      const std::string target_where = where + "." + place("targets", k);
      if (!target.is_object()) refuse(target_where, "is not an object");
      targets.resize(k + 1);
      targets[k] = findUnsigned(target, "POSITION", target_where);
      if (targets[k]) addAccessor(*targets[k], "VEC3", kPositionTypes, target_where);
    }
    return targets;
  }

  /// JOINTS_0, WEIGHTS_0, JOINTS_1, ... up to the first incomplete pair.
  static std::vector<std::string> skinAttributes(const Json& attributes) {
    std::vector<std::string> keys;
    for (std::uint64_t set = 0; set < kMaxSkinSets; ++set) {
      const std::string joints = "JOINTS_" + std::to_string(set), weights = "WEIGHTS_" + std::to_string(set);
      if (!attributes.contains(joints) || !attributes.contains(weights)) break;
      keys.insert(keys.end(), {joints, weights});
    }
    return keys;
  }

  // --- accessors and views ---

  void addAccessor(std::uint64_t index, const std::string& type, Components allowed, const std::string& from) {
    const Json& object = element("accessors", index, from);
    const std::string where = place("accessors", index);
    if (findText(object, "type") != type) refuse(where, "is used by " + from + ", but is not of type " + type);
    GltfModel::Accessor result = accessor(object, allowed, where);
    result.components = type == "MAT4" ? 16 : type == "VEC4" ? 4 : 3;
    if (const Json* normalised = find(object, "normalized")) {
      if (!normalised->is_boolean()) refuse(where + ".normalized", "is not true or false");
      result.is_normalised = normalised->get<bool>();
    }
    if (const Json* sparse = find(object, "sparse")) result.sparse = sparseOf(*sparse, result.count, where + ".sparse");
    model_.accessors[index] = result;
  }

  GltfModel::Sparse sparseOf(const Json& sparse, std::uint64_t all, const std::string& where) {
    if (!sparse.is_object()) refuse(where, "is not an object");
    const Json &indices = getObject(sparse, "indices", where), &values = getObject(sparse, "values", where);
    const std::string indices_where = where + ".indices", values_where = where + ".values";
    GltfModel::Sparse result;
    result.count = getUnsigned(sparse, "count", where);
    if (result.count == 0 || result.count > all)
      refuse(where, "replaces " + std::to_string(result.count) + " of " + std::to_string(all) + " elements");
    result.indices_view = addView(getUnsigned(indices, "bufferView", indices_where), indices_where);
    result.component = componentOf(indices, kIndexTypes, indices_where);
    result.indices_offset = findUnsigned(indices, "byteOffset", indices_where).value_or(0);
    result.values_view = addView(getUnsigned(values, "bufferView", values_where), values_where);
    result.values_offset = findUnsigned(values, "byteOffset", values_where).value_or(0);
    return result;
  }

  void addIndices(std::uint64_t index, const std::string& from) {
    const Json& object = element("accessors", index, from);
    const std::string where = place("accessors", index);
    if (findText(object, "type") != "SCALAR") refuse(where, "holds indices, but is not of type SCALAR");
    if (find(object, "sparse")) refuse(where, "holds indices in sparse form, which is not supported");
    getUnsigned(object, "bufferView", where);
    model_.accessors[index] = accessor(object, kIndexTypes, where);
  }

  GltfModel::Accessor accessor(const Json& object, Components allowed, const std::string& where) {
    GltfModel::Accessor result;
    result.component = componentOf(object, allowed, where);
    result.count = getUnsigned(object, "count", where);
    if (result.count == 0) refuse(where, "has no element");
    if (const std::optional<std::uint64_t> view = findUnsigned(object, "bufferView", where)) result.view = addView(*view, where);
    result.offset = findUnsigned(object, "byteOffset", where).value_or(0);
    return result;
  }

  std::size_t addView(std::uint64_t index, const std::string& from) {
    const Json& object = element("bufferViews", index, from);
    const std::string where = place("bufferViews", index);
    GltfModel::View& view = model_.views[index];
    if (view.length > 0) return index;  // it exists already
    view.length = getUnsigned(object, "byteLength", where);
    if (view.length == 0) refuse(where, "has no bytes");
    if (const std::optional<std::uint64_t> stride = findUnsigned(object, "byteStride", where)) {
      if (*stride == 0 || *stride > 252 || *stride % 4 != 0)
        refuse(where, "has a byteStride of " + std::to_string(*stride) + ", not a multiple of 4 from 4 to 252");
      view.stride = *stride;
    }
    const Json* compressed = findExtension(object, "EXT_meshopt_compression");
    if (!compressed) compressed = findExtension(object, "KHR_meshopt_compression");
    if (compressed) {
      view.buffer = addBuffer(unpackedView(*compressed, view.length, where));
    } else {
      view.buffer = checked("buffers", getUnsigned(object, "buffer", where), where);
      view.offset = findUnsigned(object, "byteOffset", where).value_or(0);
      model_.buffers[view.buffer] = buffers_.bytes(view.buffer);
    }
    return index;
  }

  std::size_t addBuffer(std::vector<unsigned char> bytes) {
    model_.opened.push_back(std::move(bytes));
    model_.buffers.emplace_back(model_.opened.back());  // does not move when `opened` grows: moving a vector keeps its memory
    return model_.buffers.size() - 1;
  }

  // --- compressed data ---

  std::vector<unsigned char> unpackedView(const Json& compressed, std::uint64_t byte_length, const std::string& where) {
    const std::uint64_t buffer = getUnsigned(compressed, "buffer", where), length = getUnsigned(compressed, "byteLength", where);
    const std::string filter = findText(compressed, "filter");
    const MeshoptView view{.bytes = buffers_.part(buffer, findUnsigned(compressed, "byteOffset", where).value_or(0), length, where),
                           .count = getUnsigned(compressed, "count", where),
                           .stride = getUnsigned(compressed, "byteStride", where),
                           .mode = findText(compressed, "mode"),
                           .filter = filter.empty() ? "NONE" : filter};
    // Each compressed byte is decoded only once, so that a small file cannot decode the same bytes without end.
    std::uint64_t& unpacked_bytes = unpacked_bytes_[buffer];
    unpacked_bytes += length;
    if (unpacked_bytes > buffers_.bytes(buffer).size()) refuse(where, "unpacks bytes that another view unpacks, too");
    std::vector<unsigned char> data = decodeMeshopt(view, assembly_, where);
    if (data.size() != byte_length)
      refuse(where, "announces " + std::to_string(byte_length) + " bytes, but unpacks to " + std::to_string(data.size()));
    return data;
  }

  GltfModel::Primitive unpacked(const Json& draco, const Json& attributes, std::uint64_t mode, const std::string& where) {
    if (mode == 6) refuse(where, "is a fan, which Draco does not compress");
    const Json& packed = getObject(draco, "attributes", where);
    std::vector<std::string> keys = skinAttributes(attributes);
    keys.insert(keys.begin(), "POSITION");
    std::vector<std::uint64_t> ids;
    for (const std::string& key : keys) ids.push_back(getUnsigned(packed, key.c_str(), where + ".KHR_draco_mesh_compression.attributes"));
    const std::uint64_t view_index = getUnsigned(draco, "bufferView", where);
    const auto [entry, is_new] = unpacked_primitives_.try_emplace({view_index, ids});
    if (!is_new) return entry->second;
    const Json& view = element("bufferViews", view_index, where);
    const std::string view_where = place("bufferViews", view_index);
    const auto bytes = buffers_.part(getUnsigned(view, "buffer", view_where), findUnsigned(view, "byteOffset", view_where).value_or(0),
                                     getUnsigned(view, "byteLength", view_where), view_where);
    return entry->second = addUnpacked(decodeDraco(bytes, ids, triangles_left_, assembly_, where), where);
  }

  /// Its attributes are the positions, then pairs of joints and weights.
  GltfModel::Primitive addUnpacked(DracoMesh mesh, const std::string& where) {
    triangles_left_ -= std::min<std::uint64_t>(triangles_left_, mesh.corners.size() / 3);
    const auto add = [&](std::size_t k, std::size_t components, Components allowed, const char* name) {
      DracoAttribute& attribute = mesh.attributes[k];
      if (attribute.components != components || !isOneOf(allowed, attribute.component))
        refuse(where, "has Draco data in which " + std::string(name) + " are of a type that does not fit their use");
      return addUnpackedAccessor(std::move(attribute.bytes), {.view = {},
                                                              .count = mesh.vertex_count,
                                                              .component = attribute.component,
                                                              .components = components,
                                                              .is_normalised = attribute.is_normalised,
                                                              .sparse = {}});
    };
    GltfModel::Primitive primitive;  // triangles, even for a strip
    primitive.positions = add(0, 3, kPositionTypes, "positions");
    for (std::size_t k = 1; k < mesh.attributes.size(); k += 2) {
      const std::size_t joints = add(k, 4, kJointTypes, "joints");
      primitive.skin_sets.emplace_back(joints, add(k + 1, 4, kWeightTypes, "weights"));
    }
    std::vector<unsigned char> corners;
    corners.reserve(mesh.corners.size() * 4);
    for (const std::uint32_t corner : mesh.corners)
      for (int shift = 0; shift < 32; shift += 8) corners.push_back(static_cast<unsigned char>(corner >> shift));
    primitive.indices =
        addUnpackedAccessor(std::move(corners), {.view = {}, .count = mesh.corners.size(), .component = kUint32, .sparse = {}});
    return primitive;
  }

  std::size_t addUnpackedAccessor(std::vector<unsigned char> bytes, GltfModel::Accessor accessor) {
    const std::uint64_t length = bytes.size();
    accessor.view = model_.views.size();
    model_.views.push_back({.buffer = addBuffer(std::move(bytes)), .length = length});
    model_.accessors.push_back(accessor);
    return model_.accessors.size() - 1;
  }

  MeshAssembly& assembly_;
  GltfBuffers buffers_;
  GltfModel model_;
  std::size_t elements_ = 0;
  std::multimap<std::size_t, std::size_t> weighted_nodes_;  // of each mesh
  std::set<std::size_t> moving_targets_;                    // of the current mesh: those that have a weight at some node
  std::uint64_t triangles_left_;                            // remaining limit for compressed primitives
  std::map<std::uint64_t, std::uint64_t> unpacked_bytes_;   // decoded so far, for each buffer
  std::map<std::pair<std::uint64_t, std::vector<std::uint64_t>>, GltfModel::Primitive> unpacked_primitives_;
};

}  // namespace

std::uint64_t gltfWorkLimit(std::uint64_t file_bytes) { return std::max(kMinWorkLimit, file_bytes); }

GltfModel loadGltfModel(std::span<const char> bytes, const std::filesystem::path& folder, MeshAssembly& assembly) {
  return GltfDocument(bytes, folder, assembly).load();
}

}  // namespace spheretree::formats
