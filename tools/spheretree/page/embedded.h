// SPDX-License-Identifier: GPL-3.0-or-later
// Files that are embedded in the program, for its pages.
#pragma once

#include <string_view>

namespace spheretree::tool::embedded {

std::string_view pageStyle();      // page.css
std::string_view pageScript();     // page.js: unpacks the data, tables
std::string_view viewScript();     // view.js: the 3D view
std::string_view compareScript();  // compare.js: the 3D section of a comparison
std::string_view reportScript();   // report.js: scenes and replays of a report
std::string_view three();          // three.js r111, UMD build: https://threejs.org, MIT licence

}  // namespace spheretree::tool::embedded
