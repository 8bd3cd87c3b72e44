// SPDX-License-Identifier: GPL-3.0-or-later
#include "panel/panels.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "draw/scene_drawer.h"
#include "model/cut_surface.h"
#include "panel/controls.h"
#include "panel/interface.h"
#include "panel/plots.h"

namespace spheretree::view {
namespace {

constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoNav;

/// A separate window that fills `place`.
bool beginPlace(const char* name, const Viewport& place, ImGuiWindowFlags more = 0) {
  ImGui::SetNextWindowPos({static_cast<float>(place.x), static_cast<float>(place.y)});
  ImGui::SetNextWindowSize({static_cast<float>(place.width), static_cast<float>(place.height)});
  return ImGui::Begin(name, nullptr, kFixed | more);
}

void heading(const char* text, const Theme& theme) {
  ImGui::Spacing();
  ImGui::PushStyleColor(ImGuiCol_Text, packed(theme.spring));
  ImGui::TextUnformatted(text);
  ImGui::PopStyleColor();
}

void drawLamp(const Lamp& lamp, const Theme& theme) {
  const float size = ImGui::GetFontSize();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec2 middle{at.x + 0.45f * size, at.y + 0.5f * size};
  // On: a full disc. Was on: half of one. Never on: a ring. Shape and colour both show the state.
  const Colour colour = lamp.is_fault ? (lamp.is_on ? theme.bad : theme.warning) : theme.spring;
  if (lamp.is_on)
    list.AddCircleFilled(middle, 0.34f * size, packed(colour));
  else if (lamp.was_on)
    list.AddCircleFilled(middle, 0.2f * size, packed(colour));
  list.AddCircle(middle, 0.34f * size, packed(lamp.is_on || lamp.was_on ? colour : theme.faint), 0, 1.3f);
  ImGui::Dummy({0.95f * size, size});
  ImGui::SameLine(0, 0.25f * size);
  ImGui::PushStyleColor(ImGuiCol_Text, packed(lamp.is_on || lamp.was_on ? theme.text : theme.faint));
  ImGui::TextUnformatted(lamp.name.c_str());
  ImGui::PopStyleColor();
  if (!ImGui::IsItemHovered()) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(22 * size);
  ImGui::TextUnformatted(lamp.sentence.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

void drawFigureLines(const std::vector<FigureLine>& lines, const Theme& theme) {
  const float right = ImGui::GetWindowContentRegionMax().x;
  for (const FigureLine& line : lines) {
    ImGui::PushStyleColor(ImGuiCol_Text, packed(theme.faint));
    ImGui::TextUnformatted(line.name.c_str());
    ImGui::PopStyleColor();
    const float begin = right - ImGui::CalcTextSize(line.value.c_str()).x;
    if (ImGui::CalcTextSize(line.name.c_str()).x + ImGui::GetFontSize() < begin)
      ImGui::SameLine(begin);
    else
      ImGui::SetCursorPosX(begin);  // on a new line
    ImGui::PushStyleColor(ImGuiCol_Text, packed(line.is_bad ? theme.bad : theme.text));
    ImGui::TextUnformatted(line.value.c_str());
    ImGui::PopStyleColor();
  }
}

void drawFigures(const Pane& pane, const Theme& theme) {
  drawFigureLines(pane.figures, theme);
  for (const std::string& note : pane.notes) {
    ImGui::PushStyleColor(ImGuiCol_Text, packed(theme.warning));
    ImGui::TextWrapped("%s", note.c_str());
    ImGui::PopStyleColor();
  }
}

/// A section that can be closed. The state stays for the time of the window.
bool beginSection(const char* name, const Theme& theme, bool is_open) {
  ImGui::PushStyleColor(ImGuiCol_Text, packed(theme.spring));
  const bool shows = ImGui::TreeNodeEx(name, ImGuiTreeNodeFlags_NoTreePushOnOpen | ImGuiTreeNodeFlags_SpanAvailWidth |
                                                 (is_open ? ImGuiTreeNodeFlags_DefaultOpen : ImGuiTreeNodeFlags_None));
  ImGui::PopStyleColor();
  return shows;
}

/// The lamps that are or were on; all of them in a section that is closed at first, for they need much room.
void drawLamps(const Pane& pane, const Theme& theme) {
  if (pane.lamps.empty()) return;
  const bool shows_all = beginSection("Faults and safety", theme, false);
  if (!ImGui::BeginTable("lamps", 2)) return;
  for (const Lamp& lamp : pane.lamps) {
    if (!shows_all && !lamp.is_on && !lamp.was_on) continue;
    ImGui::TableNextColumn();
    drawLamp(lamp, theme);
  }
  ImGui::EndTable();
}

/// Pause, one step, pace, beginning.
void drawCourse(RunCourse& course) {
  if (!course.is_live) return;
  const float text = ImGui::GetFontSize();
  if (ImGui::Button(course.is_paused ? "Go on" : "Pause", {4.2f * text, 0})) course.is_paused = !course.is_paused;
  ImGui::SameLine();
  if (ImGui::Button("Step")) course.is_paused = true, ++course.wanted_steps;
  ImGui::SameLine();
  if (ImGui::Button("Reset")) course.wants_restart = true;
  ImGui::SameLine();
  const auto name = [](int slowness) { return slowness == 1 ? std::string("1x") : "1/" + std::to_string(slowness); };
  ImGui::SetNextItemWidth(-1);
  if (!ImGui::BeginCombo("##pace", name(course.slowness).c_str())) return;
  for (int slowness = 1; slowness <= RunCourse::kSlowest; slowness *= 2)
    if (ImGui::Selectable(name(slowness).c_str(), slowness == course.slowness)) course.slowness = slowness;
  ImGui::EndCombo();
}

void drawSelected(ViewerState& state, const Theme& theme) {
  if (!state.selected || state.panes.size() != 1) return;
  const Stage& stage = *state.panes[0].stage;
  const Body& body = stage.bodies[stage.objects[*state.selected].body];
  heading(body.name.c_str(), theme);
  if (!body.meaning.empty()) ImGui::TextWrapped("%s", body.meaning.c_str());
  drawFigureLines(objectFigures(state.panes[0], *state.selected), theme);
}

/// A square in a colour, before a name.
void drawSwatch(Colour colour) {
  const float size = 0.7f * ImGui::GetFontSize(), inset = 0.5f * (ImGui::GetFrameHeight() - size);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::GetWindowDrawList()->AddRectFilled({at.x, at.y + inset}, {at.x + size, at.y + inset + size}, packed(colour), 2);
  ImGui::Dummy({size, size});
  ImGui::SameLine();
}

/// The colours of the layers that walls show, each name once.
void drawLayers(const Stage& stage, const Theme& theme) {
  std::vector<const CutMaterial::Layer*> layers;
  for (const PlacedObject& object : stage.objects) {
    if (!object.cut) continue;
    for (const CutMaterial::Layer& layer : object.cut->layers)
      if (std::ranges::none_of(layers, [&](const auto* other) { return other->name == layer.name; })) layers.push_back(&layer);
  }
  if (layers.empty()) return;
  heading("Layers", theme);
  if (!ImGui::BeginTable("layers", 2)) return;
  for (const CutMaterial::Layer* layer : layers) {
    ImGui::TableNextColumn();
    drawSwatch(layer->colour);
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(layer->name.c_str());
  }
  ImGui::EndTable();
}

/// Name and figures beside the pointer.
void drawHovered(const ViewerState& state, const Theme& theme) {
  if (!state.hovered || state.panes.size() != 1 || ImGui::GetIO().WantCaptureMouse) return;
  const Stage& stage = *state.panes[0].stage;
  const Body& body = stage.bodies[stage.objects[*state.hovered].body];
  ImGui::BeginTooltip();
  ImGui::PushStyleColor(ImGuiCol_Text, packed(theme.spring));
  ImGui::TextUnformatted(body.name.c_str());
  ImGui::PopStyleColor();
  if (!body.meaning.empty()) ImGui::TextUnformatted(body.meaning.c_str());
  for (const FigureLine& line : objectFigures(state.panes[0], *state.hovered)) ImGui::Text("%s: %s", line.name.c_str(), line.value.c_str());
  ImGui::EndTooltip();
}

bool chooseGeometry(const char* label, Geometry& geometry) {
  const char* const names[] = {"meshes", "spheres of a level", "bounding spheres", "what contact uses"};
  int index = static_cast<int>(geometry);
  ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 4.2f);
  if (!ImGui::Combo(label, &index, names, 4)) return false;
  geometry = static_cast<Geometry>(index);
  return true;
}

void drawLook(ViewerState& state, const Layout& layout, const Theme& theme) {
  if (!beginSection("Show", theme, state.settings.empty())) return;  // sliders need the room
  Look& look = state.look;
  const Stage& stage = *state.panes[0].stage;
  const bool has_tool = state.panes[0].has_state;
  chooseGeometry("objects", look.objects);
  if (has_tool) chooseGeometry("tool", look.tool);
  const bool by_level = look.objects == Geometry::Spheres || look.objects == Geometry::Bounds || look.tool == Geometry::Spheres ||
                        look.tool == Geometry::Bounds;
  const int last = stage.levelCount() - 1;
  if (by_level && last > 0) {
    int level = std::min(look.level, last);
    ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 4.2f);
    if (ImGui::SliderInt("level", &level, 0, last)) look.level = level;
  }
  const auto check = [](const char* name, bool& value) { ImGui::Checkbox(name, &value); };
  if (ImGui::BeginTable("shown", 2)) {
    const auto cell = [&](const char* name, bool& value) {
      ImGui::TableNextColumn();
      check(name, value);
    };
    if (has_tool) {
      cell("force", look.force);
      cell("torque", look.torque);
      cell("spring", look.spring);
      cell("contacts", look.contacts);
      cell("haptic tool", look.haptic_tool);
      cell("cut away", look.cut);
      cell("follow tool", state.follow);
    }
    bool overhangs = false;
    for (const Body& body : stage.bodies) overhangs = overhangs || !body.overhangs.empty();
    if (overhangs) cell("overhang", look.overhang);
    if (state.panes.size() > 1) {
      const bool before = state.fills_panes;
      cell("fill the panes", state.fills_panes);
      if (state.fills_panes != before) frameWhole(state, layout.panes[0]);
    }
    bool light = look.theme == ThemeKind::Light;
    cell("light", light);
    look.theme = light ? ThemeKind::Light : ThemeKind::Dark;
    ImGui::EndTable();
  }
}

void drawObjects(ViewerState& state, const Theme& theme) {
  const Stage& stage = *state.panes[0].stage;
  if (stage.objects.size() < 2) return;
  heading("Objects", theme);
  state.look.hidden.resize(stage.objects.size(), false);
  if (ImGui::SmallButton("all")) std::fill(state.look.hidden.begin(), state.look.hidden.end(), false), state.look.glass.clear();
  ImGui::SameLine();
  if (ImGui::SmallButton("none")) std::fill(state.look.hidden.begin(), state.look.hidden.end(), true);
  // All that is left of the panel, but at least some rows; then the panel scrolls.
  const float room = std::max(ImGui::GetContentRegionAvail().y, 8 * ImGui::GetFrameHeightWithSpacing());
  float widest = 0;
  for (const PlacedObject& object : stage.objects) widest = std::max(widest, ImGui::CalcTextSize(stage.bodies[object.body].name.c_str()).x);
  const int columns = 2 * (widest + 3 * ImGui::GetFontSize()) < ImGui::GetContentRegionAvail().x ? 2 : 1;
  if (ImGui::BeginChild("objects", {0, room}) && ImGui::BeginTable("names", columns)) {
    for (std::size_t i = 0; i < stage.objects.size(); ++i) {
      const Body& body = stage.bodies[stage.objects[i].body];
      bool shown = !state.look.hidden[i];
      ImGui::TableNextColumn();
      ImGui::PushID(static_cast<int>(i));
      drawSwatch(body.colour);
      ImGui::Checkbox(body.name.c_str(), &shown);
      ImGui::PopID();
      state.look.hidden[i] = !shown;
    }
    ImGui::EndTable();
  }
  ImGui::EndChild();
}

void drawValues(std::vector<ValueControl>& values) {
  for (ValueControl& control : values) {
    auto value = static_cast<float>(control.wish.value_or(control.now));
    ImGui::PushID(control.name.c_str());
    ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 5.5f);
    if (ImGui::SliderFloat(control.name.c_str(), &value, static_cast<float>(control.lowest), static_cast<float>(control.highest),
                           control.format, ImGuiSliderFlags_AlwaysClamp))
      control.wish = static_cast<double>(value);
    if (control.wish && ImGui::SmallButton("as the scene says")) control.wish.reset();
    ImGui::PopID();
  }
}

void drawRendering(ViewerState& state, const Theme& theme) {
  if (!state.hinges.empty() && beginSection("Bodies", theme, true)) drawValues(state.hinges);
  if (state.settings.empty() || !beginSection("Feel", theme, true)) return;
  drawValues(state.settings);
  for (std::size_t k = 0; k < state.modes.size(); ++k) {
    if (k > 0) ImGui::SameLine();
    if (ImGui::RadioButton(state.modes[k].c_str(), state.wants_other_mode == (k == 1))) state.wants_other_mode = k == 1;
  }
  if (state.wants_other_mode != state.is_other_mode) ImGui::TextColored(ImColor(packed(theme.warning)), "as soon as nothing is touched");
}

void drawSide(ViewerState& state, const Layout& layout, const Theme& theme) {
  if (beginPlace("side", layout.panel)) {
    ImGui::TextUnformatted(state.title.c_str());
    drawCourse(state.course);
    if (state.can_record) {
      if (ImGui::Button(state.recording.empty() ? "Record (R)" : "Stop recording (R)")) state.wants_record = true;
      if (!state.recording.empty()) {
        ImGui::PushStyleColor(ImGuiCol_Text, packed(theme.bad));
        ImGui::TextWrapped("to %s", state.recording.c_str());
        ImGui::PopStyleColor();
      }
    }
    if (!state.film.empty()) {
      ImGui::PushStyleColor(ImGuiCol_Text, packed(theme.bad));
      ImGui::TextWrapped("film (V): %s", state.film.c_str());
      ImGui::PopStyleColor();
    }
    if (state.can_spin && ImGui::Button(state.panes[0].state.step.spins ? "Stop the burr (B)" : "Start the burr (B)"))
      state.wants_spindle = true;
    for (const Pane& pane : state.panes) {
      ImGui::PushID(&pane);
      if (!pane.title.empty()) heading(pane.title.c_str(), theme);
      ImGui::Separator();
      drawFigures(pane, theme);
      drawLamps(pane, theme);
      ImGui::PopID();
    }
    drawLayers(*state.panes[0].stage, theme);
    drawSelected(state, theme);
    drawRendering(state, theme);
    drawLook(state, layout, theme);
    drawObjects(state, theme);
  }
  ImGui::End();
}

void drawPlots(ViewerState& state, const Viewport& place, const Theme& theme) {
  if (beginPlace("plots", place, ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse)) {
    const std::span<const PlotSample> all = state.panes[0].samples;
    double begin = 0, end = 1;
    std::optional<double> mark;
    if (state.playback) {
      // Either the whole run fits, or a window around the mark is shown.
      const double at = all[std::min(state.playback->step(), all.size() - 1)].time, first = all.front().time, last = all.back().time;
      mark = at;
      const double half = state.plot_seconds / 2;
      begin = std::clamp(at - half, first, std::max(first, last - 2 * half));
      end = std::min(last, begin + 2 * half);
    } else {
      end = all.back().time;
      begin = end - state.plot_seconds;
    }
    const auto part = [&](std::span<const PlotSample> samples) {
      const auto from = std::partition_point(samples.begin(), samples.end(), [&](const PlotSample& s) { return s.time < begin; });
      const auto to = std::partition_point(from, samples.end(), [&](const PlotSample& s) { return s.time <= end; });
      return samples.subspan(static_cast<std::size_t>(from - samples.begin()), static_cast<std::size_t>(to - from));
    };
    const std::span<const PlotSample> other = state.panes.size() > 1 ? part(state.panes[1].samples) : std::span<const PlotSample>();
    const std::vector<Plot> plots = plotsOf(part(all), other, theme, state.limits);
    const float gap = 0.4f * ImGui::GetFontSize(), seconds_width = 3.1f * ImGui::GetFontSize();
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const auto count = static_cast<float>(plots.size());
    const float width = (room.x - seconds_width - count * gap) / count;
    ImGui::BeginGroup();
    for (const double seconds : {2.0, 10.0, 60.0}) {
      char name[16];
      std::snprintf(name, sizeof name, "%g s", seconds);
      if (ImGui::RadioButton(name, state.plot_seconds == seconds)) state.plot_seconds = seconds;
    }
    if (state.frozen) ImGui::TextColored(ImColor(packed(theme.warning)), "frozen");
    ImGui::EndGroup();
    for (const Plot& plot : plots) {
      ImGui::SameLine(0, gap);
      ImGui::BeginGroup();
      drawPlot(plot, begin, end, mark, width, room.y, theme);
      ImGui::EndGroup();
    }
  }
  ImGui::End();
}

void drawScrubber(Playback& playback, const Viewport& place) {
  if (beginPlace("scrubber", place, ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse)) {
    if (ImGui::Button(playback.isPlaying() ? "wait" : "play", {3.4f * ImGui::GetFontSize(), 0})) playback.toggle();
    ImGui::SameLine();
    char speed[32];
    std::snprintf(speed, sizeof speed, "%.3gx", playback.speed());
    ImGui::SetNextItemWidth(5 * ImGui::GetFontSize());
    if (ImGui::BeginCombo("##speed", speed)) {
      for (const double s : {0.01, 0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0}) {
        char name[32];
        std::snprintf(name, sizeof name, "%.3gx", s);
        if (ImGui::Selectable(name, s == playback.speed())) playback.setSpeed(s);
      }
      ImGui::EndCombo();
    }
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1);
    int step = static_cast<int>(playback.step());
    char shown[64];
    std::snprintf(shown, sizeof shown, "step %d of %zu  (%.3f s)", step, playback.steps(), step / 1000.0);
    if (ImGui::SliderInt("##step", &step, 0, static_cast<int>(playback.steps()) - 1, shown)) {
      playback.pause();
      playback.seek(step);
    }
  }
  ImGui::End();
}

