/* SPDX-License-Identifier: Apache-2.0 */
/* The header is C: a program in C starts a servo without a scene and is told why it cannot. */
#include <string.h>

#include "spheretree/servo/servo.h"

int main(void) {
  st_servo_options options = ST_SERVO_OPTIONS_INIT;
  st_scene* scene = st_scene_create();
  st_servo* servo = st_servo_start(scene, "simulated", &options);
  const int ok = servo == NULL && strlen(st_servo_error()) > 10;
  st_scene_destroy(scene);
  return ok ? 0 : 1;
}
