// SPDX-License-Identifier: GPL-3.0-or-later
// Selects a part of a mesh: one that the file names, or #N, the connected component N as counted by `check
// --list-parts`.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::pipeline {

/// The connected components of a mesh, computed at the first call. Safe for any number of threads.
class Components {
 public:
  /// `mesh` must be the same in every call.
  const std::vector<std::uint32_t>& of(const TriangleMesh& mesh) const;  // the component of each triangle

 private:
  mutable std::once_flag searched_;
  mutable std::vector<std::uint32_t> of_;
};

/// The part of this name, or a component. @throws formats::FormatError with the choices if there is no such part.
TriangleMesh partOf(const TriangleMesh& mesh, const std::string& part, const Components& components = {});

/// The number of triangles of partOf(); of the whole mesh if `part` is empty. @throws as partOf()
std::size_t trianglesOf(const TriangleMesh& mesh, const std::string& part, const Components& components);

/// The value of --parts: "merge" selects the whole mesh. @throws as partOf()
TriangleMesh choosePart(TriangleMesh mesh, const std::string& parts);

}  // namespace spheretree::pipeline
