// SPDX-License-Identifier: Apache-2.0
// Specification: Khronos, glTF 2.0, ISO/IEC 12113:2022. Section numbers below are of that.
#include "spheretree/formats/gltf.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "gltf_model.h"
#include "little_endian.h"

namespace spheretree::formats {
namespace {

constexpr std::uint64_t kMinWorkLimit = 4'000'000;  // triangles, primitives and nodes that instances may add up to in a small file

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
  const unsigned char* first = nullptr;
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
  GltfReader(std::span<const char> bytes, const std::string& name, const std::filesystem::path& folder, double unit_mm)
      : assembly_(name, unit_mm),
        format_(isGlb(bytes) ? "GLB" : "glTF"),
        work_limit_(std::max<std::uint64_t>(kMinWorkLimit, bytes.size())),
        work_left_(work_limit_),
        model_(loadGltfModel(bytes, folder, assembly_)) {}

  MeshFile read() {
    visitNodes();
    if (has_skin_) assembly_.note("Skins were not applied: the mesh is read in the pose in which it is stored.");
    if (skipped_modes_) assembly_.note(std::to_string(skipped_modes_) + " primitives of points or lines were left out.");
    if (!has_primitive_) assembly_.refuse("no node of its scene has a mesh. Export the scene again with its meshes.");
    return assembly_.finish(format_);
  }

 private:
  [[noreturn]] void refuse(const std::string& where, const std::string& what) const { refuseElement(assembly_, where, what); }

  // --- accessors ---

  /// `count` elements in a bufferView from `start` on.
  Elements open(int view_index, std::uint64_t start, std::uint64_t count, std::uint64_t component, std::size_t components, bool may_stride,
                const std::string& where) {
    const tinygltf::BufferView& view = model_.bufferViews[static_cast<std::size_t>(view_index)];
    const std::string view_where = place("bufferViews", static_cast<std::uint64_t>(view_index));
    for (const char* name : kCompressedViews)
      if (view.extensions.contains(name)) assembly_.note(view_where + " was read as its fallback without " + name + ".");
    const std::vector<unsigned char>& data = model_.buffers[static_cast<std::size_t>(view.buffer)].data;
    const std::uint64_t offset = view.byteOffset, length = view.byteLength, stride = view.byteStride;
    if (offset > data.size() || length > data.size() - offset)
      refuse(view_where, "(offset " + std::to_string(offset) + ", length " + std::to_string(length) + ") reaches beyond the " +
                             std::to_string(data.size()) + " bytes of its buffer");
    const std::size_t size = sizeOf(component) * components;
    if (stride && !may_stride) refuse(view_where, "has a byteStride, which only vertex attributes may have");
    if (stride && stride < size)
      refuse(view_where, "has a byteStride of " + std::to_string(stride) + ", less than the " + std::to_string(size) + " of an element");
    const std::uint64_t step = stride ? stride : size;
    // In this order no sum or product can overflow.
    if (start > length || count > (length - start) / step + 1 || (count - 1) * step + size > length - start)
      refuse(where, "(offset " + std::to_string(start) + ", " + std::to_string(count) + " elements of " + std::to_string(step) +
                        " bytes) reaches beyond the " + std::to_string(length) + " bytes of " + view_where);
    return {data.data() + offset + start, static_cast<std::size_t>(step), count, component};
  }

  const Positions& positions(int index) {
    const auto [entry, is_new] = positions_.try_emplace(index);
    if (!is_new) return entry->second;
    Positions& result = entry->second;
    const tinygltf::Accessor& accessor = model_.accessors[static_cast<std::size_t>(index)];
    const std::string where = result.where = place("accessors", static_cast<std::uint64_t>(index));
    const auto component = static_cast<std::uint64_t>(accessor.componentType);
    result.normalised = accessor.normalized;
    result.count = accessor.count;
    if (accessor.bufferView >= 0) result.dense = open(accessor.bufferView, accessor.byteOffset, result.count, component, 3, true, where);
    if (accessor.bufferView < 0 && !accessor.sparse.isSparse) refuse(where, "has no data without extensions");
    if (!accessor.sparse.isSparse) return result;

    const auto& indices = accessor.sparse.indices;
    const auto& values = accessor.sparse.values;
    const std::string indices_where = where + ".sparse.indices";
    const auto count = static_cast<std::uint64_t>(accessor.sparse.count);
    result.sparse_indices = open(indices.bufferView, static_cast<std::uint64_t>(indices.byteOffset), count,
                                 static_cast<std::uint64_t>(indices.componentType), 1, false, indices_where);
    result.sparse_values =
        open(values.bufferView, static_cast<std::uint64_t>(values.byteOffset), count, component, 3, false, where + ".sparse.values");
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

  Pose poseOf(const tinygltf::Node& node, const std::string& where) const {
    Pose pose;
    if (const std::vector<double>& m = node.matrix; !m.empty()) {
      if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1) refuse(where + ".matrix", "is not affine: its last row must be 0 0 0 1");
      pose.linear << m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10];
      pose.offset << m[12], m[13], m[14];
      return pose;
    }
    if (const std::vector<double>& q = node.rotation; !q.empty()) {
      const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
      const double norm = rotation.norm();
      if (!(std::abs(norm - 1) < 0.01)) refuse(where + ".rotation", "is not a unit quaternion");
      pose.linear = rotation.normalized().toRotationMatrix();  // stored as float32, hence rounded
    }
    if (const std::vector<double>& s = node.scale; !s.empty()) pose.linear = pose.linear * Eigen::Vector3d(s[0], s[1], s[2]).asDiagonal();
    if (const std::vector<double>& t = node.translation; !t.empty()) pose.offset << t[0], t[1], t[2];
    return pose;
  }

