// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree view: shows meshes, trees, scenes and comparisons in a window or a picture.
#include <algorithm>
#include <array>
#include <memory>

#include "options/command.h"
#include "options/robot_options.h"
#include "run_files.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"
#include "terminal.h"

#ifdef SPHERETREE_VIEW
#include "draw/offscreen.h"
#include "view/shown_files.h"
#include "window/picture_maker.h"
#include "window/window.h"
#endif

namespace spheretree::tool {
namespace {

struct ViewCommand {
  std::vector<std::filesystem::path> files;
  std::filesystem::path picture;
  std::string size, theme = "dark", show, mesh, unit, panels = "on";
  int level = -1;
  double scale = 0;
  bool overhang = false, fills_panes = false;
  robot::RobotInput robot;  // its options
  std::vector<double> from;
};

#ifdef SPHERETREE_VIEW

void setLook(view::ViewerState& state, const ViewCommand& o, const std::vector<std::unique_ptr<ShownFile>>& shown) {
  view::Look& look = state.look;
  look.theme = o.theme == "light" ? view::ThemeKind::Light : view::ThemeKind::Dark;
  const bool is_chosen = o.level >= 0 || o.overhang || !o.show.empty();
  const auto opens = [&](bool ShownFile::*on) {
    return !is_chosen && std::ranges::any_of(shown, [&](const auto& file) { return (*file).*on; });
  };
  look.overhang = o.overhang || opens(&ShownFile::opens_on_overhang);
  const bool by_level = o.level >= 0 || look.overhang || opens(&ShownFile::opens_on_spheres);
  look.objects = o.show == "meshes"                ? view::Geometry::Meshes
                 : o.show == "bounds"              ? view::Geometry::Bounds
                 : o.show == "contact"             ? view::Geometry::Contact
                 : o.show == "spheres" || by_level ? view::Geometry::Spheres
                                                   : view::Geometry::Meshes;
  if (o.level >= 0) look.level = o.level;
  state.fills_panes = o.fills_panes;
  state.panels = o.panels == "on";
}

/// Refuses --level, --overhang and --show where nothing that is shown has what they ask for.
void refuseMissingSpheres(const std::vector<std::unique_ptr<ShownFile>>& shown, const ViewCommand& o) {
  std::size_t levels = 0;
  bool is_measured = false;
  for (const auto& file : shown) {
    for (const view::Body& body : file->stage.bodies) levels = std::max(levels, body.levels.size());
    is_measured = is_measured || !file->outside.empty();
  }
  if (levels == 0 && (o.level >= 0 || o.show == "spheres" || o.show == "bounds"))
    throw UsageError("there are no spheres to show: " + o.files.front().string() + " has none. Name a tree, or build one.");
  if (o.overhang && !is_measured)
    throw UsageError("--overhang colours the spheres of a tree by a mesh: name the mesh, and its tree after it.");
  if (o.level >= static_cast<int>(levels))
    throw UsageError("--level " + std::to_string(o.level) + ": the deepest tree has the levels 0 to " + std::to_string(levels - 1) + ".");
}

void setCamera(view::ViewerState& state, const ViewCommand& o, const view::Viewport& pane) {
  view::CameraWish wish;
  if (o.from.size() == 3) wish.from = Eigen::Vector3d(o.from[0], o.from[1], o.from[2]);
  if (wish.from && !(wish.from->norm() > 0)) throw UsageError("--from is the zero vector. Give a direction to look from, such as 1,-2,1.");
  state.camera = view::wishedCamera(*state.panes[0].stage, std::nullopt, wish, pane);
  view::frameWhole(state, pane);
}

int runView(const ViewCommand& o, bool quiet, builder::Progress& progress) try {
  const RunFiles files;
  for (const std::filesystem::path& file : o.files) files.willRead(file);
  if (!o.picture.empty()) files.willWrite(o.picture, {".png"}, "the picture", false);
  std::array<int, 2> size{1280, 800};
  if (!o.size.empty()) {
    const auto given = view::sizeOf(o.size);
    if (!given) throw UsageError("--size " + o.size + ": give WIDTHxHEIGHT, each from 64 to 8192, such as 1280x800");
    size = *given;
  }
  const auto shown = shownFiles({o.files, o.mesh, o.unit, o.robot}, progress);
  refuseMissingSpheres(shown, o);
  view::ViewerState state;
  for (const auto& file : shown) {
    if (!quiet)
      for (const std::string& note : file->notes) say("spheretree: warning: " + note);
    view::Pane& pane = state.panes.emplace_back();
    pane.stage = &file->stage;
    pane.shift = view::shiftBetween(*state.panes[0].stage, *pane.stage);
    pane.title = file->title;
    pane.figures = file->figures;
    pane.notes = file->notes;
  }
  if (state.panes.empty()) throw UsageError("there is nothing to show: no run of the comparison was built");
  state.title = "spheretree view";
  setLook(state, o, shown);
  if (!o.picture.empty()) {
    view::PictureMaker maker(size[0], size[1], o.scale > 0 ? o.scale : 1, state);
    setCamera(state, o, maker.layout().panes[0]);
    formats::writeWhole(o.picture, view::encodePng(maker.draw()));
    return kExitOk;
  }
  view::Window window("spheretree view", size[0], size[1], o.scale);
  view::Viewer viewer(window.gl(), window.interface(), state);
  for (bool is_first = true; window.isOpen() && !state.wants_quit; is_first = false) {
    progress.check();
    const double seconds = window.begin();
    if (is_first) setCamera(state, o, view::layoutOf(state, window.width(), window.height(), window.interface().scale()).panes[0]);
    viewer.frame(window.width(), window.height(), window.samples(), seconds, 0);
    window.present();
  }
  return kExitOk;
} catch (const view::ViewError& error) {
  return explain(kProgram, kExitFile, error.what());
}

#else

int runView(const ViewCommand&, bool, builder::Progress&) {
  throw UsageError(
      "this spheretree was built without its view. Install libglfw3-dev, libimgui-dev and libegl-dev, and build it again "
      "(-DSPHERETREE_VIEW=ON)");
}

#endif

}  // namespace

void addViewCommand(Program& program) {
  const auto o = std::make_shared<ViewCommand>();
  CLI::App* app = addVerb(program, "view", "Show meshes, trees, robots, a scene or a comparison in a window or a picture",
                          "spheretree view tooth.obj tooth.stree --overhang",
                          [o, &program](builder::Progress& progress) { return runView(*o, program.quiet, progress); });
  app->add_option(
         "FILE", o->files,
         "Meshes (.obj .stl .ply .off .gltf .glb), trees (.stree .soft .sph .json), robots (.urdf), spheres in the formats of evaluate, "
         "scenes (.json) or folders of compare, batch, split and robot. Trees and spheres are measured against the mesh or the robot "
         "before them; several inputs are shown side by side")
      ->required()
      ->type_name("FILE");
  app->add_option("--picture", o->picture, "Draw a picture (.png) without a display; default: open a window")->type_name("OUT.png");
  app->add_option("--show", o->show,
                  "meshes, spheres, bounds (bounding spheres) or contact (the surface used for contact); default meshes; spheres with "
                  "--level or --overhang, of a robot and of a comparison, there coloured by overhang")
      ->check(CLI::IsMember({"meshes", "spheres", "bounds", "contact"}))
      ->type_name("NAME");
  app->add_option("--level", o->level, "Level of the spheres, 0 to 5; default: the leaves")->type_name("N")->check(CLI::Range(0, 5));
  app->add_flag("--overhang", o->overhang, "Colour the spheres by their overhang out of the mesh before them, and mark the largest");
  app->add_option("--mesh", o->mesh, "Mesh of a comparison to show; default: its first")->type_name("NAME");
  app->add_option("--from", o->from, "Direction from the object to the eye, three numbers; default: about 1,-2,1")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3)
      ->check(CLI::Range(-1e6, 1e6));
  app->add_flag("--fill", o->fills_panes, "Let each input fill its pane; default: all are shown at one scale (key Z)");
  addRobotInput(*app, o->robot);
  app->add_option("--unit", o->unit,
                  "Unit of a mesh whose file has none, and of the meshes of a robot: mm, cm, m or in; default mm, and m for robots")
      ->type_name("UNIT")
      ->check(CLI::IsMember({"mm", "cm", "m", "in"}));
  app->add_option("--size", o->size, "Pixels as WIDTHxHEIGHT, each 64 to 8192; default 1280x800")->type_name("WIDTHxHEIGHT");
  app->add_option("--theme", o->theme, "dark or light; default dark")->type_name("NAME")->check(CLI::IsMember({"dark", "light"}));
  app->add_option("--panels", o->panels, "on or off; default on")->type_name("NAME")->check(CLI::IsMember({"on", "off"}));
  app->add_option("--scale", o->scale, "Scale of text and marks, 0.5 to 4; default: that of the display, 1 for pictures")
      ->type_name("FACTOR")
      ->check(CLI::Range(0.5, 4.0));
}

}  // namespace spheretree::tool
