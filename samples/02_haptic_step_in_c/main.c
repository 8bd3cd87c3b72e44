/* SPDX-License-Identifier: Apache-2.0 */
/* Loads the runtime as a shared library at run time and presses a tool on an object: what a player in any language
 * does. Usage: haptic_step_in_c LIBRARY TOOL.stree OBJECT.stree      LIBRARY: path of libspheretree_runtime.so, on
 * Windows of spheretree_runtime.dll */
#ifdef _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#endif
#include <stdio.h>
#include <stdlib.h>

#include "spheretree/runtime/runtime.h"

static void* library;

static void stop(const char* why, int code) {
  fprintf(stderr, "%s\n", why);
  exit(code);
}
#ifdef _WIN32
static void openLibrary(const char* path) {
  if (!(library = LoadLibraryA(path))) stop("the library cannot be loaded", 3);
}
static void* function(const char* name) {
  void* found = (void*)GetProcAddress(library, name);
  if (!found) stop(name, 1);
  return found;
}
#else
static void openLibrary(const char* path) {
  if (!(library = dlopen(path, RTLD_NOW | RTLD_LOCAL))) stop(dlerror(), 3);
}
static void* function(const char* name) {
  void* found = dlsym(library, name);
  if (!found) stop(dlerror(), 1);
  return found;
}
#endif
#define USE(name) __typeof__(&name) p_##name = (__typeof__(&name))function(#name)

static void* readFile(const char* path, size_t* size) {
  FILE* file = fopen(path, "rb");
  if (!file) stop(path, 3);
  char* bytes = NULL;
  *size = 0;
  for (size_t got = 1; got > 0; *size += got) {
    if (!(bytes = realloc(bytes, *size + 65536))) stop("out of memory", 1);
    got = fread(bytes + *size, 1, 65536, file);
  }
  fclose(file);
  return bytes;
}

int main(int argc, char** argv) {
  if (argc != 4) stop("usage: haptic_step_in_c LIBRARY TOOL.stree OBJECT.stree", 2);
  openLibrary(argv[1]);
  USE(st_scene_create);
  USE(st_scene_set_tool);
  USE(st_scene_add_object);
  USE(st_scene_error);
  USE(st_scene_destroy);
  USE(st_renderer_create);
  USE(st_renderer_step);
  USE(st_renderer_contacts);
  USE(st_renderer_destroy);
  const double reference_point[3] = {0, 0, 0};
  const st_pose object_pose = {{0, 0, 0}, {1, 0, 0, 0}};
  size_t tool_size, object_size;
  void *tool = readFile(argv[2], &tool_size), *object = readFile(argv[3], &object_size);
  st_scene* scene = p_st_scene_create();
  if (p_st_scene_set_tool(scene, tool, tool_size, reference_point)) stop(p_st_scene_error(scene), 4);
  if (p_st_scene_add_object(scene, object, object_size, &object_pose)) stop(p_st_scene_error(scene), 4);
  st_renderer* renderer = p_st_renderer_create(scene, ST_CONSTRAINED);
  if (!renderer) stop(p_st_scene_error(scene), 4);
  printf("haptic z [mm]  graphic z [mm]  force z [N]\n");
  st_pose haptic = {{0, 0, 60}, {1, 0, 0, 0}}; /* comes down from above, 0.1 mm each servo step */
  for (int tick = 0; tick < 600; ++tick, haptic.position_mm[2] -= 0.1) {
    st_step step = ST_STEP_INIT;
    p_st_renderer_step(renderer, &haptic, &step);
    if (tick % 50) continue;
    printf("%13.3f  %14.3f  %11.3f\n", haptic.position_mm[2], step.graphic_tool.position_mm[2], step.limited_wrench.force_n[2]);
    st_contact contacts[ST_MAX_CONTACTS] = {ST_CONTACT_INIT}; /* where the tool is held */
    const size_t count = p_st_renderer_contacts(renderer, contacts, ST_MAX_CONTACTS);
    for (size_t k = 0; k < count; ++k)
      printf("  contact at (%.3f, %.3f, %.3f) mm, %.3f N\n", contacts[k].point_mm[0], contacts[k].point_mm[1], contacts[k].point_mm[2],
             contacts[k].force_n);
  }
  p_st_renderer_destroy(renderer);
  p_st_scene_destroy(scene);
  free(tool);
  free(object);
  return 0;
}
