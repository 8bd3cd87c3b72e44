// SPDX-License-Identifier: GPL-3.0-or-later
// VAMP, foam, ballpark, MorphIt, and the list of all files.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "json_text.h"
#include "robot/files/robot_files.h"
#include "robot/text/yaml_text.h"

#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::robot {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kBallpark = ".ballpark.json";  // what follows the name of the robot

/// The double that prints as the shortest decimal of the float.
double shortNumber(float value) {
  const std::string text = decimal(value);
  double out = 0;
  std::from_chars(text.data(), text.data() + text.size(), out);
  return out;
}

Json centre(const MetreSphere& s) { return {shortNumber(s.x), shortNumber(s.y), shortNumber(s.z)}; }

std::string text(const Json& json) { return tool::jsonText(json, 2) + "\n"; }

/// A name that is safe as a file name.
std::string fileName(const std::string& name) {
  std::string out = name;
  for (char& c : out)
    if (c == '/' || c == '\\' || static_cast<unsigned char>(c) < 0x20) c = '_';
  return out.starts_with('.') ? "_" + out : out;
}

}  // namespace

std::string vampJson(const CoveredRobot& c, const std::string& urdf, const std::string& srdf) {
  std::string last = c.robot.links[c.robot.root].name;  // the last link of the file without a child: usually the tool
  for (std::size_t l = 0; l < c.robot.links.size(); ++l) {
    bool has_child = false;
    for (const Joint& joint : c.robot.joints) has_child = has_child || joint.parent == l;
    if (!has_child) last = c.robot.links[l].name;
  }
  return text({{"name", c.robot.name},
               {"urdf", urdf},
               {"srdf", srdf},
               {"end_effector", last},
               {"resolution", 32},
               {"template", "templates/fk_template.hh"},
               {"subtemplates", Json::array({{{"name", "ccfk"}, {"template", "templates/ccfk_template.hh"}}})},
               {"output", fileName(c.robot.name) + "_fk.hh"}});
}

std::string foamJson(const LinkCover& link) {
  Json out = Json::array();
  for (std::size_t depth = 0; depth < link.levels.size(); ++depth) {
    Json spheres = Json::array();
    for (const MetreSphere& s : link.levels[depth]) spheres.push_back({{"origin", centre(s)}, {"radius", shortNumber(s.radius)}});
    const double bound = link.overhang_bounds_mm[depth] / 1000;  // proven; no sphere has a larger error
    out.push_back({{"mean", bound}, {"best", bound}, {"worst", bound}, {"spheres", spheres}});
  }
  return text(out);
}

std::string ballparkJson(const CoveredRobot& c) {
  Json out = Json::object();
  for (const LinkCover& link : c.cover.links) {
    Json& of_link = out[c.robot.links[link.link].name] = {{"centers", Json::array()}, {"radii", Json::array()}};
    for (const MetreSphere& s : link.spheres()) {
      of_link["centers"].push_back(centre(s));
      of_link["radii"].push_back(shortNumber(s.radius));
    }
  }
  return text(out);
}

std::string morphitJson(const Robot& robot, const LinkCover& link) {
  constexpr double kDensity = 1000;  // MorphIt's own default [kg/m^3]
  Json centres = Json::array(), radii = Json::array(), masses = Json::array();
  for (const MetreSphere& s : link.spheres()) {
    centres.push_back(centre(s));
    radii.push_back(shortNumber(s.radius));
    masses.push_back(kDensity * 4 / 3 * M_PI * std::pow(shortNumber(s.radius), 3));
  }
  const CollisionElement& first = robot.links[link.link].collisions.front();
  const auto* file = std::get_if<MeshFile>(&first.shape);
  return text({{"centers", centres},
               {"radii", radii},
               {"masses", masses},
               {"mesh_path", file ? Json(file->name) : Json(nullptr)},
               {"num_spheres", link.spheres().size()},
               {"per_sphere_mass", false},
               {"config", {{"model", {{"num_spheres", link.spheres().size()}, {"density", kDensity}}}}}});
}

