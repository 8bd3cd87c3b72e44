/* SPDX-License-Identifier: Apache-2.0 */
/* The C interface of the servo loop (libspheretree_servo.so): opens a haptic device and renders a scene to it, at 1 kHz
 * or more, in a thread of its own. An engine starts it, moves bodies and reads the state once for each picture.
 *
 * Units, poses and wrenches are those of spheretree/runtime/runtime.h. All safety rules of the devices act: see
 * docs/device.md. Functions of one servo are called from one thread at a time; none of them waits for the servo loop,
 * except st_servo_start() and st_servo_stop(). */
#ifndef SPHERETREE_SERVO_H
#define SPHERETREE_SERVO_H

#include "spheretree/runtime/runtime.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct st_servo st_servo;

/* Later versions add members at the end; struct_size as for st_step. */
typedef struct st_servo_options {
  size_t struct_size;      /* sizeof(st_servo_options) */
  int mode;                /* ST_CONSTRAINED or ST_PAPER */
  double rate_hz;          /* servo steps in a second, 500 .. 8000 */
  double max_force_n;      /* of the vector, (0, 100]; never beyond that of the device */
  double max_torque_n_mm;  /* of each component, (0, 1000]; never beyond those of the device */
  double engine_timeout_s; /* 0.001 .. 10: without a call of st_servo_move_body() for longer, moved bodies are stale */
  st_pose device_in_world; /* where the device stands: its axes are +x right, +y up, +z to the user */
  st_pose tool_on_handle;  /* reference point and axes of the tool in the frame of the handle */
  const char* address;     /* haply: HOST:PORT of the service; NULL: 127.0.0.1:10001 */
  const char* library;     /* dhd, phantom: path of the vendor's library; NULL: where the loader looks */
  int allow_remote;        /* 1: also addresses of other machines */
  uint32_t clutch_buttons; /* bit n: while button n is held the tool stands still; 0: none */
  double carried_weight_n; /* of the handle, which the motors carry, 0 .. 5 */
} st_servo_options;
#define ST_SERVO_OPTIONS_INIT \
  { sizeof(st_servo_options), ST_CONSTRAINED, 1000, 8, 188, 0.1, {{0, 0, 0}, {1, 0, 0, 0}}, {{0, 0, 0}, {1, 0, 0, 0}}, 0, 0, 0, 0, 0 }

/* st_servo_snapshot::phase */
enum {
  ST_SERVO_RUNNING = 1,
  ST_SERVO_ENDED = 2,  /* the input of a simulated device is over */
  ST_SERVO_FAILED = 3, /* the device was lost: stop, and start again */
  ST_SERVO_HALTED = 4  /* by an emergency stop */
};

/* Bits of st_servo_snapshot::safety that an engine may want to show; docs/device.md has all of them. */
enum {
  ST_SERVO_START_GUARD = 8, /* waits until the tool is free */
  ST_SERVO_RAMP = 16,       /* forces return slowly */
  ST_SERVO_STALE = 32,      /* poses of the engine or of the device are old: forces fade */
  ST_SERVO_FORCES_OFF = 64, /* until st_servo_rearm(), or the next body that the engine moves */
  ST_SERVO_RELEASED = 128   /* a release or clutch button is held */
};

/* The state after a servo step. Later versions add members at the end. */
typedef struct st_servo_snapshot {
  size_t struct_size; /* sizeof(st_servo_snapshot) */
  uint64_t step;      /* counted from 1; 0: none yet */
  double time_s;
  st_pose haptic_tool, graphic_tool;
  st_wrench wrench; /* of the coupling, on the hand, about the haptic tool's reference point, before the safety rules */
  uint32_t buttons; /* bit n: button n is held */
  uint32_t faults;  /* of the runtime */
  uint32_t contacts;
  uint32_t safety; /* rules that acted */
  uint32_t phase;
  uint64_t late_steps; /* that began more than a period late */
} st_servo_snapshot;

/* Opens `device` (haply, dhd, phantom, net:HOST:PORT, or simulated), compiles `scene` for the rate and starts the servo
 * loop. Forces begin when the tool is free, and rise within two seconds. Later changes of the scene do not affect the
 * servo. Returns NULL on an error, with a sentence in st_servo_error(). `options` may be NULL. */
ST_API st_servo* st_servo_start(st_scene* scene, const char* device, const st_servo_options* options);
/* Sends zero, closes the device and frees `servo`, which may be NULL. */
ST_API void st_servo_stop(st_servo* servo);
/* The last error of st_servo_start() in this thread; "" if there was none. */
ST_API const char* st_servo_error(void);

/* The model of the device, such as "omega.3"; 0 for torques: it renders forces only. */
ST_API const char* st_servo_device(const st_servo* servo);
ST_API int st_servo_renders_torque(const st_servo* servo);

/* The newest state; writes those members of `out` that lie within out->struct_size. */
ST_API void st_servo_state(st_servo* servo, st_servo_snapshot* out);
/* The contacts of the last st_servo_state(), as st_renderer_contacts(). */
ST_API size_t st_servo_contacts(const st_servo* servo, st_contact* out, size_t capacity);

/* Where the engine has a body now: the displacement of its objects from their poses in the scene. The servo loop
 * moves it there over the time since the call before, so that a body of a slow engine does not jump. If the engine
 * pauses, the body stops there; after engine_timeout_s the forces fade, and they return slowly with the next call.
 * Returns 0; or -1 if a number is not finite, if 64 other bodies are moved, or if the servo loop found no such body. */
ST_API int st_servo_move_body(st_servo* servo, uint32_t body, const st_pose* pose);
/* Where the hand of a simulated device means to be; other devices have a hand of their own. Returns 0; or -1 if it is
 * another device or a number is not finite. */
ST_API int st_servo_move_hand(st_servo* servo, const st_pose* tool);
/* Lets forces return, by guard and ramp, after they were switched off. */
ST_API void st_servo_rearm(st_servo* servo);

#ifdef __cplusplus
}
#endif
#endif
