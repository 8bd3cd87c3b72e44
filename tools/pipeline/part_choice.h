// SPDX-License-Identifier: GPL-3.0-or-later
// Which part of a mesh is meant: one that the file names, or #N, the connected component N as `check --list-parts`
// counts them.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::pipeline {

/// The connected components of a mesh, found when first asked for. Safe for any number of threads.
class Components {
 public:
  /// `mesh` must be the same each time.
  const std::vector<std::uint32_t>& of(const TriangleMesh& mesh) const;  // the component of each triangle

 private:
  mutable std::once_flag searched_;
  mutable std::vector<std::uint32_t> of_;
};

/// A part of this name, or else a component. @throws formats::FormatError with the choices if there is none such.
TriangleMesh partOf(const TriangleMesh& mesh, const std::string& part, const Components& components = {});

/// How many triangles partOf() has; of the whole mesh if `part` is empty. @throws as partOf()
std::size_t trianglesOf(const TriangleMesh& mesh, const std::string& part, const Components& components);

/// --parts: "merge" is the whole mesh. @throws as partOf()
TriangleMesh choosePart(TriangleMesh mesh, const std::string& parts);

}  // namespace spheretree::pipeline
