// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/files/sphere_file.h"

#include <array>
#include <cmath>

#include "robot/text/xml_element.h"
#include "robot/text/yaml_text.h"
#include "run_files.h"
#include "spheretree/core/rounding.h"
#include "spheretree/formats/csv_table.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"

namespace spheretree::robot {
namespace {

namespace fs = std::filesystem;
using YAML::Node;

/// Reads one file.
class SphereFileReader {
 public:
  SphereFileReader(const fs::path& path, std::optional<double> unit_mm) : path_(path), is_given_(unit_mm), unit_(unit_mm.value_or(1000)) {}

  SphereFile read() {
    const std::string ending = tool::endingOf(path_);
    if (ending == ".urdf" || ending == ".srdf" || ending == ".xml" || ending == ".mjcf")
      readMarkup();
    else if (ending == ".csv")
      readTable();
    else
      readComment(), readData(readYaml(path_), false);
    std::erase_if(out_.sets, [](const SphereSet& set) { return set.balls.empty(); });
    if (out_.sets.empty())
      throw formats::FormatError(path_.string() + ": holds no sphere in a supported format (docs/robots.md lists them).");
    return std::move(out_);
  }

 private:
  [[noreturn]] void refuseAt(const Node& node, const std::string& what) const {
    throw formats::FormatError(path_.string() + ":" + std::to_string(node.Mark().line + 1) + ": " + what);
  }

  void state(std::string_view unit) {
    const bool is_known = unit == "mm" || unit == "cm" || unit == "m" || unit == "in";
    if (!is_given_ && is_known) unit_ = formats::unitInMm(unit);
  }