  std::vector<int> rootNodes() {
    if (const std::size_t scene_count = model_.scenes.size(); scene_count > 0) {
      const int scene = model_.defaultScene;
      if (scene < 0 && scene_count > 1)
        assembly_.note("No default scene is named; the first of " + std::to_string(scene_count) + " was read.");
      if (scene >= 0 && scene_count > 1)
        assembly_.note("The default scene " + std::to_string(scene) + " of " + std::to_string(scene_count) + " was read.");
      return model_.scenes[static_cast<std::size_t>(std::max(scene, 0))].nodes;
    }
    std::vector<bool> is_child(model_.nodes.size());
    for (const tinygltf::Node& node : model_.nodes)
      for (const int child : node.children) is_child[static_cast<std::size_t>(child)] = true;
    std::vector<int> roots;
    for (std::size_t n = 0; n < is_child.size(); ++n)
      if (!is_child[n]) roots.push_back(static_cast<int>(n));
    if (roots.size() > 1) assembly_.note("No scene is named; all " + std::to_string(roots.size()) + " root nodes were read.");
    return roots;
  }

  void visitNodes() {
    struct Visit {
      int node;
      Pose parent;
    };
    std::vector<Visit> stack;  // own stack: a file may nest nodes deeper than the machine's stack allows
    const std::vector<int> roots = rootNodes();
    for (std::size_t k = roots.size(); k-- > 0;) stack.push_back({roots[k], Pose{}});
    std::vector<bool> visited(model_.nodes.size());
    while (!stack.empty()) {
      const Visit visit = stack.back();
      stack.pop_back();
      const auto index = static_cast<std::size_t>(visit.node);
      const tinygltf::Node& node = model_.nodes[index];
      const std::string where = place("nodes", index);
      if (visited[index]) refuse(where, "is reached twice: nodes must form trees, without cycles");
      visited[index] = true;
      const Pose local = poseOf(node, where);
      const Pose pose{visit.parent.linear * local.linear, visit.parent.linear * local.offset + visit.parent.offset};
      if (node.mesh >= 0) addMesh(node, pose);
      spend(node.children.size());
      for (std::size_t k = node.children.size(); k-- > 0;) stack.push_back({node.children[k], pose});
    }
  }

  void addMesh(const tinygltf::Node& node, const Pose& pose) {
    const tinygltf::Mesh& mesh = model_.meshes[static_cast<std::size_t>(node.mesh)];
    const std::string where = place("meshes", static_cast<std::uint64_t>(node.mesh));
    assembly_.beginPart(node.name.empty() ? mesh.name : node.name);
    if (node.skin >= 0) has_skin_ = true;
    for (std::size_t k = 0; k < mesh.primitives.size(); ++k) addPrimitive(mesh.primitives[k], pose, where + "." + place("primitives", k));
  }

  void addPrimitive(const tinygltf::Primitive& primitive, const Pose& pose, const std::string& where) {
    spend(1);
    has_primitive_ = true;
    const int mode = primitive.mode;
    if (mode < 4) {  // points and lines
      ++skipped_modes_;
      return;
    }
    const Positions& points = positions(primitive.attributes.at("POSITION"));
    std::optional<Elements> indices;
    if (primitive.indices >= 0) {
      const tinygltf::Accessor& accessor = model_.accessors[static_cast<std::size_t>(primitive.indices)];
      indices = open(accessor.bufferView, accessor.byteOffset, accessor.count, static_cast<std::uint64_t>(accessor.componentType), 1, false,
                     place("accessors", static_cast<std::uint64_t>(primitive.indices)));
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
      assembly_.refuse("its nodes repeat meshes to more than " + std::to_string(work_limit_) +
                       " triangles. Export one mesh without instances.");
    work_left_ -= work;
  }

  MeshAssembly assembly_;
  std::string format_;
  std::uint64_t work_limit_, work_left_;
  tinygltf::Model model_;
  std::map<int, Positions> positions_;
  std::size_t skipped_modes_ = 0;
  bool has_skin_ = false, has_primitive_ = false;
};

}  // namespace

MeshFile readGltf(std::span<const char> bytes, const std::string& name, const std::filesystem::path& folder, double unit_mm) {
  return GltfReader(bytes, name, folder, unit_mm).read();
}

}  // namespace spheretree::formats
