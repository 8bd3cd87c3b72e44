// SPDX-License-Identifier: GPL-3.0-or-later
// The functions of OpenGL 3.3 core that are used here, loaded at run time, so that no program is linked with OpenGL;
// and owners of objects on the graphics card. All calls must come from one thread.
#pragma once

#include <GL/glcorearb.h>

#include <cstddef>
#include <string>
#include <utility>

#include "model/view_error.h"

namespace spheretree::view {

// clang-format off
#define ST_GL_FUNCTIONS(X) \
  X(PFNGLGETSTRINGPROC, GetString) X(PFNGLGETERRORPROC, GetError) X(PFNGLGETINTEGERVPROC, GetIntegerv) \
  X(PFNGLVIEWPORTPROC, Viewport) X(PFNGLSCISSORPROC, Scissor) X(PFNGLENABLEPROC, Enable) X(PFNGLDISABLEPROC, Disable) \
  X(PFNGLCLEARCOLORPROC, ClearColor) X(PFNGLCLEARPROC, Clear) X(PFNGLDEPTHFUNCPROC, DepthFunc) X(PFNGLDEPTHMASKPROC, DepthMask) \
  X(PFNGLCOLORMASKPROC, ColorMask) X(PFNGLBLENDFUNCPROC, BlendFunc) X(PFNGLFINISHPROC, Finish) X(PFNGLPIXELSTOREIPROC, PixelStorei) \
  X(PFNGLREADPIXELSPROC, ReadPixels) X(PFNGLCREATESHADERPROC, CreateShader) X(PFNGLSHADERSOURCEPROC, ShaderSource) \
  X(PFNGLCOMPILESHADERPROC, CompileShader) X(PFNGLGETSHADERIVPROC, GetShaderiv) X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog) \
  X(PFNGLDELETESHADERPROC, DeleteShader) X(PFNGLCREATEPROGRAMPROC, CreateProgram) X(PFNGLATTACHSHADERPROC, AttachShader) \
  X(PFNGLLINKPROGRAMPROC, LinkProgram) X(PFNGLGETPROGRAMIVPROC, GetProgramiv) X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog) \
  X(PFNGLDELETEPROGRAMPROC, DeleteProgram) X(PFNGLUSEPROGRAMPROC, UseProgram) X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation) \
  X(PFNGLUNIFORM1FPROC, Uniform1f) X(PFNGLUNIFORM3FPROC, Uniform3f) X(PFNGLUNIFORM4FPROC, Uniform4f) \
  X(PFNGLUNIFORM1IPROC, Uniform1i) X(PFNGLACTIVETEXTUREPROC, ActiveTexture) X(PFNGLGENTEXTURESPROC, GenTextures) \
  X(PFNGLDELETETEXTURESPROC, DeleteTextures) X(PFNGLBINDTEXTUREPROC, BindTexture) X(PFNGLTEXPARAMETERIPROC, TexParameteri) \
  X(PFNGLTEXIMAGE3DPROC, TexImage3D) X(PFNGLTEXSUBIMAGE3DPROC, TexSubImage3D) \
  X(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv) X(PFNGLGENVERTEXARRAYSPROC, GenVertexArrays) \
  X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays) X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray) X(PFNGLGENBUFFERSPROC, GenBuffers) \
  X(PFNGLDELETEBUFFERSPROC, DeleteBuffers) X(PFNGLBINDBUFFERPROC, BindBuffer) X(PFNGLBUFFERDATAPROC, BufferData) \
  X(PFNGLENABLEVERTEXATTRIBARRAYPROC, EnableVertexAttribArray) X(PFNGLVERTEXATTRIBPOINTERPROC, VertexAttribPointer) \
  X(PFNGLVERTEXATTRIBDIVISORPROC, VertexAttribDivisor) X(PFNGLVERTEXATTRIB4NUBPROC, VertexAttrib4Nub) \
  X(PFNGLDRAWARRAYSPROC, DrawArrays) X(PFNGLDRAWELEMENTSPROC, DrawElements) X(PFNGLDRAWARRAYSINSTANCEDPROC, DrawArraysInstanced) \
  X(PFNGLGENFRAMEBUFFERSPROC, GenFramebuffers) X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers) \
  X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer) X(PFNGLFRAMEBUFFERRENDERBUFFERPROC, FramebufferRenderbuffer) \
  X(PFNGLCHECKFRAMEBUFFERSTATUSPROC, CheckFramebufferStatus) X(PFNGLBLITFRAMEBUFFERPROC, BlitFramebuffer) \
  X(PFNGLGENRENDERBUFFERSPROC, GenRenderbuffers) X(PFNGLDELETERENDERBUFFERSPROC, DeleteRenderbuffers) \
  X(PFNGLBINDRENDERBUFFERPROC, BindRenderbuffer) X(PFNGLRENDERBUFFERSTORAGEPROC, RenderbufferStorage)