  /// `convert` writes the unit into the names of the columns.
  void readTable() {
    const std::vector<std::byte> bytes = formats::readFile(path_);
    formats::CsvTable table({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, path_.string());
    std::array<std::size_t, 4> column{};
    for (std::size_t k = 0; k < column.size(); ++k) {
      const std::string name = std::array{"x", "y", "z", "radius"}[k];
      std::optional<std::size_t> found = table.find(name);
      for (const char* unit : {"mm", "cm", "m", "in"}) {
        if (found) break;
        found = table.find(name + "_" + unit);
        if (found) state(unit);
      }
      column[k] = found ? *found : table.require(name, "A list of spheres has the columns x, y, z and radius.");
    }
    out_.format = "table";
    SphereSet& set = out_.sets.emplace_back();
    while (table.next())
      addBall(set, unit_ * Eigen::Vector3d(table.number(column[0]), table.number(column[1]), table.number(column[2])),
              unit_ * table.number(column[3]));
  }

  double number(const Node& node) const {
    double value = 0;
    try {
      value = node.as<double>();
    } catch (const YAML::Exception&) {
      refuseAt(node, "should be a number.");
    }
    if (!std::isfinite(value)) refuseAt(node, "should be a finite number.");
    return unit_ * value;
  }

  Eigen::Vector3d point(const Node& node) const {
    if (!node.IsSequence() || node.size() != 3) refuseAt(node, "should be a centre of three numbers.");
    return {number(node[0]), number(node[1]), number(node[2])};
  }

  void addBall(SphereSet& set, const Eigen::Vector3d& centre, double radius) {
    if (radius > 0)
      set.balls.push_back({centre, radius});
    else
      ++out_.without_volume;
  }

  static bool isSphere(const Node& node) { return node.IsMap() && (node["center"] || node["origin"]) && node["radius"]; }
  static bool isSphereList(const Node& node) { return node.IsSequence() && node.size() > 0 && isSphere(node[0]); }

  void addList(const std::string& link, const Node& list) {
    SphereSet& set = out_.sets.emplace_back();
    set.link = link;
    for (const Node& sphere : list) {
      if (!isSphere(sphere)) refuseAt(sphere, "should be a sphere: center and radius.");
      addBall(set, point(sphere["center"] ? sphere["center"] : sphere["origin"]), number(sphere["radius"]));
    }
  }

  void addColumns(const std::string& link, const Node& node) {
    const Node centres = node["centers"], radii = node["radii"];
    if (!centres.IsSequence() || !radii.IsSequence() || centres.size() != radii.size()) refuseAt(node, "needs as many centers as radii.");
    SphereSet& set = out_.sets.emplace_back();
    set.link = link;
    for (std::size_t i = 0; i < centres.size(); ++i) addBall(set, point(centres[i]), number(radii[i]));
  }

  static bool areColumns(const Node& node) { return node.IsMap() && node["centers"] && node["radii"]; }

  /// Reads a map from links to lists or columns.
  void addLinks(const Node& map) {
    for (const auto& entry : map) {
      if (areColumns(entry.second))
        addColumns(entry.first.Scalar(), entry.second);
      else if (isSphereList(entry.second))
        addList(entry.first.Scalar(), entry.second);
    }
  }

  void readCollisionSpheres(const Node& spheres, bool is_named) {
    out_.format = "cuRobo";
    if (spheres.IsScalar() && !is_named) {  // the name of another file: older versions of cuRobo
      const fs::path other = path_.parent_path() / spheres.Scalar();
      readData(readYaml(other), true);
    } else if (isSphereList(spheres)) {
      addList("", spheres);
    } else if (spheres.IsMap()) {
      addLinks(spheres);
    }
  }

  /// The comment that `convert` writes into the first line of a .yaml.
  void readComment() {
    const std::vector<std::byte> bytes = formats::readFile(path_);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    constexpr std::string_view kComment = "# unit: ";
    if (text.starts_with(kComment)) state(text.substr(kComment.size(), text.find('\n') - kComment.size()));
  }

  void readData(const Node& input, bool is_named) {
    const Node root = input;
    if (root.IsSequence()) {
      out_.format = isSphereList(root) ? "list" : "foam";
      if (isSphereList(root))
        addList("", root);
      else if (root.size() > 0 && root[root.size() - 1].IsMap() && root[root.size() - 1]["spheres"])
        addList("", root[root.size() - 1]["spheres"]);
      return;
    }
    if (!root.IsMap()) return;
    if (root["unit"] && root["unit"].IsScalar()) state(root["unit"].Scalar());
    if (root["robot_cfg"] && root["robot_cfg"].IsMap() && root["robot_cfg"]["kinematics"] &&
        root["robot_cfg"]["kinematics"]["collision_spheres"])
      return readCollisionSpheres(root["robot_cfg"]["kinematics"]["collision_spheres"], is_named);
    if (root["collision_spheres"]) return readCollisionSpheres(root["collision_spheres"], is_named);
    if (root["format"] && root["format"].IsScalar() && root["format"].Scalar() == "xrdf") return readXrdf(root);
    if (areColumns(root)) {
      out_.format = "MorphIt";
      return addColumns("", root);
    }
    out_.format = "links";
    addLinks(root);
  }

  void readXrdf(const Node& root) {
    out_.format = "XRDF";
    const Node geometry = root["geometry"];
    if (!geometry || !geometry.IsMap() || geometry.size() == 0) return;
    const Node collision = root["collision"];
    const std::string name = collision && collision["geometry"] ? collision["geometry"].Scalar() : geometry.begin()->first.Scalar();
    if (geometry[name] && geometry[name]["spheres"] && geometry[name]["spheres"].IsMap()) addLinks(geometry[name]["spheres"]);
  }

  void readMarkup() {
    tinyxml2::XMLDocument document;
    const XmlElement& root = readXml(path_, document, "a file of spheres");
    if (std::string(root.Name()) == "mujoco") {
      out_.format = "MJCF";
      if (const XmlElement* world = root.FirstChildElement("worldbody")) readBodies(*world);
      return;
    }
    out_.format = root.FirstChildElement("link_sphere_approximation") ? "SRDF" : "URDF";
    for (const XmlElement* e = root.FirstChildElement("link_sphere_approximation"); e;
         e = e->NextSiblingElement("link_sphere_approximation")) {
      SphereSet& set = out_.sets.emplace_back();
      set.link = requiredText(path_, *e, "link");
      for (const XmlElement* s = e->FirstChildElement("sphere"); s; s = s->NextSiblingElement("sphere"))
        addBall(set, vector(*s, "center"), unit_ * requiredNumber(path_, *s, "radius"));
    }
    for (const XmlElement* e = root.FirstChildElement("link"); e; e = e->NextSiblingElement("link")) readLink(*e);
  }

  Eigen::Vector3d vector(const XmlElement& e, const char* attribute) const {
    const std::vector<double> v = numbers(path_, e, attribute, 3);
    return v.empty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(unit_ * Eigen::Vector3d(v[0], v[1], v[2]));
  }

  void readLink(const XmlElement& link) {
    SphereSet& set = out_.sets.emplace_back();
    set.link = requiredText(path_, link, "name");
    for (const XmlElement* c = link.FirstChildElement("collision"); c; c = c->NextSiblingElement("collision")) {
      const XmlElement* geometry = c->FirstChildElement("geometry");
      const XmlElement* sphere = geometry ? geometry->FirstChildElement("sphere") : nullptr;
      if (sphere) addBall(set, unit_ / 1000 * originOf(path_, *c).translation(), unit_ * requiredNumber(path_, *sphere, "radius"));
    }
  }

  void readBodies(const XmlElement& parent) {
    for (const XmlElement* body = parent.FirstChildElement("body"); body; body = body->NextSiblingElement("body")) {
      const char* name = body->Attribute("name");
      SphereSet set{name ? name : "", {}};
      for (const XmlElement* geom = body->FirstChildElement("geom"); geom; geom = geom->NextSiblingElement("geom"))
        if (const char* type = geom->Attribute("type"); !type || std::string(type) == "sphere")
          if (geom->Attribute("size")) addBall(set, vector(*geom, "pos"), unit_ * requiredNumber(path_, *geom, "size"));
      out_.sets.push_back(std::move(set));
      readBodies(*body);
    }
  }

  const fs::path& path_;
  bool is_given_;  // the unit
  double unit_;
  SphereFile out_;
};

}  // namespace

SphereFile readSphereFile(const fs::path& path, std::optional<double> unit_mm) try {
  return SphereFileReader(path, unit_mm).read();
} catch (const YAML::Exception& error) {  // a list where a map should be, and the like
  throw formats::FormatError(path.string() + ": has another structure than the formats that docs/robots.md lists (line " +
                             std::to_string(error.mark.line + 1) + ").");
}

bool isSphereFile(const fs::path& path) {
  const std::string ending = tool::endingOf(path);
  for (const char* known : {".yml", ".yaml", ".csv", ".xrdf", ".urdf", ".srdf", ".xml", ".mjcf"})
    if (ending == known) return true;
  if (ending != ".json") return false;
  // A tree names its schema at the beginning.
  const std::vector<std::byte> bytes = formats::readFile(path);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.substr(0, 4096).find("\"spheretree.") == std::string_view::npos;
}

SphereTree levelOf(const SphereSet& set) {
  SphereTree tree;
  for (const LinkBall& ball : set.balls) {
    const Eigen::Vector3f c = roundToFloat(ball.centre);
    tree.cover.push_back({c.x(), c.y(), c.z(), roundToFloat(ball.radius)});
  }
  tree.bound_index.assign(set.balls.size(), kNone);
  tree.first_child.assign(set.balls.size(), 0);
  tree.child_count.assign(set.balls.size(), 0);
  tree.level_begin = {0, static_cast<std::uint32_t>(set.balls.size())};
  countLevels(tree);
  return tree;
}

const SphereSet& setOf(const SphereFile& file, const fs::path& path, const std::string& link) {
  if (link.empty() && file.sets.size() == 1) return file.sets.front();
  std::string known;
  for (const SphereSet& set : file.sets) {
    if (!link.empty() && set.link == link) return set;
    known += (known.empty() ? "" : ", ") + set.link;
  }
  throw formats::FormatError(path.string() +
                             (link.empty() ? ": holds the spheres of several links. Name one with --link: "
                                           : ": has no spheres of the link " + link + "; it has those of ") +
                             known + ".");
}

}  // namespace spheretree::robot
