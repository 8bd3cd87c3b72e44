/* SPDX-License-Identifier: Apache-2.0 */
/* The controls of a stand-in for libdhd, which has the functions that we call and breaks as a test asks. */
#ifndef SPHERETREE_FAKE_DHD_H
#define SPHERETREE_FAKE_DHD_H

#ifdef __cplusplus
extern "C" {
#endif

struct FakeDhdState {
  int has_wrist, unplugged, start_fails;
  double position[3], matrix[3][3]; /* vendor's frame [m] */
  unsigned buttons;
  int read_result, send_result;
  /* what was asked for */
  double force[3], torque[3], largest_force;
  long reads, sends;
  int opened, forces_on, gravity_on;
  char violations[256];
};

void fake_dhd_reset(void);
struct FakeDhdState* fake_dhd_state(void);

#ifdef __cplusplus
}
#endif
#endif
