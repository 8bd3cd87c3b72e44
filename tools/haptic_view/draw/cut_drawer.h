// SPDX-License-Identifier: GPL-3.0-or-later
// An object from which a burr has removed something, on the graphics card: its surface without what was removed, and
// the walls. Only what changed since the last picture is uploaded.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "draw/gl.h"
#include "model/cut_surface.h"

namespace spheretree::view {

class CutDrawer {
 public:
  explicit CutDrawer(const Gl& gl);
  ~CutDrawer();
  CutDrawer(const CutDrawer&) = delete;
  CutDrawer& operator=(const CutDrawer&) = delete;

  /// Uploads what differs from the last call.
  void update(const CutSurface& surface);
  /// Binds the textures of what was removed and sets the uniforms of kCutSurfaceFragment.
  void setField(const ShaderProgram& program) const;
  /// Draws the walls with the program in use, of kWallVertex.
  void drawWalls() const;

 private:
  struct Uploaded {
    std::shared_ptr<const CutBlock> block;
    std::int32_t brick = -1;  // of a block that meets the surface of the object
  };
  struct Region;  // of 4 x 4 x 4 blocks: one draw call
  void upload(Uploaded& uploaded);
  void fillPlaces(const CutSurface::Blocks& blocks);
  void fillRegion(const BlockPlace& region);

  const Gl& gl_;
  GLuint places_ = 0, bricks_ = 0;  // textures: the brick of each block; the distances of the blocks
  std::int32_t brick_count_ = 0, layer_count_ = 0;
  std::vector<std::int32_t> free_bricks_;
  std::map<BlockPlace, Uploaded> uploaded_;
  std::map<BlockPlace, std::unique_ptr<Region>> regions_;
  double side_ = 1;              // of a block [mm]
  BlockPlace low_{};             // of places_
  std::size_t all_removed_ = 0;  // blocks
};

}  // namespace spheretree::view
