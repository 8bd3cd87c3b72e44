/* SPDX-License-Identifier: Apache-2.0 */
/* The C interface for whole scenes (libspheretree_scene.so): scene files, soft tissue, spheres for drawing, distances.
 * The library also has all functions of runtime.h; link it in place of libspheretree_runtime.so, not beside it.
 *
 * Units, frames, errors and threads: runtime.h. */
#ifndef SPHERETREE_SCENE_H
#define SPHERETREE_SCENE_H

#include "spheretree/runtime/runtime.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The tool, in place of the index of an object. */
#define ST_TOOL ((size_t)-1)

/* Replaces everything in the scene by what a scene file holds: tool, trees and soft trees (.stree, .soft), poses,
 * friction, stiffness, bodies, coupling and limits. `path`: the scene.json that `spheretree batch` writes, or its
 * folder; UTF-8. Returns 0; or -1 with a sentence in st_scene_error(), and the scene is as before. */
ST_API int st_scene_load(st_scene* scene, const char* path);
/* Adds an object of soft tissue. `bytes`: the content of a .soft file, checked and copied. */
ST_API int st_scene_add_tissue(st_scene* scene, const void* bytes, size_t size, const st_pose* pose);

ST_API size_t st_scene_object_count(const st_scene* scene);
/* The name in the scene file; "" if there is none. Valid until the scene changes. */
ST_API const char* st_scene_object_name(const st_scene* scene, size_t object);

/* The bodies of the scene file, 1 .. st_scene_body_count(), as in st_renderer_move_body(). */
ST_API uint32_t st_scene_body_count(const st_scene* scene);
ST_API const char* st_scene_body_name(const st_scene* scene, uint32_t body); /* as st_scene_object_name() */
/* Where the scene file has the body at a time from its start, along its poses or about its hinge: the pose for
 * st_renderer_move_body(). Returns 0; or -1 if the file has no such body. Allocates nothing. */
ST_API int st_scene_body_pose(const st_scene* scene, uint32_t body, double seconds, st_pose* pose);

/* Levels of the tree of an object, or of ST_TOOL; 0 if there is none. */
ST_API int st_scene_level_count(const st_scene* scene, size_t object);
/* Writes the spheres of a level of an object, or of ST_TOOL, as x, y, z and radius [mm]: 4 floats for each sphere,
 * for at most `capacity` of them. Level 0 is one sphere; -1 or the last level: the leaves. Returns the number of
 * spheres of the level; 0 if there is no such object or level. `frame`: pose that takes the spheres to the world,
 * the one of st_renderer_object_pose(), or st_step::graphic_tool for ST_TOOL. NULL: the frame of the file; for
 * ST_TOOL its axes, with the reference point as the origin. `xyzr` may be NULL if `capacity` is 0. Allocates
 * nothing. The spheres are those of the shape at rest. */
ST_API size_t st_scene_spheres(const st_scene* scene, size_t object, int level, const st_pose* frame, float* xyzr, size_t capacity);

/* Writes the current pose of an object's file frame in the world. Returns 0; or -1 if there is no such object.
 * Allocates nothing. */
ST_API int st_renderer_object_pose(const st_renderer* renderer, size_t object, st_pose* pose);

/* The distance of the tool from an object. Later versions add members at the end, as for st_step. */
typedef struct st_distance {
  size_t struct_size;        /* sizeof(st_distance) */
  double lower_mm;           /* no point of the tool's mesh is nearer to the mesh of the object; 0 or less: they may touch */
  double upper_mm;           /* two points of the solids are at most this far apart; infinite if no bound is proven */
  double tool_point_mm[3];   /* the nearest points of the tool's leaves, and of the object's skin, or leaves if it has */
  double object_point_mm[3]; /* none; world frame */
} st_distance;
#define ST_DISTANCE_INIT                              \
  {                                                   \
    sizeof(st_distance), 0, 0, {0, 0, 0}, { 0, 0, 0 } \
  }
/* The distance of the tool at `tool`, such as st_step::graphic_tool, from an object where it is now, switched on
 * or off. The object counts as it is at rest. If nothing is nearer than `limit_mm`, `lower_mm` is the limit,
 * `upper_mm` is infinite and the points are zero; a small limit makes the search short. Returns 0; or -1 if there
 * is no such object or the pose is not finite. Allocates nothing. Not while a step runs. What the bounds rest on:
 * docs/runtime.md */
ST_API int st_renderer_distance(const st_renderer* renderer, size_t object, const st_pose* tool, double limit_mm, st_distance* out);

/* Cutting, in a scene whose tool has a burr and whose objects have `cut` (docs/scene_file.md). While the spindle turns,
 * the burr removes material, and the rest of the tool is firm; at the beginning it rests. Between two steps, as all of
 * these functions; they allocate nothing. Returns 0; or -1 if the scene has nothing to cut. */
ST_API int st_renderer_set_spindle(st_renderer* renderer, int turns);
/* Writes the volume [mm^3] that was removed of each layer of the object, the outermost first, for at most `capacity`
 * layers. Returns the number of layers; 0 if the object is not cut. */
ST_API size_t st_renderer_removed(const st_renderer* renderer, size_t object, double* removed_mm3, size_t capacity);
/* The innermost layer of the object that resisted in the last step; -1: none. */
ST_API int st_renderer_cut_layer(const st_renderer* renderer, size_t object);
/* All material is whole again; a reset does not do that. */
ST_API void st_renderer_mend(st_renderer* renderer);

/* Large deformation of soft tissue. Without it, tissue gives way to small motions only, in the step itself. The solvers
 * run in a thread of yours, beside that of the steps:
 *   thread of the steps:  st_tissue_exchange(tissue); st_renderer_step(...);
 *   other thread:         if (!st_tissue_solve(tissue)) sleep for a millisecond; */
typedef struct st_tissue st_tissue;
/* For all tissue of the renderer, which must outlive it. Returns NULL if the renderer has none, or with a sentence
 * in `error`, of `size` bytes, if its solver refuses it; "" otherwise. */
ST_API st_tissue* st_tissue_create(st_renderer* renderer, char* error, size_t size);
ST_API void st_tissue_destroy(st_tissue* tissue); /* may be NULL; no other function of it may run */
/* Between two steps: takes the state that st_tissue_solve() has computed, if it is ready, and asks for the next
 * one. Allocates nothing and never waits. Returns 1 if it asked. */
ST_API int st_tissue_exchange(st_tissue* tissue);
/* Computes the state that was asked for, which takes some milliseconds. Returns 1; or 0 at once if none was. */
ST_API int st_tissue_solve(st_tissue* tissue);
/* Back to the shape at rest, with st_renderer_reset(), while no other function of it runs. */
ST_API void st_tissue_reset(st_tissue* tissue);

#ifdef __cplusplus
}
#endif
#endif
