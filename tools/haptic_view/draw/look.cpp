// SPDX-License-Identifier: GPL-3.0-or-later
#include "draw/look.h"

namespace spheretree::view {

Theme themeOf(ThemeKind kind) {
  if (kind == ThemeKind::Light)
    return {.top = {250, 251, 253, 255},
            .bottom = {214, 221, 230, 255},
            .text = {24, 30, 40, 255},
            .faint = {92, 102, 116, 255},
            .panel = {255, 255, 255, 232},
            .line = {196, 204, 214, 255},
            .haptic = {40, 108, 190, 110},
            .graphic = {128, 142, 162, 255},
            .force = {214, 106, 0, 255},
            .torque = {164, 72, 140, 255},
            .spring = {0, 114, 178, 255},
            .warning = {176, 112, 0, 255},
            .good = {0, 128, 98, 255},
            .bad = {196, 58, 20, 255}};
  return {.top = {44, 52, 66, 255},
          .bottom = {17, 20, 27, 255},
          .text = {232, 236, 242, 255},
          .faint = {150, 160, 174, 255},
          .panel = {25, 29, 37, 228},
          .line = {66, 75, 90, 255},
          .haptic = {130, 196, 255, 96},
          .graphic = {182, 196, 214, 255},
          .force = {255, 168, 40, 255},
          .torque = {222, 138, 190, 255},
          .spring = {96, 186, 240, 255},
          .warning = {240, 196, 66, 255},
          .good = {40, 186, 140, 255},
          .bad = {244, 108, 58, 255}};
}

}  // namespace spheretree::view
