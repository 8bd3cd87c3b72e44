// SPDX-License-Identifier: GPL-3.0-or-later
#include "draw/offscreen.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <png.h>

#include <algorithm>
#include <cstring>

namespace spheretree::view {
namespace {

constexpr const char* kAdvice = ". Install libegl1 and libgl1-mesa-dri: tools/setup.sh does";

/// Mesa's platform without windows; if it is missing, the system's default display.
EGLDisplay openDisplay() {
  const char* known = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  EGLDisplay display = EGL_NO_DISPLAY;
  if (known && std::strstr(known, "EGL_MESA_platform_surfaceless"))
    display = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  if (display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr)) return display;
  display = eglGetDisplay(EGL_DEFAULT_DISPLAY);
  if (display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr)) return display;
  throw ViewError(std::string("no picture can be drawn: EGL finds no graphics driver") + kAdvice);
}

template <class Value>
void flip(std::vector<Value>& values, std::size_t row, std::size_t rows) {
  for (std::size_t y = 0; y < rows / 2; ++y)
    std::swap_ranges(values.begin() + static_cast<std::ptrdiff_t>(y * row), values.begin() + static_cast<std::ptrdiff_t>((y + 1) * row),
                     values.begin() + static_cast<std::ptrdiff_t>((rows - 1 - y) * row));
}

}  // namespace

OffscreenContext::OffscreenContext() {
  display_ = openDisplay();
  const auto fail = [&](const std::string& what) {
    eglTerminate(display_);
    throw ViewError("no picture can be drawn: " + what + kAdvice);
  };
  if (!eglBindAPI(EGL_OPENGL_API)) fail("EGL has no OpenGL");
  // The default would require a configuration that supports windows, which this platform may not have.
  const EGLint wanted[] = {
      EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_RED_SIZE, 8, EGL_GREEN_SIZE, 8, EGL_BLUE_SIZE, 8,
      EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!eglChooseConfig(display_, wanted, &config, 1, &count) || count < 1) fail("EGL has no buffer of 8 bits a colour");
  const EGLint tiny[] = {EGL_WIDTH, 16, EGL_HEIGHT, 16, EGL_NONE};
  surface_ = eglCreatePbufferSurface(display_, config, tiny);
  const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
  context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, version);
  if (context_ == EGL_NO_CONTEXT) fail("the driver has no OpenGL 3.3");
  if (!eglMakeCurrent(display_, surface_, surface_, context_)) fail("the driver refuses its own buffer");
  gl_ = loadGl(eglGetProcAddress);
}

OffscreenContext::~OffscreenContext() {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
  if (surface_) eglDestroySurface(display_, surface_);
  eglTerminate(display_);
}

Picture readPixels(const Gl& gl, const Canvas& canvas) {
  gl.BindFramebuffer(GL_FRAMEBUFFER, canvas.id());
  return readPixels(gl, canvas.width(), canvas.height());
}

Picture readPixels(const Gl& gl, int width, int height) {
  Picture out{width, height, {}};
  out.rgb.resize(static_cast<std::size_t>(3) * static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.ReadPixels(0, 0, out.width, out.height, GL_RGB, GL_UNSIGNED_BYTE, out.rgb.data());
  flip(out.rgb, static_cast<std::size_t>(3 * out.width), static_cast<std::size_t>(out.height));
  return out;
}

std::vector<float> readDepth(const Gl& gl, const Canvas& canvas) {
  std::vector<float> out(static_cast<std::size_t>(canvas.width()) * static_cast<std::size_t>(canvas.height()));
  gl.BindFramebuffer(GL_FRAMEBUFFER, canvas.id());
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.ReadPixels(0, 0, canvas.width(), canvas.height(), GL_DEPTH_COMPONENT, GL_FLOAT, out.data());
  flip(out, static_cast<std::size_t>(canvas.width()), static_cast<std::size_t>(canvas.height()));
  return out;
}

std::vector<std::byte> encodePng(const Picture& picture) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<std::byte> bytes(size);
  const bool good = png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.rgb.data(), 0, nullptr);
  if (!good) throw std::runtime_error(std::string("the picture cannot be written as PNG: ") + image.message);
  bytes.resize(size);
  return bytes;
}

}  // namespace spheretree::view
