// SPDX-License-Identifier: Apache-2.0
// A replacement of the vendor's libHD: the functions of HDAPI that we call, connected to the simulated device. It
// checks every rule of their use and produces every fault on request. A test opens it by dlopen and finds these
// functions by name.
#pragma once

#include <cstdint>

extern "C" {

/// Settings of a test, before the device is opened.
struct FakeSettings {
  bool stepped = true;                // virtual time by fake_step(); else a thread of 1 kHz
  bool null_name_fails = false;       // hdInitDevice(NULL) fails, "Default PHANToM" works
  bool unplugged = false;             // no name works
  int output_dof = 6;                 // 3: setting a torque is an error
  int calibration_style = 1;          // 1 encoder reset, 2 auto, 4 inkwell
  bool calibrated = true;             // false: needs an update
  bool calibration_fails = false;     // an update does not help
  double temperature_per_second = 0;  // rise of the motors' temperature beyond that of their load
  double matrix_error = 0;            // error of the columns of the rotation
  double coulomb = 0;                 // of the simulated device [N]
  bool has_switch = false;            // safety switch; held from the start
  bool poor = false;                  // no safety switch, temperature, clamp, ramp and serial number: asking for them is an error
  bool start_fails = false;           // hdStartScheduler leaves a timer error
  void (*path)(double time, double* position, double* quaternion) = nullptr;  // of the hand; null: it rests at the origin
};

struct FakeRecord {
  double force[3], torque[3];  // sent to the motors, Cartesian [N, N mm]
  double asked[3];             // force that was set, before clamp and ramp [N]
  double asked_torque[3];      // as set, in the convention of the call
  bool framed;                 // a frame was ended in this tick
};

void fake_reset(const FakeSettings* settings);
void fake_step(int ticks);                                               // virtual time
void fake_inject(long tick, std::uint32_t code, std::int32_t internal);  // an error at the end of that tick's frame
void fake_set(int buttons, bool held);                                   // from now on
long fake_ticks(void);
FakeRecord fake_record(long tick);  // of the last 2^16 ticks
const char* fake_violations(void);  // rules of HDAPI that were broken; empty if none
const char* fake_calls(void);       // names of calls outside the servo, in order
bool fake_running(void);

}  // extern "C"