/// A bar of a round length that shows the scale.
void drawScaleBar(ImDrawList& list, const Camera& camera, const Viewport& pane, const Theme& theme) {
  const float text = ImGui::GetFontSize();
  const double pixel = camera.pixelAt(camera.target, pane);
  double mm = roundEnd(5 * static_cast<double>(text) * pixel);
  const auto length = static_cast<float>(mm / pixel);
  const ImVec2 left{static_cast<float>(pane.x) + text, static_cast<float>(pane.y + pane.height) - 1.1f * text};
  const ImVec2 right{left.x + length, left.y};
  const unsigned colour = packed(theme.text, 0.85);
  list.AddLine(left, right, colour, 2);
  list.AddLine({left.x, left.y - 4}, {left.x, left.y + 4}, colour, 2);
  list.AddLine({right.x, right.y - 4}, {right.x, right.y + 4}, colour, 2);
  char name[32];
  std::snprintf(name, sizeof name, "%g mm", mm);
  list.AddText({left.x, left.y - 1.35f * text}, colour, name);
}

/// Text on a plate of the background, readable in front of anything.
void label(ImDrawList& list, ImVec2 at, Colour colour, const Theme& theme, const char* text) {
  const ImVec2 extent = ImGui::CalcTextSize(text);
  const float edge = 0.2f * ImGui::GetFontSize();
  list.AddRectFilled({at.x - edge, at.y - edge / 2}, {at.x + extent.x + edge, at.y + extent.y + edge / 2}, packed(theme.bottom, 0.75),
                     edge);
  list.AddText(at, packed(colour), text);
}

