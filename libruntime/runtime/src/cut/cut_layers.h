// SPDX-License-Identifier: Apache-2.0
// The layers of an object that a burr cuts: closed skins within one another, from which blocks of the lattice are made.
// Units: mm; frame: axes of the object, origin at the centre of its shape.
#pragma once

#include <memory>
#include <vector>

#include "cut/cut_lattice.h"
#include "scene/compiled_skin.h"

namespace spheretree::runtime {

class CutLayers {
 public:
  /// `outer`: skin of the object, which must outlive this.
  explicit CutLayers(const CompiledSkin& outer) : skins_{&outer} { near_.reserve(outer.patch.size()); }
  /// A layer within those before it.
  void add(CompiledSkin skin);
  std::size_t count() const { return skins_.size(); }

  /// The distance of a point from the surface of the object; `limit` if it is farther away than that.
  double distanceFrom(const Eigen::Vector3d& point, double limit, std::uint32_t& work) const;
  bool isInside(const Eigen::Vector3d& point, std::uint32_t& work) const { return isWithin(*skins_[0], point, work); }

  /// Makes the block at this place, if it is not known and not outside. Returns false if the memory is full. Adds its
  /// work, in tests of 8 points.
  bool make(const BlockPlace& place, CutLattice& lattice, std::uint32_t& work);

 private:
  void findNear(const CompiledSkin& skin, const Eigen::Vector3d& middle, double reach, std::uint32_t& work);
  bool isWithin(const CompiledSkin& skin, const Eigen::Vector3d& point, std::uint32_t& work) const;

  std::vector<const CompiledSkin*> skins_;
  std::vector<std::unique_ptr<const CompiledSkin>> inner_;
  std::vector<std::uint32_t> near_;  // triangles of a skin
};

}  // namespace spheretree::runtime
