// SPDX-License-Identifier: Apache-2.0
// Specification: Khronos, glTF 2.0, ISO/IEC 12113:2022.
#include "spheretree/formats/gltf.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "gltf/gltf_accessors.h"
#include "gltf/gltf_json.h"
#include "gltf/gltf_model.h"
#include "gltf/gltf_nodes.h"

namespace spheretree::formats {
namespace {

/// For each vertex: up to four joints and their weights in each set (section 3.7.3.1).
struct SkinSet {
  const Numbers *joints, *weights;
};

struct Morph {
  const Numbers* displacements;
  double weight;
};

class GltfReader {
 public:
  GltfReader(std::span<const char> bytes, const std::string& name, const std::filesystem::path& folder, double unit_mm)
      : assembly_(name, unit_mm),
        format_(isGlb(bytes) ? "GLB" : "glTF"),
        work_(gltfWorkLimit(bytes.size()), assembly_),
        model_(loadGltfModel(bytes, folder, assembly_)),
        accessors_(model_, assembly_, work_),
        nodes_(model_, accessors_, assembly_, work_) {}

  MeshFile read() {
    for (const GltfNodes::Placed& placed : nodes_.placed()) addNode(placed);
    if (posed_skins_)
      assembly_.note(std::to_string(posed_skins_) + (posed_skins_ == 1 ? " skin was" : " skins were") + " read in the rest pose.");
    if (bare_skins_)
      assembly_.note(std::to_string(bare_skins_) + " skinned primitives have no joints and weights: they were read as they are stored.");
    if (hidden_nodes_) assembly_.note(counted(hidden_nodes_, "hidden node with a mesh", "hidden nodes with meshes") + " left out.");
    if (const std::size_t outside = meshNodes() - placed_nodes_)
      assembly_.note(counted(outside, "node with a mesh", "nodes with meshes") + " left out, because the scene does not contain " +
                     (outside == 1 ? "it." : "them."));
    if (morphed_) assembly_.note(counted(morphed_, "primitive") + " read with the weights of morph targets that the file gives.");
    if (model_.animations)
      assembly_.note(counted(model_.animations, "animation") + " ignored; every node stands where the file places it.");
    if (skipped_modes_) assembly_.note(std::to_string(skipped_modes_) + " primitives of points or lines were left out.");
    if (!has_primitive_) assembly_.refuse("no node of its scene has a mesh that is visible. Export the scene again with its meshes.");
    return assembly_.finish(format_);
  }

 private:
  [[noreturn]] void refuse(const std::string& where, const std::string& what) const { refuseElement(assembly_, where, what); }

  void addNode(const GltfNodes::Placed& placed) {
    const GltfModel::Node& node = model_.nodes[placed.node];
    if (!node.mesh) return;
    ++placed_nodes_;
    if (!placed.is_visible) {
      ++hidden_nodes_;
      return;
    }
    const std::string name = node.name.empty() ? model_.meshes[*node.mesh].name : node.name;
    const std::vector<GltfPose> instances = nodes_.instances(placed.node);
    if (node.skin) {
      if (!instances.empty()) refuse(place("nodes", placed.node), "has both a skin and instances");
      joints_ = nodes_.joints(*node.skin);
      ++posed_skins_;
    }
    weights_ = node.weights.empty() ? model_.meshes[*node.mesh].weights : node.weights;
    assembly_.beginPart(name);
    if (instances.empty()) addMesh(*node.mesh, placed.pose);
    for (std::size_t i = 0; i < instances.size(); ++i) {
      if (!name.empty()) assembly_.beginPart(name + "_" + std::to_string(i));
      addMesh(*node.mesh, placed.pose * instances[i]);
    }
    joints_.clear();
  }

  std::size_t meshNodes() const {
    return static_cast<std::size_t>(
        std::count_if(model_.nodes.begin(), model_.nodes.end(), [](const GltfModel::Node& node) { return node.mesh.has_value(); }));
  }
  static std::string counted(std::size_t count, const std::string& one, const std::string& many = {}) {
    return std::to_string(count) + " " + (count == 1 ? one + " was" : (many.empty() ? one + "s" : many) + " were");
  }

  void addMesh(std::size_t index, const GltfPose& pose) {
    const GltfModel::Mesh& mesh = model_.meshes[index];
    const std::string where = place("meshes", index);
    for (std::size_t k = 0; k < mesh.primitives.size(); ++k) addPrimitive(mesh.primitives[k], pose, where + "." + place("primitives", k));
  }

  void addPrimitive(const GltfModel::Primitive& primitive, const GltfPose& pose, const std::string& where) {
    work_.spend(1);
    has_primitive_ = true;
    const std::uint64_t mode = primitive.mode;
    if (mode < 4) {  // points and lines
      ++skipped_modes_;
      return;
    }
    const Numbers& points = accessors_.numbers(primitive.positions);
    const std::vector<SkinSet> skin = skinOf(primitive, points, where);
    const std::vector<Morph> morphs = morphsOf(primitive, points, where);
    std::optional<Elements> indices;
    if (primitive.indices) indices = accessors_.indices(*primitive.indices);
    const std::uint64_t corners = indices ? indices->count : points.count;
    if (mode == 4 ? corners % 3 != 0 : corners < 3)
      refuse(where, "has " + std::to_string(corners) + " corners, which is not a multiple of 3");
    const std::uint64_t triangles = mode == 4 ? corners / 3 : corners - 2;
    work_.spend(triangles * (skin.size() + morphs.size() + 1));

    assembly_.setColour(primitive.colour);
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
      // Strips repeat vertices in order to turn a corner; such triangles are skipped.
      if (mode == 5 && (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0])) continue;
      addTriangle(corner, points, morphs, pose, skin, where);
    }
  }

