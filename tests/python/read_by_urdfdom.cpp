// SPDX-License-Identifier: Apache-2.0
// read_by_urdfdom FILE.urdf: its spheres as ROS reads them, a line for each: link, centre, radius [m].
#include <urdf_parser/urdf_parser.h>

#include <cstdio>

int main(int argc, char** argv) {
  const urdf::ModelInterfaceSharedPtr model = argc == 2 ? urdf::parseURDFFile(argv[1]) : nullptr;
  if (!model) return 1;
  for (const auto& [name, link] : model->links_)
    for (const auto& collision : link->collision_array) {
      if (!collision || !collision->geometry || collision->geometry->type != urdf::Geometry::SPHERE) return 2;
      const urdf::Vector3& p = collision->origin.position;
      std::printf("%s %.17g %.17g %.17g %.17g\n", name.c_str(), p.x, p.y, p.z,
                  static_cast<const urdf::Sphere&>(*collision->geometry).radius);
    }
  return 0;
}
