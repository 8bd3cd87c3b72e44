// SPDX-License-Identifier: GPL-3.0-or-later
#include "panel/interface.h"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace spheretree::view {
namespace {

ImVec4 floats(Colour c, double opacity = 1) {
  const auto share = [](std::uint8_t v) { return static_cast<float>(v) / 255; };
  return {share(c.r), share(c.g), share(c.b), share(c.a) * static_cast<float>(opacity)};
}

/// DejaVu if the system has it, otherwise the font of Dear ImGui.
void addFont(double scale) {
  ImGuiIO& io = ImGui::GetIO();
  const char* path = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  static const ImWchar kRanges[] = {0x20, 0xff, 0x2010, 0x2027, 0x2190, 0x21ff, 0x25a0, 0x25ff, 0x2713, 0x2717, 0};
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored) &&
      io.Fonts->AddFontFromFileTTF(path, static_cast<float>(std::round(14 * scale)), nullptr, kRanges))
    return;
  ImFontConfig config;
  config.SizePixels = static_cast<float>(std::round(13 * scale));
  io.Fonts->AddFontDefault(&config);
}

}  // namespace

unsigned packed(Colour c) { return IM_COL32(c.r, c.g, c.b, c.a); }
unsigned packed(Colour c, double opacity) {
  return IM_COL32(c.r, c.g, c.b, static_cast<unsigned>(std::lround(std::clamp(opacity, 0.0, 1.0) * c.a)));
}

Interface::Interface(double scale) : scale_(scale) {
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // writes no settings file
  ImGui::GetIO().LogFilename = nullptr;
  ImGui::GetIO().ConfigWindowsMoveFromTitleBarOnly = true;
  addFont(scale);
  ImGui_ImplOpenGL3_Init("#version 330");
  setTheme(ThemeKind::Dark);
}

Interface::~Interface() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext();
}

void Interface::setTheme(ThemeKind kind) {
  theme_ = kind;
  const Theme theme = themeOf(kind);
  ImGui::GetStyle() = ImGuiStyle();
  kind == ThemeKind::Dark ? ImGui::StyleColorsDark() : ImGui::StyleColorsLight();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = style.FrameRounding = style.GrabRounding = style.ChildRounding = style.PopupRounding = 4;
  style.WindowBorderSize = 1;
  style.FrameBorderSize = 0;
  style.WindowPadding = {10, 8};
  style.ItemSpacing = {7, 4};
  style.Colors[ImGuiCol_Text] = floats(theme.text);
  style.Colors[ImGuiCol_TextDisabled] = floats(theme.faint);
  style.Colors[ImGuiCol_WindowBg] = style.Colors[ImGuiCol_PopupBg] = floats(theme.panel);
  style.Colors[ImGuiCol_Border] = style.Colors[ImGuiCol_Separator] = floats(theme.line);
  style.Colors[ImGuiCol_FrameBg] = floats(theme.line, 0.45);
  style.Colors[ImGuiCol_FrameBgHovered] = floats(theme.line, 0.75);
  style.Colors[ImGuiCol_FrameBgActive] = floats(theme.line, 0.95);
  style.Colors[ImGuiCol_CheckMark] = style.Colors[ImGuiCol_SliderGrab] = floats(theme.spring);
  style.Colors[ImGuiCol_SliderGrabActive] = floats(theme.spring);
  style.Colors[ImGuiCol_Button] = floats(theme.line, 0.6);
  style.Colors[ImGuiCol_ButtonHovered] = floats(theme.spring, 0.5);
  style.Colors[ImGuiCol_ButtonActive] = floats(theme.spring, 0.8);
  style.Colors[ImGuiCol_Header] = floats(theme.line, 0.6);
  style.Colors[ImGuiCol_HeaderHovered] = floats(theme.line, 0.9);
  style.ScaleAllSizes(static_cast<float>(scale_));
}

void Interface::begin(int width, int height, double seconds) {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(width), static_cast<float>(height)};
  io.DisplayFramebufferScale = {1, 1};
  io.DeltaTime = static_cast<float>(std::max(seconds, 1e-4));
  begin();
}

void Interface::begin() {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
}

void Interface::end() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace spheretree::view
