// SPDX-License-Identifier: Apache-2.0
// read_by_mujoco FILE.xml: its spheres as MuJoCo compiles them, a line for each: body, centre, radius [m]. Then the
// numbers of joints, excluded pairs and equalities, and the mass of all [kg].
#include <mujoco/mujoco.h>

#include <cstdio>

int main(int argc, char** argv) {
  char error[1000] = "";
  mjModel* model = argc == 2 ? mj_loadXML(argv[1], nullptr, error, sizeof(error)) : nullptr;
  if (!model) {
    std::fprintf(stderr, "%s\n", error);
    return 1;
  }
  for (int g = 0; g < model->ngeom; ++g) {
    if (model->geom_type[g] != mjGEOM_SPHERE) return 2;
    const mjtNum* p = model->geom_pos + 3 * g;
    std::printf("%s %.17g %.17g %.17g %.17g\n", mj_id2name(model, mjOBJ_BODY, model->geom_bodyid[g]), p[0], p[1], p[2],
                model->geom_size[3 * g]);
  }
  double mass = 0;
  for (int b = 0; b < model->nbody; ++b) mass += model->body_mass[b];
  std::printf("%d %d %d %.17g\n", model->njnt, model->nexclude, model->neq, mass);
  mj_deleteModel(model);
  return 0;
}
