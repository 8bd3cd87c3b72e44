// SPDX-License-Identifier: Apache-2.0
#include "gltf/gltf_accessors.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "gltf/gltf_json.h"
#include "text/little_endian.h"

namespace spheretree::formats {
namespace {

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

}  // namespace

void WorkBudget::spend(std::uint64_t work) {
  if (work > left_)
    assembly_.refuse("its nodes repeat meshes to more than " + std::to_string(limit_) + " triangles. Export one mesh without instances.");
  left_ -= work;
}

std::uint64_t Elements::unsignedAt(std::uint64_t i, std::size_t axis) const {
  return littleBits(first + i * stride + axis * sizeOf(component), sizeOf(component));
}

double Elements::numberAt(std::uint64_t i, std::size_t axis, bool normalised) const {
  const std::uint64_t bits = littleBits(first + i * stride + axis * sizeOf(component), sizeOf(component));
  switch (component) {  // 3.11: f = max(c / 127, -1), etc.
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

std::pair<const Elements*, std::uint64_t> Numbers::find(std::uint64_t i) const {
  std::uint64_t low = 0, high = sparse_indices.count;  // ascending, as checked when it was opened
  while (low < high) {
    const std::uint64_t middle = low + (high - low) / 2;
    if (sparse_indices.unsignedAt(middle) < i)
      low = middle + 1;
    else
      high = middle;
  }
  if (low < sparse_indices.count && sparse_indices.unsignedAt(low) == i) return {&sparse_values, low};
  return {dense ? &*dense : nullptr, i};
}

double Numbers::at(std::uint64_t i, std::size_t axis) const {
  const auto [from, place] = find(i);
  return from ? from->numberAt(place, axis, normalised) : 0;
}

Eigen::Vector3d Numbers::vectorAt(std::uint64_t i) const {
  const auto [from, place] = find(i);
  if (!from) return Eigen::Vector3d::Zero();
  return {from->numberAt(place, 0, normalised), from->numberAt(place, 1, normalised), from->numberAt(place, 2, normalised)};
}

std::uint64_t Numbers::unsignedAt(std::uint64_t i, std::size_t axis) const {
  const auto [from, place] = find(i);
  return from ? from->unsignedAt(place, axis) : 0;
}

Elements GltfAccessors::open(std::size_t view_index, std::uint64_t start, std::uint64_t count, std::uint64_t component,
                             std::size_t components, bool may_stride, const std::string& where) const {
  const GltfModel::View& view = model_.views[view_index];
  const std::string view_where = place("bufferViews", view_index);
  const std::span<const unsigned char> data = model_.buffers[view.buffer];
  if (view.offset > data.size() || view.length > data.size() - view.offset)
    refuseElement(assembly_, view_where,
                  "(offset " + std::to_string(view.offset) + ", length " + std::to_string(view.length) + ") reaches beyond the " +
                      std::to_string(data.size()) + " bytes of its buffer");
  const std::size_t size = sizeOf(component) * components;
  if (view.stride && !may_stride) refuseElement(assembly_, view_where, "has a byteStride, which only vertex attributes may have");
  if (view.stride && view.stride < size)
    refuseElement(assembly_, view_where,
                  "has a byteStride of " + std::to_string(view.stride) + ", less than the " + std::to_string(size) + " of an element");
  const std::uint64_t step = view.stride ? view.stride : size;
  // In this order no sum or product can overflow.
  if (start > view.length || count > (view.length - start) / step + 1 || (count - 1) * step + size > view.length - start)
    refuseElement(assembly_, where,
                  "(offset " + std::to_string(start) + ", " + std::to_string(count) + " elements of " + std::to_string(step) +
                      " bytes) reaches beyond the " + std::to_string(view.length) + " bytes of " + view_where);
  return {data.data() + view.offset + start, static_cast<std::size_t>(step), count, component};
}

const Numbers& GltfAccessors::numbers(std::size_t index) {
  const auto [entry, is_new] = numbers_.try_emplace(index);
  if (!is_new) return entry->second;
  Numbers& result = entry->second;
  const GltfModel::Accessor& accessor = model_.accessors[index];
  const std::string where = result.where = place("accessors", index);
  result.normalised = accessor.is_normalised;
  result.count = accessor.count;
  if (accessor.view)
    result.dense = open(*accessor.view, accessor.offset, accessor.count, accessor.component, accessor.components, true, where);
  if (!accessor.view && !accessor.sparse) refuseElement(assembly_, where, "has no data without extensions");
  if (!accessor.sparse) return result;

  const GltfModel::Sparse& sparse = *accessor.sparse;
  const std::string indices_where = where + ".sparse.indices";
  result.sparse_indices = open(sparse.indices_view, sparse.indices_offset, sparse.count, sparse.component, 1, false, indices_where);
  result.sparse_values = open(sparse.values_view, sparse.values_offset, sparse.count, accessor.component, accessor.components, false,
                              where + ".sparse.values");
  work_.spend(sparse.count);
  for (std::uint64_t k = 0; k < sparse.count; ++k) {
    const std::uint64_t at = result.sparse_indices.unsignedAt(k);
    if (at >= result.count || (k > 0 && at <= result.sparse_indices.unsignedAt(k - 1)))
      refuseElement(
          assembly_, indices_where,
          "element " + std::to_string(k) + " is " + std::to_string(at) + "; they must rise and stay below " + std::to_string(result.count));
  }
  return result;
}

Elements GltfAccessors::indices(std::size_t index) const {
  const GltfModel::Accessor& accessor = model_.accessors[index];
  return open(*accessor.view, accessor.offset, accessor.count, accessor.component, 1, false, place("accessors", index));
}

}  // namespace spheretree::formats