// clang-format on

struct Gl {
#define ST_GL_MEMBER(Type, Name) Type Name = nullptr;
  ST_GL_FUNCTIONS(ST_GL_MEMBER)
#undef ST_GL_MEMBER
};

/// Loads the functions of the current context. `find`: glfwGetProcAddress or eglGetProcAddress. @throws ViewError if a
/// function is missing.
Gl loadGl(void (*(*find)(const char*))());

/// The name of the renderer, for example "llvmpipe (LLVM 15.0.6, 256 bits)".
std::string rendererName(const Gl& gl);
/// Whether the processor renders, instead of a graphics card.
bool isSoftware(const std::string& renderer);

/// A vertex and a fragment shader, linked. @throws ViewError with the driver's message.
class ShaderProgram {
 public:
  ShaderProgram(const Gl& gl, const char* vertex, const char* fragment);
  ~ShaderProgram() { gl_.DeleteProgram(id_); }
  ShaderProgram(const ShaderProgram&) = delete;
  ShaderProgram& operator=(const ShaderProgram&) = delete;
  void use() const { gl_.UseProgram(id_); }
  GLint uniform(const char* name) const { return gl_.GetUniformLocation(id_, name); }

 private:
  const Gl& gl_;
  GLuint id_;
};

/// A buffer of vertices, indices or instances.
class GlBuffer {
 public:
  explicit GlBuffer(const Gl& gl) : gl_(&gl) { gl.GenBuffers(1, &id_); }
  GlBuffer(GlBuffer&& other) noexcept : gl_(other.gl_), id_(std::exchange(other.id_, 0)) {}
  GlBuffer& operator=(GlBuffer&&) = delete;
  ~GlBuffer() {
    if (id_) gl_->DeleteBuffers(1, &id_);
  }
  void bind(GLenum target) const { gl_->BindBuffer(target, id_); }
  void fill(GLenum target, const void* data, std::size_t bytes, GLenum usage) const {
    bind(target);
    gl_->BufferData(target, static_cast<GLsizeiptr>(bytes), data, usage);
  }

 private:
  const Gl* gl_;
  GLuint id_ = 0;
};

class VertexArray {
 public:
  explicit VertexArray(const Gl& gl) : gl_(&gl) { gl.GenVertexArrays(1, &id_); }
  VertexArray(VertexArray&& other) noexcept : gl_(other.gl_), id_(std::exchange(other.id_, 0)) {}
  VertexArray& operator=(VertexArray&&) = delete;
  ~VertexArray() {
    if (id_) gl_->DeleteVertexArrays(1, &id_);
  }
  void bind() const { gl_->BindVertexArray(id_); }

 private:
  const Gl* gl_;
  GLuint id_ = 0;
};

/// Colour and depth buffers for drawing, independent of any window.
class Canvas {
 public:
  /// @throws ViewError if the driver cannot allocate it.
  Canvas(const Gl& gl, int width, int height);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;
  GLuint id() const { return frame_; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  const Gl& gl_;
  int width_, height_;
  GLuint frame_ = 0, colour_ = 0, depth_ = 0;
};

}  // namespace spheretree::view
