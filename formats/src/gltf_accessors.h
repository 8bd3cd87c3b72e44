// SPDX-License-Identifier: Apache-2.0
// The numbers of a glTF model's accessors, each place checked to lie within its buffer before it is read.
// Specification: Khronos, glTF 2.0, ISO/IEC 12113:2022, section 3.6.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "gltf_model.h"

namespace spheretree::formats {

/// Bounds time and memory: small files can name the same thing very often.
class WorkBudget {
 public:
  WorkBudget(std::uint64_t limit, const MeshAssembly& assembly) : limit_(limit), left_(limit), assembly_(assembly) {}
  /// @throws FormatError if more is spent than the limit.
  void spend(std::uint64_t work);

 private:
  std::uint64_t limit_, left_;
  const MeshAssembly& assembly_;
};

/// `components` numbers every `stride` bytes, `count` times, all within the memory of one buffer.
struct Elements {
  const unsigned char* first = nullptr;
  std::size_t stride = 0;
  std::uint64_t count = 0;
  std::uint64_t component = kFloat32;

  std::uint64_t unsignedAt(std::uint64_t i, std::size_t axis = 0) const;
  double numberAt(std::uint64_t i, std::size_t axis, bool normalised) const;
};

/// Elements, some of which others may replace (sparse accessors).
struct Numbers {
  std::string where;  // for messages
  std::uint64_t count = 0;
  bool normalised = false;
  std::optional<Elements> dense;  // none: zeros
  Elements sparse_indices, sparse_values;

  double at(std::uint64_t i, std::size_t axis) const;
  Eigen::Vector3d vectorAt(std::uint64_t i) const;
  std::uint64_t unsignedAt(std::uint64_t i, std::size_t axis) const;  // of a component that is unsigned

 private:
  /// The elements that hold element `i`, and its place there; none: zero.
  std::pair<const Elements*, std::uint64_t> find(std::uint64_t i) const;
};

class GltfAccessors {
 public:
  /// Refers to all three, which must outlive it.
  GltfAccessors(const GltfModel& model, const MeshAssembly& assembly, WorkBudget& work) : model_(model), assembly_(assembly), work_(work) {}

  /// Stays valid. @throws FormatError if it reaches beyond its buffer.
  const Numbers& numbers(std::size_t accessor);
  /// One that holds indices.
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
