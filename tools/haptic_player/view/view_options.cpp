// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/view_options.h"

namespace spheretree::player {

void addViewOptions(CLI::App& cli, ViewOptions& o) {
  cli.add_flag("--view", o.view, "Open a window that shows the run, and in which the mouse moves the hand");
  cli.add_option("--hand-from", o.hand_from,
                 "With --view: input that moves the simulated hand: mouse, keyboard, gamepad, spacemouse or file; default mouse. The hand "
                 "begins where --trajectory begins")
      ->type_name("NAME")
      ->check(CLI::IsMember({"mouse", "keyboard", "gamepad", "spacemouse", "file"}));
  CLI::Option* replay =
      cli.add_option("--replay", o.replay, "Show a recording (CSV) with a time slider, without computing steps again")->type_name("FILE");
  cli.add_option("--compare", o.compare, "With --replay: another recording, shown beside it")->type_name("FILE")->needs(replay);
  CLI::Option* picture =
      cli.add_option("--picture", o.picture, "Draw a picture (PNG) of a stepped run or of a recording, without a display")
          ->type_name("FILE");
  cli.add_option("--at", o.at, "With --picture: step to draw, or FROM:TO:EVERY for numbered pictures; default 2000")
      ->type_name("STEP")
      ->needs(picture);
  cli.add_option("--size", o.size, "With --view or --picture: pixels as WIDTHxHEIGHT, each 64 to 8192; default 1280x800")
      ->type_name("WIDTHxHEIGHT");
  cli.add_option("--theme", o.theme, "With --view or --picture: dark or light; default dark")
      ->type_name("NAME")
      ->check(CLI::IsMember({"dark", "light"}));
  cli.add_option("--show", o.show,
                 "With --view or --picture: meshes, spheres, bounds (bounding spheres) or contact (the surface used for contact); default "
                 "meshes")
      ->type_name("NAME")
      ->check(CLI::IsMember({"meshes", "spheres", "bounds", "contact"}));
  cli.add_option("--from", o.from,
                 "With --view or --picture: direction from the tool to the eye, three numbers; default: a direction in which the tool is "
                 "well visible")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3)
      ->check(CLI::Range(-1e6, 1e6));
  cli.add_option("--within", o.within,
                 "With --view or --picture: size of the region shown around the tool, 0.1 to 10000 mm; default: from the scene")
      ->type_name("MM")
      ->check(CLI::Range(0.1, 10000.0));
  cli.add_flag("--follow", o.follow, "With --view or --picture: the view moves with the tool");
  cli.add_option("--panels", o.panels, "With --view or --picture: panels and plots, on or off; default on")
      ->type_name("NAME")
      ->check(CLI::IsMember({"on", "off"}));
  cli.add_option("--scale", o.scale,
                 "With --view or --picture: scale of text and marks, 0.5 to 4; default: that of the display, 1 for pictures")
      ->type_name("FACTOR")
      ->check(CLI::Range(0.5, 4.0));
}

}  // namespace spheretree::player
