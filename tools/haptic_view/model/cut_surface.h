// SPDX-License-Identifier: GPL-3.0-or-later
// What a burr has removed of an object, for drawing: the walls of the cavity as triangles, and the distance from what
// was removed, by which the surface of the object is cut open. Units: mm; frame of the object.
//
// The distance is kept at the points of a lattice, in blocks of 8 x 8 x 8 cells that are made where the burr comes: the
// least, over all ways of the burr, of the distance from the way less the radius. A wall has a corner in each cell that
// it crosses, at the mean of its crossings with the edges of the cell.
// Paper: S. F. F. Gibson. Constrained elastic surface nets. MICCAI 1998; without its relaxation.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "model/colour.h"

namespace spheretree::view {

/// What an object consists of; it does not change.
struct CutMaterial {
  struct Layer {
    std::string name;
    Colour colour;
    std::function<double(const Eigen::Vector3d&)> depth;  // of a point below the layer's surface, negative outside [mm]
  };
  std::vector<Layer> layers;  // the whole object first; a point belongs to the last layer that contains it
};

struct CutCorner {
  Eigen::Vector3f position, normal;  // the normal points to what was removed
  float depth;                       // below the surface of the object; walls are drawn where it is not negative
  Colour colour;
};
static_assert(sizeof(CutCorner) == 32);

using BlockPlace = std::array<std::int32_t, 3>;  // in blocks, from the origin of the frame

struct CutBlock {
  static constexpr int kCells = 8, kSide = kCells + 2, kPoints = kSide * kSide * kSide;  // and the first cells of the next blocks
  std::array<float, kPoints> distance;                                                   // from what was removed, negative in it, limited
  std::array<std::array<float, kPoints>, 3> away;                                        // to the point, from the nearest way of the burr
  float most = 0;                                                                        // largest distance
  bool meets_skin = false;                                                               // the surface of the object may pass through
  std::vector<std::uint8_t> inside, met;  // (layer) whether it contains the middle; whether its surface may pass through
  bool is_stale = false;                  // the wall is not yet that of the distances
  std::vector<CutCorner> corners;         // of the wall
  std::vector<std::uint16_t> triangles;   // three corners for each, counter-clockwise seen from what was removed
};

/// Copies share their blocks until one of them changes a block.
class CutSurface {
 public:
  enum class State : std::uint8_t {
    Open,     // of which there is a block
    Outside,  // of the object: there is nothing to draw
    Removed,  // nothing is left
  };
  struct Entry {
    State state = State::Open;
    std::shared_ptr<CutBlock> block = nullptr;
  };
  using Blocks = std::map<BlockPlace, Entry>;

  /// `radius` of the smallest ball of the burr.
  CutSurface(std::shared_ptr<const CutMaterial> material, double radius);

  const CutMaterial& material() const { return *material_; }
  bool empty() const { return blocks_.empty(); }
  double spacing() const { return spacing_; }
  double blockSide() const { return CutBlock::kCells * spacing_; }
  /// Removes the points within `radius` of a way. Cost: about 10 us for a ball of 8 spacings.
  void remove(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius);
  /// What is drawn. A block changes only while nobody else owns it: who keeps those of the last call finds the changed
  /// ones by their addresses. Cost: about 50 us for each block that remove() has changed since.
  const Blocks& blocks() const;

 private:
  struct Way;
  void removeFrom(Entry& entry, const BlockPlace& place, const Way& way);
  Entry entryAt(const BlockPlace& place) const;
  Eigen::Vector3d middleOf(const BlockPlace& place) const;
  double halfDiagonal() const;  // of the points of a block [mm]
  void makeWall(CutBlock& block, const BlockPlace& place) const;
  CutCorner cornerAt(const CutBlock& block, const Eigen::Vector3d& position, const Eigen::Vector3f& normal) const;

  std::shared_ptr<const CutMaterial> material_;
  double spacing_, reach_;
  Blocks blocks_;
};

}  // namespace spheretree::view
