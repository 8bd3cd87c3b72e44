/* SPDX-License-Identifier: Apache-2.0 */
/* The C interface of the runtime (libspheretree_runtime.so): describe a scene, create a renderer from it, then call it
 * once for each servo step. spheretree/scene/scene.h adds scene files, soft tissue, spheres for drawing and distances;
 * they are in libspheretree_scene.so, which has everything that is here, too.
 *
 * Units: mm, N, N mm, rad. World axes are right-handed. Quaternions are w, x, y, z and map tool (or object) axes to
 * world axes; they need not be of unit length. A pose of the tool is the position of its reference point and its
 * orientation. A wrench acts on the hand; its torque is about the reference point of the haptic tool.
 *
 * Threads: a scene or a renderer belongs to one thread at a time. st_renderer_step() allocates nothing, takes no lock,
 * does no I/O and never fails; its time is bounded by the step limits. All other functions may allocate. */
#ifndef SPHERETREE_RUNTIME_H
#define SPHERETREE_RUNTIME_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif
#if defined(_WIN32) && defined(ST_EXPORTS) /* while the library itself is compiled */
#define ST_API __declspec(dllexport)
#elif defined(__GNUC__) && !defined(_WIN32)
#define ST_API __attribute__((visibility("default")))
#else
#define ST_API
#endif

typedef struct st_scene st_scene;
typedef struct st_renderer st_renderer;

typedef struct st_pose {
  double position_mm[3];
  double orientation_wxyz[4];
} st_pose;

typedef struct st_wrench {
  double force_n[3];
  double torque_n_mm[3];
} st_wrench;

/* Velocity of a body; the rotation is about its origin. World axes. */
typedef struct st_velocity {
  double mm_per_s[3];
  double rad_per_s[3];
} st_velocity;

/* Mode of a renderer. */
enum {
  ST_CONSTRAINED = 0, /* the graphic tool never passes through an object */
  ST_PAPER = 1        /* the published algorithm (Wang, Zhang, Zhang, Xiao, IROS 2011) */
};

/* Bits of st_step::faults. After each of them the limited wrench is safe to render. */
enum {
  ST_PAIRS_FULL = 1,    /* more pairs than max_pairs: nodes of upper levels of the trees replaced leaves */
  ST_WORK_LIMIT = 2,    /* max_work was used up: the graphic tool continues in the next step */
  ST_QP_STOPPED = 4,    /* the QP stopped early */
  ST_ROWS_CONFLICT = 8, /* no pose satisfies all contacts: the result has the smallest possible worst violation */
  ST_PENETRATING = 16,  /* the graphic tool is inside an object by more than 0.001 mm */
  ST_BAD_INPUT = 32     /* the pose was not finite or beyond 1e7 mm: the tool rests, the wrench decays by 10 % a step */
};

/* What a tool rests on in the constrained mode. */
enum {
  ST_SKIN = 0,  /* the skin of each object that has one, else its leaves */
  ST_LEAVES = 1 /* the leaf spheres of every object */
};

/* Later versions add members at the end. `struct_size` tells the library which of them the caller has: set it once,
 * with ST_STEP_INIT. */
typedef struct st_step {
  size_t struct_size; /* sizeof(st_step) */
  st_pose graphic_tool;
  st_wrench wrench;         /* of the coupling between haptic and graphic tool */
  st_wrench limited_wrench; /* `wrench` within the wrench limits: render this one, or limit `wrench` yourself */
  double penetration_mm;    /* of the graphic tool; constrained mode */
  uint32_t faults;
  uint32_t pairs;  /* in the list of the last search */
  uint32_t rows;   /* in the last QP */
  uint32_t active; /* active rows: they hold the tool */
  uint32_t qp_iterations;
  uint32_t work; /* in the unit of max_work */
} st_step;
#define ST_STEP_INIT \
  { sizeof(st_step), {{0, 0, 0}, {0, 0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}}, 0, 0, 0, 0, 0, 0, 0 }

/* A contact that holds the graphic tool. Later versions add members at the end, as for st_step. */
typedef struct st_contact {
  size_t struct_size;      /* sizeof(st_contact), of each element */
  double point_mm[3];      /* where the tool is touched, world frame */
  double normal[3];        /* from object to tool, unit length, world axes */
  double force_n;          /* along the normal, on the tool; the forces of all contacts balance the spring */
  uint32_t object;         /* index, in the order in which objects were added */
  uint32_t on_skin;        /* 1: on the skin of the object; 0: on one of its leaves */
  uint32_t element;        /* triangle of the skin, or node of the object's tree */
  uint32_t tool_leaf;      /* node of the tool's tree; if it rests with its hulls: their part */
  double friction_n[3];    /* tangential force on the tool, world axes */
  double slip_mm_per_s[3]; /* tangential velocity of the tool's point relative to the object, world axes */
} st_contact;
#define ST_CONTACT_INIT                                                             \
  {                                                                                 \
    sizeof(st_contact), {0, 0, 0}, {0, 0, 0}, 0, 0, 0, 0, 0, {0, 0, 0}, { 0, 0, 0 } \
  }
#define ST_MAX_CONTACTS 24

/* Such as "1.2.3". */
ST_API const char* st_version(void);

/* Creates an empty scene with the default limits; returns NULL if memory runs out. The functions below return 0, or -1
 * with a sentence in st_scene_error(). */