  void addTriangle(std::array<std::uint64_t, 3> corner, const Numbers& points, const std::vector<Morph>& morphs, const GltfPose& pose,
                   const std::vector<SkinSet>& skin, const std::string& where) {
    bool is_mirrored = false;
    std::array<Eigen::Vector3d, 3> place_of;
    for (std::size_t k = 0; k < 3; ++k) {
      const GltfPose to_scene = skin.empty() ? pose : blended(skin, corner[k], where);
      if (k == 0) is_mirrored = to_scene.linear.determinant() < 0;
      Eigen::Vector3d point = points.vectorAt(corner[k]);
      for (const auto& [displacements, weight] : morphs) point += weight * displacements->vectorAt(corner[k]);
      place_of[k] = to_scene * point;
    }
    if (is_mirrored) {
      std::swap(corner[1], corner[2]);
      std::swap(place_of[1], place_of[2]);
    }
    // Equal corners give equal positions, and are therefore welded in the end.
    for (std::size_t k = 0; k < 3; ++k)
      if (!assembly_.addVertex(place_of[k].x(), place_of[k].y(), place_of[k].z()))
        refuse(where, "has a vertex (" + std::to_string(corner[k]) + " of " + points.where + ") that is not a finite point in mm");
    const std::uint32_t last = assembly_.vertexCount();
    assembly_.addTriangle(last - 3, last - 2, last - 1);
  }

  /// The morph targets that the default weights move (section 3.7.2.2).
  std::vector<Morph> morphsOf(const GltfModel::Primitive& primitive, const Numbers& points, const std::string& where) {
    std::vector<Morph> morphs;
    for (std::size_t k = 0; k < std::min(weights_.size(), primitive.morph_targets.size()); ++k) {
      if (weights_[k] == 0 || !primitive.morph_targets[k]) continue;
      morphs.push_back({&accessors_.numbers(*primitive.morph_targets[k]), weights_[k]});
      if (morphs.back().displacements->count != points.count)
        refuse(where + "." + place("targets", k), "has " + std::to_string(morphs.back().displacements->count) + " displacements for " +
                                                      std::to_string(points.count) + " vertices");
    }
    morphed_ += !morphs.empty();
    return morphs;
  }

  // --- skins (section 3.7.3): the position of a skinned mesh depends only on its joints, not on its own node ---

  std::vector<SkinSet> skinOf(const GltfModel::Primitive& primitive, const Numbers& points, const std::string& where) {
    if (joints_.empty()) return {};
    std::vector<SkinSet> sets;
    for (const auto& [joints, weights] : primitive.skin_sets) {
      sets.push_back({&accessors_.numbers(joints), &accessors_.numbers(weights)});
      if (sets.back().joints->count < points.count || sets.back().weights->count < points.count)
        refuse(where, "has fewer joints or weights than its " + std::to_string(points.count) + " vertices");
    }
    if (sets.empty()) ++bare_skins_;
    return sets;
  }

  GltfPose blended(const std::vector<SkinSet>& skin, std::uint64_t vertex, const std::string& where) const {
    GltfPose sum{Eigen::Matrix3d::Zero(), Eigen::Vector3d::Zero()};
    double whole = 0;
    for (const SkinSet& set : skin) {
      for (std::size_t k = 0; k < 4; ++k) {
        const double weight = set.weights->at(vertex, k);
        if (weight == 0) continue;
        const std::uint64_t joint = set.joints->unsignedAt(vertex, k);
        if (joint >= joints_.size())
          refuse(where, "names joint " + std::to_string(joint) + " for vertex " + std::to_string(vertex) + ", but its skin has only " +
                            std::to_string(joints_.size()));
        sum.linear += weight * joints_[joint].linear;
        sum.offset += weight * joints_[joint].offset;
        whole += weight;
      }
    }
    if (!(whole > 0)) refuse(where, "has no weights for vertex " + std::to_string(vertex));
    return {sum.linear / whole, sum.offset / whole};  // quantised weights add up to 1 only approximately
  }

  MeshAssembly assembly_;
  std::string format_;
  WorkBudget work_;
  GltfModel model_;
  GltfAccessors accessors_;
  GltfNodes nodes_;
  std::vector<GltfPose> joints_;  // of the skin of the current node
  std::vector<double> weights_;   // of the morph targets at the current node
  std::size_t skipped_modes_ = 0, posed_skins_ = 0, bare_skins_ = 0, hidden_nodes_ = 0, placed_nodes_ = 0, morphed_ = 0;
  bool has_primitive_ = false;
};

}  // namespace

MeshFile readGltf(std::span<const char> bytes, const std::string& name, const std::filesystem::path& folder, double unit_mm) {
  return GltfReader(bytes, name, folder, unit_mm).read();
}

}  // namespace spheretree::formats
