// SPDX-License-Identifier: GPL-3.0-or-later
// The names of builders and qualities in options.
#pragma once

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "spheretree/builder/build_sphere_tree.h"

namespace spheretree::pipeline {

using builder::BuilderKind;
using builder::Quality;

inline constexpr std::array kBuilders{BuilderKind::Cover, BuilderKind::Combined, BuilderKind::Merge,
                                      BuilderKind::Burst, BuilderKind::Expand,   BuilderKind::Spawn,
                                      BuilderKind::Grid,  BuilderKind::Hubbard,  BuilderKind::Octree};
inline constexpr std::array kMembers{BuilderKind::Expand, BuilderKind::Merge, BuilderKind::Burst,
                                     BuilderKind::Spawn,  BuilderKind::Grid,  BuilderKind::Hubbard};
inline constexpr std::array kMedialAxes{builder::MedialAxis::Adaptive, builder::MedialAxis::Static};
inline constexpr std::array kQualities{Quality::Quick, Quality::Standard, Quality::Best};

/// A builder as charts and tables name it: with the cover search it is another one.
struct NamedBuilder {
  BuilderKind kind = BuilderKind::Cover;
  bool search = false;
  friend bool operator==(const NamedBuilder&, const NamedBuilder&) = default;
};
inline std::string name(const NamedBuilder& b) { return std::string(builder::name(b.kind)) + (b.search ? "+search" : ""); }

/// Cover, the published builders, and the published builders with the search.
inline const std::vector<NamedBuilder> kNamedBuilders = [] {
  std::vector<NamedBuilder> all;
  for (const bool search : {false, true})
    for (const BuilderKind kind : kBuilders)
      if (kind != BuilderKind::Cover || !search) all.push_back({kind, search});
  return all;
}();

template <class Kinds>
std::vector<std::string> namesOf(const Kinds& kinds) {
  std::vector<std::string> names;
  for (const auto kind : kinds) names.emplace_back(name(kind));
  return names;
}

/// `text` must be one of the names; CLI11 or the reader of scenes has checked it.
template <class Kinds>
auto byName(const Kinds& kinds, const std::string& text) {
  const auto found = std::find_if(kinds.begin(), kinds.end(), [&](auto kind) { return name(kind) == text; });
  if (found == kinds.end()) throw std::logic_error("no check refused the name " + text);
  return *found;
}

}  // namespace spheretree::pipeline