void drawLabels(const ViewerState& state, const Layout& layout, double scale, const Theme& theme) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float text = ImGui::GetFontSize();
  for (std::size_t k = 0; k < state.panes.size(); ++k) {
    const Pane& pane = state.panes[k];
    const Viewport& place = layout.panes[k];
    list.PushClipRect({static_cast<float>(place.x), static_cast<float>(place.y)},
                      {static_cast<float>(place.x + place.width), static_cast<float>(place.y + place.height)});
    const Camera camera = cameraOf(state, k);
    drawScaleBar(list, camera, place, theme);
    if (state.panes.size() > 1 && !pane.title.empty())
      label(list, {static_cast<float>(place.x) + text, static_cast<float>(place.y) + 0.6f * text}, theme.text, theme, pane.title.c_str());
    if (place.x > 0)
      list.AddLine({static_cast<float>(place.x), static_cast<float>(place.y)},
                   {static_cast<float>(place.x), static_cast<float>(place.y + place.height)}, packed(theme.line), 2);
    const auto arrow = state.look.force ? forceArrow(shownState(pane), camera, place, scale) : std::nullopt;
    const auto tip = arrow ? camera.pixelOf(arrow->from + 1.08 * arrow->along, place) : std::nullopt;
    const auto place_to_press = state.press_here ? camera.pixelOf(*state.press_here, place) : std::nullopt;
    if (place_to_press) {
      const ImVec2 at{static_cast<float>(place_to_press->x()), static_cast<float>(place_to_press->y())};
      list.AddCircle(at, 0.7f * text, packed(theme.warning), 0, 2);
      label(list, {at.x + text, at.y + 0.3f * text}, theme.warning, theme, "press here");
    }
    if (tip) {
      char newtons[32];
      std::snprintf(newtons, sizeof newtons, "%.2f N", arrow->newtons);
      label(list, {static_cast<float>(tip->x()) + 0.4f * text, static_cast<float>(tip->y()) - 0.6f * text}, theme.force, theme, newtons);
    }
    list.PopClipRect();
  }
}

