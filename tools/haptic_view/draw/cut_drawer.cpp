// SPDX-License-Identifier: GPL-3.0-or-later
#include "draw/cut_drawer.h"

#include <algorithm>
#include <cstddef>

namespace spheretree::view {
namespace {

// Bricks in a row of the texture, which has as many rows: OpenGL 3.3 draws at least 256 texels.
constexpr std::int32_t kRow = 256 / CutBlock::kSide;
constexpr std::int32_t kNoBrick = -1, kAllRemoved = -2;  // as in kCutSurfaceFragment

BlockPlace regionOf(const BlockPlace& place) { return {place[0] >> 2, place[1] >> 2, place[2] >> 2}; }

GLuint newTexture(const Gl& gl, GLint filter) {
  GLuint id = 0;
  gl.GenTextures(1, &id);
  gl.BindTexture(GL_TEXTURE_3D, id);
  for (const GLenum which : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER}) gl.TexParameteri(GL_TEXTURE_3D, which, filter);
  for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
    gl.TexParameteri(GL_TEXTURE_3D, axis, GL_CLAMP_TO_EDGE);
  return id;
}

}  // namespace

struct CutDrawer::Region {
  VertexArray array;
  GlBuffer corners, indices;
  GLsizei count = 0;
  explicit Region(const Gl& gl) : array(gl), corners(gl), indices(gl) {
    array.bind();
    corners.bind(GL_ARRAY_BUFFER);
    indices.bind(GL_ELEMENT_ARRAY_BUFFER);
    const auto attribute = [&](GLuint index, GLint size, GLenum type, std::size_t at) {
      gl.EnableVertexAttribArray(index);
      gl.VertexAttribPointer(index, size, type, type == GL_UNSIGNED_BYTE, sizeof(CutCorner), reinterpret_cast<const void*>(at));
    };
    attribute(0, 3, GL_FLOAT, offsetof(CutCorner, position));
    attribute(1, 3, GL_FLOAT, offsetof(CutCorner, normal));
    attribute(2, 4, GL_UNSIGNED_BYTE, offsetof(CutCorner, colour));
    attribute(3, 1, GL_FLOAT, offsetof(CutCorner, depth));
  }
};

CutDrawer::CutDrawer(const Gl& gl) : gl_(gl) {
  places_ = newTexture(gl, GL_NEAREST);
  bricks_ = newTexture(gl, GL_LINEAR);
}

CutDrawer::~CutDrawer() {
  gl_.DeleteTextures(1, &places_);
  gl_.DeleteTextures(1, &bricks_);
}

void CutDrawer::update(const CutSurface& surface) {
  const CutSurface::Blocks& blocks = surface.blocks();
  side_ = surface.blockSide();
  std::set<BlockPlace> changed;  // regions
  for (auto it = uploaded_.begin(); it != uploaded_.end();) {
    const auto found = blocks.find(it->first);
    if (found != blocks.end() && found->second.block) {
      ++it;
      continue;
    }
    if (it->second.brick != kNoBrick) free_bricks_.push_back(it->second.brick);
    changed.insert(regionOf(it->first));
    it = uploaded_.erase(it);
  }
  std::size_t all_removed = 0;
  for (const auto& [place, entry] : blocks) {
    all_removed += entry.state == CutSurface::State::Removed ? 1 : 0;
    if (!entry.block) continue;
    Uploaded& uploaded = uploaded_[place];
    if (uploaded.block == entry.block) continue;
    uploaded.block = entry.block;
    if (entry.block->meets_skin) upload(uploaded);
    changed.insert(regionOf(place));
  }
  if (changed.empty() && all_removed == all_removed_) return;
  all_removed_ = all_removed;
  fillPlaces(blocks);
  for (const BlockPlace& region : changed) fillRegion(region);
}

