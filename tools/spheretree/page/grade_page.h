// SPDX-License-Identifier: GPL-3.0-or-later
// The page of `spheretree grade`: figures alone, without an opinion.
#pragma once

#include <string>
#include <vector>

#include "pipeline/cut/grade.h"

namespace spheretree::tool {

/// `left`: (object) what is left of each of its layers (grade.h), shown in 3D.
std::string gradePage(const pipeline::CutRun& run, const std::vector<pipeline::GradedObject>& objects,
                      const std::vector<std::vector<TriangleMesh>>& left, const std::string& recording);

/// "1.234 to 1.240", with as many digits as tell the bounds apart, rounded outward.
std::string boundsText(const builder::VolumeBounds& bounds);

}  // namespace spheretree::tool
