// SPDX-License-Identifier: Apache-2.0
// What is behind the handles of the C interface, for the sources of both libraries that export it: c_interface.cpp, and
// scene.cpp of libspheretree_scene.
#pragma once

#include <exception>
#include <memory>
#include <string>
#include <utility>

#include "spheretree/runtime/runtime.h"
#include "spheretree/runtime/step.h"

struct st_scene {
  spheretree::runtime::SceneDescription description;
  std::string error;
  std::shared_ptr<const void> file;  // of st_scene_load()
};

struct st_renderer {
  st_renderer(spheretree::runtime::Scene&& compiled, spheretree::runtime::Mode wanted)
      : scene(std::move(compiled)), workspace(scene), mode(wanted) {}
  spheretree::runtime::Scene scene;
  spheretree::runtime::Workspace workspace;
  spheretree::runtime::Mode mode;
};

namespace spheretree::runtime {

inline Configuration fromC(const st_pose& p) {
  return {{p.position_mm[0], p.position_mm[1], p.position_mm[2]},
          Quaternion(p.orientation_wxyz[0], p.orientation_wxyz[1], p.orientation_wxyz[2], p.orientation_wxyz[3])};
}
inline st_pose toC(const Configuration& q) {
  return {{q.position.x(), q.position.y(), q.position.z()}, {q.orientation.w(), q.orientation.x(), q.orientation.y(), q.orientation.z()}};
}

/// A function that returns a fault or "". std::function, or a template of everything below, would be larger.
class Work {
 public:
  template <class Function>
  Work(const Function& function) : function_(&function), call_([](const void* f) { return (*static_cast<const Function*>(f))(); }) {}
  std::string operator()() const { return call_(function_); }

 private:
  const void* function_;
  std::string (*call_)(const void*);
};

/// Runs the work of a C function: its fault, or its exception, becomes the error of the scene. Returns 0 or -1.
int guarded(st_scene* scene, const Work& work) noexcept;
/// "WHAT: there is no object INDEX; the scene has N".
std::string noObject(const char* what, std::size_t index, const st_scene& scene);

}  // namespace spheretree::runtime
