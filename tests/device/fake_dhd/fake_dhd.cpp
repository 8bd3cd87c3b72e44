// SPDX-License-Identifier: Apache-2.0
#include "fake_dhd.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace {

constexpr char kId = 3;
FakeDhdState fake;

void broke(const char* rule) {
  if (std::strstr(fake.violations, rule)) return;
  std::strncat(fake.violations, rule, sizeof fake.violations - std::strlen(fake.violations) - 1);
}

void check(char id, const char* call) {
  if (id != kId || !fake.opened) broke(call);
}

}  // namespace

extern "C" {

void fake_dhd_reset(void) {
  fake = {};
  for (int k = 0; k < 3; ++k) fake.matrix[k][k] = 1;
}
FakeDhdState* fake_dhd_state(void) { return &fake; }

int dhdOpenID(char index) {
  if (fake.unplugged || index != 0) return -1;
  fake.opened = 1;
  return kId;
}
int dhdClose(char id) {
  check(id, "dhdClose of another device; ");
  if (fake.forces_on) broke("closed with forces on; ");
  fake.opened = 0;
  return 0;
}
const char* dhdErrorGetLastStr(void) { return "device not found"; }
const char* dhdGetSystemName(char id) {
  check(id, "dhdGetSystemName of another device; ");
  return fake.has_wrist ? "sigma.7" : "omega.3";
}
bool dhdHasActiveWrist(char id) {
  check(id, "dhdHasActiveWrist of another device; ");
  return fake.has_wrist != 0;
}
int dhdEnableForce(unsigned char on, char id) {
  check(id, "dhdEnableForce of another device; ");
  if (!on && std::hypot(fake.force[0], fake.force[1], fake.force[2]) > 0) broke("forces off without a zero before; ");
  if (on && fake.start_fails) return -1;
  fake.forces_on = on;
  return 0;
}
#ifndef FAKE_DHD_INCOMPLETE
int dhdSetGravityCompensation(int on, char id) {
  check(id, "dhdSetGravityCompensation of another device; ");
  fake.gravity_on = on;
  return 0;
}
#endif
int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z, double matrix[3][3], char id) {
  check(id, "dhdGetPositionAndOrientationFrame of another device; ");
  ++fake.reads;
  *x = fake.position[0];
  *y = fake.position[1];
  *z = fake.position[2];
  std::memcpy(matrix, fake.matrix, sizeof fake.matrix);
  return fake.read_result;
}
unsigned dhdGetButtonMask(char id) {
  check(id, "dhdGetButtonMask of another device; ");
  return fake.buttons;
}
int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty, double tz, double gripper, char id) {
  check(id, "dhdSetForceAndTorqueAndGripperForce of another device; ");
  const double force[3] = {fx, fy, fz}, torque[3] = {tx, ty, tz};
  std::copy_n(force, 3, fake.force);
  std::copy_n(torque, 3, fake.torque);
  const double length = std::hypot(fx, fy, fz);
  if (!(length <= fake.largest_force)) fake.largest_force = length;
  if (gripper != 0) broke("a force of the gripper; ");
  ++fake.sends;
  return fake.send_result;
}

}  // extern "C"
