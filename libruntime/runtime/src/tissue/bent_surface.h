// SPDX-License-Identifier: Apache-2.0
// How the vertices and edges of a skin move and turn with the soft tissue below it.
//
// Flat triangles have their corners at the vertices. Normals rotate like those of the tetrahedra's surface, so that
// they stay continuous from patch to patch. Faces of the tetrahedra and sides of the skin bulge further out the more
// the angle between the normals at their ends increases, so that a dent is as round as its normals, without facets. The
// bulge is computed at the beginning of the step: within the step the surface moves linearly with the nodes, as the QP
// assumes.
// Units: mm; frame: axes of the object. No allocation after construction.
#pragma once

#include <span>
#include <vector>

#include "scene/compiled_skin.h"
#include "tissue/soft_model.h"

namespace spheretree::runtime {

/// The farthest that a vertex bulges out, and that the patches beside an edge swing out of their flat triangles,
/// however the tissue is bent [mm].
float bulgeBound(const SoftModel::Node& vertex);
float swingBound(const SoftModel::Edge& edge);

class BentSurface {
 public:
  // The shape of a step, with the value of bends_ for which it was computed. Together, as in SoftModel.
  struct Bent {
    Eigen::Vector3f moved, bulge, normal;  // moved: displacement at the last bend()
    PackedDirection packed;
    std::uint32_t bend = 0;
  };
  struct alignas(64) Vertex : Bent {
    Eigen::Vector3f place;
    std::uint32_t version = 0;  // of `place`
  };
  struct alignas(64) Middle : Bent {
    Eigen::Vector3f offset;  // from the middle of the flat edge
  };

  /// `model` must outlive the object. `offset`: from the origin of the shape's frame to that of the file's frame.
  /// @throws std::bad_alloc.
  BentSurface(const SoftModel& model, const Eigen::Vector3f& offset);

  /// Bends as for this displacement of the pressed nodes, or as at rest.
  void bend(std::span<const float> shift);
  void reset();
  /// Marks all places as outdated.
  void forget() { ++version_; }
  /// The number of bends so far, and of changes of places.
  std::uint32_t bends() const { return bends_; }
  std::uint32_t version() const { return version_; }

  const Vertex& vertex(std::uint32_t v);
  const Middle& middle(std::uint32_t edge);
  /// Where a vertex is if the pressed nodes are displaced by `shift`.
  const Eigen::Vector3f& placeOf(std::uint32_t v, std::span<const float> shift);

 private:
  class Turn;
  struct Fan {
    Eigen::Vector3f normal;
    std::uint32_t bend = 0;
  };

  float bulgeOf(const SoftModel::Node& node) const;
  Turn bendNode(const SoftModel::Node& node, Bent& out);
  const Eigen::Vector3f& fanNormal(std::uint32_t fan);

  const SoftModel& model_;
  const Eigen::Vector3f offset_;
  std::vector<Vertex> vertices_;
  std::vector<Middle> middles_;  // (edge)
  std::vector<Fan> fans_;
  std::vector<Eigen::Vector3f> node_places_;  // (node of the tetrahedra's surface) at the last bend()
  std::uint32_t bends_ = 1, version_ = 1;
};

}  // namespace spheretree::runtime
