// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/provenance.h"

#define XXH_INLINE_ALL  // header-only, nothing to link
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <memory>
#include <new>

namespace spheretree::builder {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are hashed as they stand in memory");

Hash128 canonical(XXH128_hash_t value) {
  XXH128_canonical_t bytes;
  XXH128_canonicalFromHash(&bytes, value);
  Hash128 hash;
  static_assert(sizeof bytes.digest == sizeof hash);
  std::copy(bytes.digest, bytes.digest + sizeof bytes.digest, hash.begin());
  return hash;
}

std::string shortest(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

}  // namespace

Hash128 bytesHash(std::span<const std::byte> bytes) { return canonical(XXH3_128bits(bytes.data(), bytes.size())); }

Hash128 meshHash(const TriangleMesh& mesh) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
  if (!state) throw std::bad_alloc();
  XXH3_128bits_reset(state.get());
  const std::uint64_t counts[2] = {mesh.positions.size(), mesh.triangles.size()};
  XXH3_128bits_update(state.get(), counts, sizeof counts);
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double) && sizeof(Triangle) == 3 * sizeof(std::uint32_t));
  if (!mesh.positions.empty()) XXH3_128bits_update(state.get(), mesh.positions.data(), mesh.positions.size() * sizeof(Eigen::Vector3d));
  if (!mesh.triangles.empty()) XXH3_128bits_update(state.get(), mesh.triangles.data(), mesh.triangles.size() * sizeof(Triangle));
  return canonical(XXH3_128bits_digest(state.get()));
}

// There are many tolerances of single triangles: their hash represents them.
static std::string gradedText(const BuildSettings& settings) {
  if (settings.tolerance_of_triangle_mm.empty()) return "";
  std::string text = "tolerance_of_triangle_mm=";
  for (const std::uint8_t byte : bytesHash(std::as_bytes(std::span(settings.tolerance_of_triangle_mm)))) text += std::to_string(byte) + ".";
  return text + "\n";
}

static std::string skinText(const BuildSettings& settings) {
  if (!settings.skin) return "skin=off\n";
  return "skin_tolerance_mm=" + shortest(settings.skin_tolerance_mm) + "\ncrease_angle_deg=" + shortest(settings.crease_angle_deg) + "\n";
}

static std::string hullText(const BuildSettings& settings) {
  if (!settings.hulls) return "";
  return "hull_tolerance_mm=" + shortest(settings.hull_tolerance_mm) + "\nmax_hulls=" + std::to_string(settings.max_hulls) + "\n";
}

// Its words are those of trees that exist: another word would give the same settings another hash.
std::string settingsText(const BuildSettings& settings) {
  std::string members;
  for (const BuilderKind kind : settings.combine) members.append(members.empty() ? "" : ",").append(name(kind));
  return "builder=" + std::string(name(settings.builder)) + "\ncombine=" + members + "\nlevels=" + std::to_string(settings.levels) +
         "\nbranching=" + std::to_string(settings.branching) + "\nquality=" + std::string(name(settings.quality)) +
         "\ntolerance_mm=" + shortest(settings.tolerance_mm) + "\nseed=" + std::to_string(settings.seed) + "\n" +
         (settings.search ? "search=1\n" : "") + (settings.medial_axis == MedialAxis::Static ? "medial_axis=static\n" : "") +
         skinText(settings) + hullText(settings) + gradedText(settings) +
         (settings.soft_share > 0 ? "soft_share=" + shortest(settings.soft_share) + "\n" : "") + (settings.simplify ? "" : "simplify=0\n") +
         (settings.max_leaves == 0 ? "" : "most_leaves=" + std::to_string(settings.max_leaves) + "\n");
}

Hash128 settingsHash(const BuildSettings& settings) {
  const std::string text = settingsText(settings);
  return bytesHash(std::as_bytes(std::span(text)));
}

}  // namespace spheretree::builder
