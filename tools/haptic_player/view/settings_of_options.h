// SPDX-License-Identifier: GPL-3.0-or-later
// The settings of a window and of pictures, as the options for display select them.
#pragma once

#include "view/live_view.h"
#include "view/pictures.h"
#include "view/view_options.h"

namespace spheretree::player {

/// Converts the options for a look, a window and pictures.
view::Look lookOf(const ViewOptions& options);
LiveView::Options windowOf(const ViewOptions& options);
PictureSettings picturesOf(const ViewOptions& options);
/// Refuses options that cannot be drawn or written. @throws tool::UsageError, formats::FileError
void checkPictures(const ViewOptions& options);

}  // namespace spheretree::player