std::string manifestJson(const CoveredRobot& covered, const std::filesystem::path& folder) {
  const Robot& robot = covered.robot;
  const auto fromFolder = [&](const std::filesystem::path& path) { return std::filesystem::relative(path, folder).generic_string(); };
  Json packages = Json::array(), units = packages, links = packages;
  for (const std::filesystem::path& path : robot.packages.folders) packages.push_back(fromFolder(path));
  for (const auto& [name, path] : robot.packages.named) packages.push_back(name + "=" + fromFolder(path));
  for (const LinkUnit& unit : robot.units) units.push_back(textOf(unit));
  for (const LinkCover& link : covered.cover.links)
    links.push_back({{"link", robot.links[link.link].name},
                     {"spheres", link.spheres().size()},
                     {"overhang_bound_mm", link.overhangBound()},
                     {"clipped", link.is_clipped}});
  const auto pairs = [&](PairReason reason) {
    return std::count_if(covered.pairs.begin(), covered.pairs.end(), [&](const IgnoredPair& pair) { return pair.reason == reason; });
  };
  return text({{"schema", kManifestSchema},
               {"robot", robot.name},
               {"urdf", fromFolder(robot.path)},
               {"packages", packages},
               {"units", units},
               {"visual", robot.source == ShapeSource::Visual},
               {"spheres", fileName(robot.name) + kBallpark},
               {"links", links},
               {"ignored_pairs",
                {{"adjacent", pairs(PairReason::Adjacent)}, {"always", pairs(PairReason::Always)}, {"never", pairs(PairReason::Never)}}}});
}

std::vector<std::filesystem::path> robotFileNames(const Robot& robot) {
  const std::string name = fileName(robot.name);
  std::vector<std::filesystem::path> out{kManifestName};
  for (const char* ending : {".curobo.yml", ".xrdf", ".urdf", ".srdf", ".vamp.json", kBallpark, ".mjcf.xml"})
    out.emplace_back(name + ending);
  for (const Link& link : robot.links) {
    if (link.collisions.empty()) continue;
    for (const char* format : {"foam", "morphit"}) out.push_back(std::filesystem::path(format) / (fileName(link.name) + ".json"));
  }
  return out;
}

RobotFiles robotFiles(const CoveredRobot& c, const std::filesystem::path& folder) {
  const std::string name = fileName(c.robot.name);
  RobotFiles out;
  try {
    out.contents = {manifestJson(c, folder), curoboYaml(c), xrdf(c)};
  } catch (const YAML::Exception& error) {  // a list where a map should be, and the like
    throw formats::FormatError(formats::shownName(c.merge) + ": has another structure than XRDF and the configuration of cuRobo (line " +
                               std::to_string(error.mark.line + 1) + "). Compare it with a file that this program writes without --merge.");
  }
  for (std::string& content : std::vector{sphereUrdf(c, folder), srdf(c, out.notes), vampJson(c, name + ".urdf", name + ".srdf"),
                                          ballparkJson(c), mjcf(c, out.notes)})
    out.contents.push_back(std::move(content));
  for (const LinkCover& link : c.cover.links) {
    out.contents.push_back(foamJson(link));
    out.contents.push_back(morphitJson(c.robot, link));
  }
  return out;
}

void makeRobotFolders(const std::filesystem::path& folder, const tool::RunFiles& files) {
  for (const std::filesystem::path& place : {folder, folder / "foam", folder / "morphit"}) files.makeFolder(place);
}

std::vector<std::filesystem::path> writeRobotFiles(const CoveredRobot& covered, const std::filesystem::path& folder) {
  const std::vector<std::filesystem::path> names = robotFileNames(covered.robot);
  const std::vector<std::string> contents = robotFiles(covered, folder).contents;
  const tool::RunFiles files;
  makeRobotFolders(folder, files);
  for (std::size_t i = 0; i < names.size(); ++i) formats::writeWhole(folder / names[i], contents[i]);
  return names;
}

}  // namespace spheretree::robot
