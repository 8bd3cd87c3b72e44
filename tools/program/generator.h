// SPDX-License-Identifier: GPL-3.0-or-later
// The name of these programs in the files that they write.
#pragma once

#include <string>

namespace spheretree::tool {

inline const std::string kGenerator = "spheretree " SPHERETREE_VERSION;

}  // namespace spheretree::tool
