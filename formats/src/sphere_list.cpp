// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/sphere_list.h"

#include <array>
#include <charconv>
#include <nlohmann/json.hpp>
#include <vector>

#include "spheretree/formats/mesh_file.h"

namespace spheretree::formats {
namespace {

/// x, y, z, radius in the unit of the list.
std::vector<std::array<double, 4>> listedSpheres(const SphereTree& tree, const SphereListSettings& settings) {
  std::vector<std::array<double, 4>> spheres;
  const double unit_mm = unitInMm(settings.unit);
  for (const std::uint32_t node : levelSet(tree, settings.level)) {
    const Sphere& s = sphereOf(tree, node, settings.kind);
    spheres.push_back({(tree.origin_mm[0] + double{s.x}) / unit_mm, (tree.origin_mm[1] + double{s.y}) / unit_mm,
                       (tree.origin_mm[2] + double{s.z}) / unit_mm, double{s.radius} / unit_mm});
  }
  return spheres;
}

std::string decimal(double value) {
  std::array<char, 32> digits;
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
}

}  // namespace

std::string sphereListCsv(const SphereTree& tree, const SphereListSettings& settings) {
  std::string out;
  for (const char* column : {"x_", "y_", "z_", "radius_"}) out += (out.empty() ? "" : ",") + (column + settings.unit);
  out += "\n";
  for (const auto& [x, y, z, r] : listedSpheres(tree, settings))
    out.append(decimal(x)).append(",").append(decimal(y)).append(",").append(decimal(z)).append(",").append(decimal(r)).append("\n");
  return out;
}

std::string sphereListYaml(const SphereTree& tree, const SphereListSettings& settings) {
  std::string out = "# unit: " + settings.unit + "\ncollision_spheres:\n";
  for (const auto& [x, y, z, r] : listedSpheres(tree, settings))
    out.append("  - center: [")
        .append(decimal(x))
        .append(", ")
        .append(decimal(y))
        .append(", ")
        .append(decimal(z))
        .append("]\n    radius: ")
        .append(decimal(r))
        .append("\n");
  return out;
}

std::string sphereListJson(const SphereTree& tree, const SphereListSettings& settings) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const auto& [x, y, z, r] : listedSpheres(tree, settings)) list.push_back({{"origin", {x, y, z}}, {"radius", r}});
  nlohmann::ordered_json out{{"unit", settings.unit}};
  out[settings.name] = std::move(list);
  return out.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace spheretree::formats