void CutDrawer::upload(Uploaded& uploaded) {
  constexpr std::int32_t kLayer = kRow * kRow;
  gl_.BindTexture(GL_TEXTURE_3D, bricks_);
  if (uploaded.brick == kNoBrick && !free_bricks_.empty()) {
    uploaded.brick = free_bricks_.back();
    free_bricks_.pop_back();
  } else if (uploaded.brick == kNoBrick) {
    uploaded.brick = brick_count_++;
  }
  constexpr GLsizei kSide = CutBlock::kSide;
  const auto write = [&](const Uploaded& one) {
    const std::int32_t b = one.brick;
    gl_.TexSubImage3D(GL_TEXTURE_3D, 0, kSide * (b % kRow), kSide * (b / kRow % kRow), kSide * (b / kLayer), kSide, kSide, kSide, GL_RED,
                      GL_FLOAT, one.block->distance.data());
  };
  if (uploaded.brick < layer_count_ * kLayer) return write(uploaded);
  ++layer_count_;
  gl_.TexImage3D(GL_TEXTURE_3D, 0, GL_R32F, kSide * kRow, kSide * kRow, kSide * layer_count_, 0, GL_RED, GL_FLOAT, nullptr);
  for (const auto& [place, each] : uploaded_)
    if (each.brick != kNoBrick) write(each);
}

void CutDrawer::fillPlaces(const CutSurface::Blocks& blocks) {
  BlockPlace high{};
  bool is_first = true;
  const auto brickOf = [&](const BlockPlace& place, const CutSurface::Entry& entry) {
    return entry.state == CutSurface::State::Removed ? kAllRemoved : entry.block ? uploaded_[place].brick : kNoBrick;
  };
  for (const auto& [place, entry] : blocks) {
    if (brickOf(place, entry) == kNoBrick) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      low_[k] = is_first ? place[k] : std::min(low_[k], place[k]);
      high[k] = is_first ? place[k] : std::max(high[k], place[k]);
    }
    is_first = false;
  }
  std::array<GLsizei, 3> count{};
  for (std::size_t k = 0; k < 3; ++k) count[k] = is_first ? 1 : high[k] - low_[k] + 1;
  std::vector<std::int32_t> places(
      static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]) * static_cast<std::size_t>(count[2]), kNoBrick);
  for (const auto& [place, entry] : blocks)
    if (const std::int32_t brick = brickOf(place, entry); brick != kNoBrick)
      places[static_cast<std::size_t>(place[0] - low_[0] + count[0] * (place[1] - low_[1] + count[1] * (place[2] - low_[2])))] = brick;
  gl_.BindTexture(GL_TEXTURE_3D, places_);
  gl_.TexImage3D(GL_TEXTURE_3D, 0, GL_R32I, count[0], count[1], count[2], 0, GL_RED_INTEGER, GL_INT, places.data());
}

void CutDrawer::fillRegion(const BlockPlace& region) {
  std::vector<CutCorner> corners;
  std::vector<std::uint32_t> indices;
  for (std::int32_t k = 0; k < 64; ++k) {
    const auto found = uploaded_.find({4 * region[0] + (k & 3), 4 * region[1] + (k >> 2 & 3), 4 * region[2] + (k >> 4)});
    if (found == uploaded_.end()) continue;
    const auto first = static_cast<std::uint32_t>(corners.size());
    corners.insert(corners.end(), found->second.block->corners.begin(), found->second.block->corners.end());
    for (const std::uint16_t corner : found->second.block->triangles) indices.push_back(first + corner);
  }
  if (indices.empty()) {
    regions_.erase(region);
    return;
  }
  std::unique_ptr<Region>& at = regions_[region];
  if (!at) at = std::make_unique<Region>(gl_);
  at->array.bind();
  at->corners.fill(GL_ARRAY_BUFFER, corners.data(), corners.size() * sizeof(CutCorner), GL_DYNAMIC_DRAW);
  at->indices.fill(GL_ELEMENT_ARRAY_BUFFER, indices.data(), indices.size() * sizeof(std::uint32_t), GL_DYNAMIC_DRAW);
  at->count = static_cast<GLsizei>(indices.size());
}

void CutDrawer::setField(const ShaderProgram& program) const {
  gl_.ActiveTexture(GL_TEXTURE1);
  gl_.BindTexture(GL_TEXTURE_3D, places_);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_3D, bricks_);
  gl_.Uniform1i(program.uniform("places"), 1);
  gl_.Uniform1i(program.uniform("bricks"), 0);
  gl_.Uniform1f(program.uniform("side"), static_cast<float>(side_));
  gl_.Uniform3f(program.uniform("low"), static_cast<float>(side_ * low_[0]), static_cast<float>(side_ * low_[1]),
                static_cast<float>(side_ * low_[2]));
}

void CutDrawer::drawWalls() const {
  for (const auto& [place, region] : regions_) {
    region->array.bind();
    gl_.DrawElements(GL_TRIANGLES, region->count, GL_UNSIGNED_INT, nullptr);
  }
}

}  // namespace spheretree::view
