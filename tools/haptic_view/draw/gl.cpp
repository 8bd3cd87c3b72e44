// SPDX-License-Identifier: GPL-3.0-or-later
#include "draw/gl.h"

namespace spheretree::view {
namespace {

GLuint compile(const Gl& gl, GLenum kind, const char* source) {
  const GLuint shader = gl.CreateShader(kind);
  gl.ShaderSource(shader, 1, &source, nullptr);
  gl.CompileShader(shader);
  GLint good = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (good) return shader;
  char log[2048] = "";
  gl.GetShaderInfoLog(shader, sizeof log, nullptr, log);
  gl.DeleteShader(shader);
  throw ViewError(std::string("the graphics driver refuses a shader: ") + log);
}

}  // namespace

Gl loadGl(void (*(*find)(const char*))()) {
  Gl gl;
#define ST_GL_LOAD(Type, Name)                                                \
  gl.Name = reinterpret_cast<Type>(find("gl" #Name));                         \
  if (!gl.Name)                                                               \
    throw ViewError("the graphics driver lacks gl" #Name                      \
                    ": OpenGL 3.3 is needed. Install a newer driver, or set " \
                    "LIBGL_ALWAYS_SOFTWARE=1");
  ST_GL_FUNCTIONS(ST_GL_LOAD)
#undef ST_GL_LOAD
  return gl;
}

std::string rendererName(const Gl& gl) {
  const GLubyte* name = gl.GetString(GL_RENDERER);
  return name ? reinterpret_cast<const char*>(name) : "";
}

bool isSoftware(const std::string& renderer) {
  return renderer.find("llvmpipe") != std::string::npos || renderer.find("softpipe") != std::string::npos;
}

ShaderProgram::ShaderProgram(const Gl& gl, const char* vertex, const char* fragment) : gl_(gl), id_(gl.CreateProgram()) {
  for (const auto& [kind, source] : {std::pair(GL_VERTEX_SHADER, vertex), std::pair(GL_FRAGMENT_SHADER, fragment)}) {
    const GLuint shader = compile(gl, static_cast<GLenum>(kind), source);
    gl.AttachShader(id_, shader);
    gl.DeleteShader(shader);  // it lives as long as the program
  }
  gl.LinkProgram(id_);
  GLint good = 0;
  gl.GetProgramiv(id_, GL_LINK_STATUS, &good);
  if (good) return;
  char log[2048] = "";
  gl.GetProgramInfoLog(id_, sizeof log, nullptr, log);
  throw ViewError(std::string("the graphics driver refuses a shader: ") + log);
}

Canvas::Canvas(const Gl& gl, int width, int height) : gl_(gl), width_(width), height_(height) {
  gl.GenFramebuffers(1, &frame_);
  gl.BindFramebuffer(GL_FRAMEBUFFER, frame_);
  gl.GenRenderbuffers(1, &colour_);
  gl.BindRenderbuffer(GL_RENDERBUFFER, colour_);
  gl.RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_);
  gl.GenRenderbuffers(1, &depth_);
  gl.BindRenderbuffer(GL_RENDERBUFFER, depth_);
  gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw ViewError("the graphics driver has no room for a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                    " pixels");
}

Canvas::~Canvas() {
  gl_.DeleteRenderbuffers(1, &colour_);
  gl_.DeleteRenderbuffers(1, &depth_);
  gl_.DeleteFramebuffers(1, &frame_);
}

}  // namespace spheretree::view