void drawOverhangScale(const ViewerState& state, const Viewport& place, const Theme& theme) {
  if (!state.look.overhang) return;
  double largest = 0;
  for (const Pane& pane : state.panes)
    for (const Body& body : pane.stage->bodies)
      if (!body.overhang_max.empty())
        largest = std::max(
            largest, body.overhang_max[std::min(static_cast<std::size_t>(std::max(state.look.level, 0)), body.overhang_max.size() - 1)]);
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float text = ImGui::GetFontSize(), width = 12 * text;
  const ImVec2 at{static_cast<float>(place.x + place.width) - width - text, static_cast<float>(place.y + place.height) - 1.6f * text};
  for (int k = 0; k < 64; ++k)
    list.AddRectFilled({at.x + width * static_cast<float>(k) / 64, at.y},
                       {at.x + width * static_cast<float>(k + 1) / 64, at.y + 0.6f * text}, packed(heat((k + 0.5) / 64)));
  char name[64];
  std::snprintf(name, sizeof name, "overhang: 0 to %.3g mm", largest);
  list.AddText({at.x, at.y - 1.3f * text}, packed(theme.text), name);
}

void drawHelp(ViewerState& state, const Layout& layout) {
  if (!state.help) return;
  ImGui::SetNextWindowPos({static_cast<float>(layout.scene.width) / 2, static_cast<float>(layout.scene.height) / 2}, ImGuiCond_Always,
                          {0.5f, 0.5f});
  if (ImGui::Begin(
          "Keys", &state.help,
          ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoMove)) {
    if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
      for (const HelpLine& line : helpLines(state)) {
        ImGui::TableNextColumn();
        ImGui::TextDisabled("%s", line.key.c_str());
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(line.does.c_str());
      }
      ImGui::EndTable();
    }
  }
  ImGui::End();
}

