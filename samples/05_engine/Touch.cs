// SPDX-License-Identifier: Apache-2.0
// What an engine in C# does: starts the servo loop, moves the hand or a body once for each picture, and reads the state.
// mcs Touch.cs && LD_LIBRARY_PATH=LIBRARIES mono Touch.exe TOOL.stree OBJECT.stree [DEVICE]
using System;
using System.IO;
using System.Runtime.InteropServices;
using System.Threading;

static class Touch {
  const string Runtime = "spheretree_runtime", Servo = "spheretree_servo";

  [StructLayout(LayoutKind.Sequential)]
  struct Pose { public double X, Y, Z, W, Qx, Qy, Qz; }
  [StructLayout(LayoutKind.Sequential)]
  struct State {
    public UIntPtr Size;
    public ulong Step;
    public double Seconds;
    public Pose Haptic, Graphic;
    public double Fx, Fy, Fz, Tx, Ty, Tz;
    public uint Buttons, Faults, Contacts, Safety, Phase;
    public ulong LateSteps;
  }

  [DllImport(Runtime)] static extern IntPtr st_scene_create();
  [DllImport(Runtime)] static extern int st_scene_set_tool(IntPtr scene, byte[] bytes, UIntPtr size, double[] point);
  [DllImport(Runtime)] static extern int st_scene_add_object(IntPtr scene, byte[] bytes, UIntPtr size, ref Pose pose);
  [DllImport(Servo)] static extern IntPtr st_servo_start(IntPtr scene, string device, IntPtr options);
  [DllImport(Servo)] static extern void st_servo_stop(IntPtr servo);
  [DllImport(Servo)] static extern IntPtr st_servo_error();
  [DllImport(Servo)] static extern void st_servo_state(IntPtr servo, ref State state);
  [DllImport(Servo)] static extern int st_servo_move_hand(IntPtr servo, ref Pose tool);

  static Pose At(double z) { return new Pose { Z = z, W = 1 }; }

  static int Main(string[] files) {
    byte[] tool = File.ReadAllBytes(files[0]), thing = File.ReadAllBytes(files[1]);
    IntPtr scene = st_scene_create();
    Pose below = At(-60), hand = At(0);
    st_scene_set_tool(scene, tool, (UIntPtr)tool.Length, new double[3]);
    st_scene_add_object(scene, thing, (UIntPtr)thing.Length, ref below);
    IntPtr servo = st_servo_start(scene, files.Length > 2 ? files[2] : "simulated", IntPtr.Zero);
    if (servo == IntPtr.Zero) {
      Console.Error.WriteLine(Marshal.PtrToStringAnsi(st_servo_error()));
      return 3;
    }
    var state = new State { Size = (UIntPtr)Marshal.SizeOf(typeof(State)) };
    for (int picture = 0; picture < 900 && !(state.Contacts > 0 && state.Fz > 0.1); ++picture) {
      Thread.Sleep(16);  // an engine draws here
      st_servo_state(servo, ref state);
      bool forcesOn = state.Step > 0 && (state.Safety & (8 | 16)) == 0;  // guard and ramp are over
      if (forcesOn) hand = At(hand.Z - 0.3);  // the simulated hand comes down; a real device has a hand of its own
      st_servo_move_hand(servo, ref hand);
    }
    Console.WriteLine("contact {0}, force {1:F2} N, tool at {2:F1} mm", state.Contacts > 0, state.Fz, state.Graphic.Z);
    st_servo_stop(servo);
    return state.Contacts > 0 ? 0 : 5;
  }
}
