// SPDX-License-Identifier: Apache-2.0
// The numbers of a glTF model's accessors; every access is checked against the size of its buffer.
// Specification: Khronos, glTF 2.0, ISO/IEC 12113:2022, section 3.6.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "gltf/gltf_model.h"

namespace spheretree::formats {

/// Limits time and memory: small files can refer to the same data very often.
class WorkBudget {
 public:
  WorkBudget(std::uint64_t limit, const MeshAssembly& assembly) : limit_(limit), left_(limit), assembly_(assembly) {}
  /// @throws FormatError if the total exceeds the limit.
  void spend(std::uint64_t work);

 private:
  std::uint64_t limit_, left_;
  const MeshAssembly& assembly_;
};

/// `components` numbers every `stride` bytes, `count` times, all within one buffer.
struct Elements {
  const unsigned char* first = nullptr;
  std::size_t stride = 0;
  std::uint64_t count = 0;
  std::uint64_t component = kFloat32;

  std::uint64_t unsignedAt(std::uint64_t i, std::size_t axis = 0) const;
  double numberAt(std::uint64_t i, std::size_t axis, bool normalised) const;
};

/// Elements, some of which may be replaced by others (sparse accessors).
struct Numbers {
  std::string where;  // for messages
  std::uint64_t count = 0;
  bool normalised = false;
  std::optional<Elements> dense;  // empty: zeros
  Elements sparse_indices, sparse_values;

  double at(std::uint64_t i, std::size_t axis) const;
  Eigen::Vector3d vectorAt(std::uint64_t i) const;
  std::uint64_t unsignedAt(std::uint64_t i, std::size_t axis) const;  // for an unsigned component type

 private:
  /// The elements that contain element `i`, and its index there; null: zero.
  std::pair<const Elements*, std::uint64_t> find(std::uint64_t i) const;
};

class GltfAccessors {
 public:
  /// Refers to all three arguments, which must outlive it.
  GltfAccessors(const GltfModel& model, const MeshAssembly& assembly, WorkBudget& work) : model_(model), assembly_(assembly), work_(work) {}

  /// The reference stays valid. @throws FormatError if the data exceed their buffer.
  const Numbers& numbers(std::size_t accessor);
  /// An accessor with indices.
  Elements indices(std::size_t accessor) const;

 private:
  Elements open(std::size_t view_index, std::uint64_t start, std::uint64_t count, std::uint64_t component, std::size_t components,
                bool may_stride, const std::string& where) const;

  const GltfModel& model_;
  const MeshAssembly& assembly_;
  WorkBudget& work_;
  std::map<std::size_t, Numbers> numbers_;
};

}  // namespace spheretree::formats
