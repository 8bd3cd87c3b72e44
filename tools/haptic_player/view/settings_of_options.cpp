// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/settings_of_options.h"

#include "program_end.h"
#include "run_files.h"

namespace spheretree::player {

using tool::UsageError;

view::Look lookOf(const ViewOptions& o) {
  view::Look look;
  look.theme = o.theme == "light" ? view::ThemeKind::Light : view::ThemeKind::Dark;
  look.objects = look.tool = o.show == "spheres"   ? view::Geometry::Spheres
                             : o.show == "bounds"  ? view::Geometry::Bounds
                             : o.show == "contact" ? view::Geometry::Contact
                                                   : view::Geometry::Meshes;
  return look;
}

view::CameraWish wishOf(const ViewOptions& o) {
  view::CameraWish wish;
  if (o.from.size() == 3) wish.from = Eigen::Vector3d(o.from[0], o.from[1], o.from[2]);
  if (wish.from && !(wish.from->norm() > 0)) throw UsageError("--from is the zero vector. Give a direction to look from, such as 1,-2,1");
  wish.within = o.within;
  return wish;
}

ViewSettings settingsOf(const ViewOptions& o) {
  ViewSettings out;
  if (!o.size.empty()) {
    const auto [width, height] = pictureSize(o.size);
    out.width = width;
    out.height = height;
  }
  out.scale = o.scale;
  out.look = lookOf(o);
  out.wish = wishOf(o);
  out.panels = o.panels == "on";
  out.follow = o.follow;
  return out;
}

LiveView::Options windowOf(const ViewOptions& o) { return {settingsOf(o)}; }

PictureSettings picturesOf(const ViewOptions& o) {
  PictureSettings out{settingsOf(o), o.picture, pictureSteps(o.at.empty() ? "2000" : o.at)};
  if (!(out.scale > 0)) out.scale = 1;
  return out;
}

void checkPictures(const ViewOptions& o) {
  if (o.picture.empty()) return;
  if (o.view) throw UsageError("--picture draws into a file and --view into a window. Leave one of them out");
  const tool::RunFiles files;
  const PictureSettings pictures = picturesOf(o);
  files.willWrite(o.picture, {".png"}, "the picture", false);
  if (pictures.steps.isOne()) return;
  const std::string before = o.picture.stem().string() + ".", after = o.picture.extension().string();
  files.keepOthers(o.picture.parent_path(), [&](const std::string& name) {
    return name.size() > before.size() + after.size() && name.starts_with(before) && name.ends_with(after) &&
           name.find_first_not_of("0123456789", before.size()) == name.size() - after.size();
  });
}

}  // namespace spheretree::player