ST_API st_scene* st_scene_create(void);
ST_API void st_scene_destroy(st_scene* scene); /* `scene` may be NULL; its renderers stay valid */
/* The last error; "" if there was none. Valid until the next call with this scene. */
ST_API const char* st_scene_error(const st_scene* scene);

/* `bytes`: the content of a .stree file, checked and copied. The reference point is in the frame of the file. */
ST_API int st_scene_set_tool(st_scene* scene, const void* bytes, size_t size, const double reference_point_mm[3]);
/* `pose`: of the file's frame in the world. */
ST_API int st_scene_add_object(st_scene* scene, const void* bytes, size_t size, const st_pose* pose);
/* Adds another object of the same file as object `index`, counted from 0; the file is checked and stored only once. */
ST_API int st_scene_add_copy(st_scene* scene, size_t index, const st_pose* pose);
/* Assigns the object to a body, 1 .. 4096, which st_renderer_move_body() moves; 0, the default: the world, which does
 * not move. */
ST_API int st_scene_set_body(st_scene* scene, size_t object, uint32_t body);
/* Time from one step to the next, 1e-5 .. 1 s, default 0.001; velocities are computed with it. */
ST_API int st_scene_set_step_time(st_scene* scene, double seconds);
/* Coefficients of friction, 0 .. 2, default 0, of the tool and of an object; a contact uses the larger one. */
ST_API int st_scene_set_tool_friction(st_scene* scene, double coefficient);
ST_API int st_scene_set_friction(st_scene* scene, size_t object, double coefficient);
/* Stiffness of the object, > 0: it yields by force / stiffness; 0, the default: it is rigid. */
ST_API int st_scene_set_stiffness(st_scene* scene, size_t object, double stiffness_n_per_mm);
/* A damper in parallel with the spring of the coupling, both >= 0, default 0; not in mode ST_PAPER. */
ST_API int st_scene_set_damping(st_scene* scene, double translation_n_s_per_mm, double rotation_n_mm_s_per_rad);
/* Mass of the graphic tool at its reference point, and its inertia about it, the same for all axes; both >= 0, default
 * 0; not in mode ST_PAPER. */
ST_API int st_scene_set_mass(st_scene* scene, double mass_kg, double inertia_kg_mm2);
/* Stiffness of the coupling, both > 0; defaults 1 N/mm and 1000 N mm/rad. */
ST_API int st_scene_set_coupling(st_scene* scene, double translation_n_per_mm, double rotation_n_mm_per_rad);
/* All > 0; defaults 8 N for the magnitude of the force, 188, 188 and 48 N mm for the torque components. */
ST_API int st_scene_set_wrench_limits(st_scene* scene, double force_n, const double torque_n_mm[3]);
/* max_pairs, pairs in the list at any time: 64 for each object .. 1048576, default 8192. max_work, units of work (about
 * 8 ns each) in a step: 1000 .. 2^30, default 100000. */
ST_API int st_scene_set_step_limits(st_scene* scene, uint32_t max_pairs, uint32_t max_work);
/* ST_SKIN (default) or ST_LEAVES. */
ST_API int st_scene_set_contact(st_scene* scene, int surface);

/* Compiles the scene; later changes of the scene do not affect the renderer. On an error returns NULL, with a sentence
 * in st_scene_error(). The first step puts the graphic tool at its haptic pose. */
ST_API st_renderer* st_renderer_create(st_scene* scene, int mode);
ST_API void st_renderer_destroy(st_renderer* renderer); /* `renderer` may be NULL */
/* Computes one servo step. Writes those members of `out` that lie within out->struct_size. */
ST_API void st_renderer_step(st_renderer* renderer, const st_pose* haptic_tool, st_step* out);
/* The contacts that held the graphic tool at the end of the last step, in constrained mode. Fills up to `capacity`
 * elements of size out[0].struct_size, and returns the number of contacts, at most ST_MAX_CONTACTS. `out` may be NULL
 * if `capacity` is 0. */
ST_API size_t st_renderer_contacts(const st_renderer* renderer, st_contact* out, size_t capacity);
/* Moves a body to `pose` during the next step. `pose` is the displacement of its objects from their poses in the scene.
 * The body pushes the tool ahead and does not pass through it. In a step without a new pose it continues with
 * `velocity`; NULL: it rests. Returns 0; or -1, and changes nothing, if no object belongs to such a body or a number is
 * not finite or beyond 1e7. Allocates nothing. */
ST_API int st_renderer_move_body(st_renderer* renderer, uint32_t body, const st_pose* pose, const st_velocity* velocity);
/* Moves an object at once, as a jump. `pose` is that of its file's frame in the world. The tool does not move with it.
 * Returns 0; or -1, and changes nothing, if there is no such object or the pose is not finite or beyond 1e7 mm.
 * Allocates nothing. */
ST_API int st_renderer_move_object(st_renderer* renderer, size_t object, const st_pose* pose);
/* Switches an object off (0) or on, between two steps. An object that is off costs no work and gives no contact; it
 * still follows its body. One that is switched on where the tool is pushes the tool out; nothing passes through it from
 * the first pose of the graphic tool that is free of it. A reset changes nothing. Returns 0; or -1 if there is no such
 * object. Allocates nothing. */
ST_API int st_renderer_set_active(st_renderer* renderer, size_t object, int is_active);
/* The graphic tool restarts at `graphic_tool`, or at the next haptic pose if NULL. */
ST_API void st_renderer_reset(st_renderer* renderer, const st_pose* graphic_tool);

#ifdef __cplusplus
}
#endif
#endif