void drawHint(const ViewerState& state, const Layout& layout, const Theme& theme) {
  const std::string all = "?: all keys";
  std::string text = state.message;
  if (text.empty() && state.course.is_live && state.course.is_paused) text = "paused: Space goes on, N takes a step";
  const bool is_hint = text.empty();
  if (text.empty()) {
    const float room = static_cast<float>(layout.scene.width) - 3 * ImGui::GetFontSize() - ImGui::CalcTextSize(all.c_str()).x;
    for (const HelpLine& line : helpLines(state)) {
      const std::string more = text + line.key + ": " + line.does + "    ";
      if (ImGui::CalcTextSize(more.c_str()).x > room || more.size() > 110) break;
      text = more;
    }
    text += all;
  }
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float size = ImGui::GetFontSize();
  const ImVec2 at{static_cast<float>(layout.scene.x) + size,
                  static_cast<float>(layout.scene.y) + (state.panes.size() > 1 ? 2 : 0.6f) * size};
  const ImVec2 extent = ImGui::CalcTextSize(text.c_str());
  list.AddRectFilled({at.x - 0.4f * size, at.y - 0.2f * size}, {at.x + extent.x + 0.4f * size, at.y + extent.y + 0.25f * size},
                     packed(theme.panel, 0.6), 0.3f * size);
  list.AddText(at, packed(is_hint ? theme.text : theme.warning, 0.9), text.c_str());
}

}  // namespace

void drawPanels(ViewerState& state, const Layout& layout, double scale) {
  const Theme theme = themeOf(state.look.theme);
  drawLabels(state, layout, scale, theme);
  drawOverhangScale(state, layout.scene, theme);
  if (state.panels) drawHint(state, layout, theme);
  if (layout.panel.width > 1) drawSide(state, layout, theme);
  if (layout.plots.width > 1) drawPlots(state, layout.plots, theme);
  if (layout.scrubber.width > 1 && state.playback && state.panels) drawScrubber(*state.playback, layout.scrubber);
  drawHovered(state, theme);
  drawHelp(state, layout);
}

}  // namespace spheretree::view
