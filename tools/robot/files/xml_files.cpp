// SPDX-License-Identifier: GPL-3.0-or-later
// URDF with spheres, SRDF.
#include <algorithm>
#include <set>

#include "robot/files/robot_files.h"
#include "robot/text/xml_element.h"
#include "robot/text/yaml_text.h"
#include "spheretree/formats/errors.h"

namespace spheretree::robot {
namespace {

using tinyxml2::XMLDocument;

/// Changes mesh paths relative to the URDF into paths relative to the folder of the copy.
void moveMeshPaths(XmlElement& element, const std::filesystem::path& from, const std::filesystem::path& to) {
  const char* name =
      std::string(element.Name()) == "mesh" || std::string(element.Name()) == "texture" ? element.Attribute("filename") : nullptr;
  if (name && *name && std::string(name).find("://") == std::string::npos && !std::filesystem::path(name).is_absolute())
    setText(element, "filename",
            std::filesystem::proximate(std::filesystem::absolute(from / name).lexically_normal(), std::filesystem::absolute(to)).string());
  for (XmlElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) moveMeshPaths(*child, from, to);
}

const char* reasonText(PairReason reason) {
  return reason == PairReason::Adjacent ? "Adjacent" : reason == PairReason::Never ? "Never" : "Default";
}

/// Refuses what is no SRDF, and notes the links of another robot.
void checkSrdf(const CoveredRobot& c, const XmlElement& root, std::vector<std::string>& notes) {
  if (std::string(root.Name()) != "robot") refuse(c.srdf, root, "is not an SRDF: its root element should be <robot>.");
  for (const char* part : {"link", "joint"})
    if (const XmlElement* e = root.FirstChildElement(part)) refuse(c.srdf, *e, "an SRDF has no such element here. Is this a URDF?");
  for (const XmlElement* e = root.FirstChildElement("disable_collisions"); e; e = e->NextSiblingElement("disable_collisions"))
    for (const char* attribute : {"link1", "link2"}) {
      const std::string name = requiredText(c.srdf, *e, attribute);
      if (std::any_of(c.robot.links.begin(), c.robot.links.end(), [&](const Link& link) { return link.name == name; })) continue;
      notes.push_back(placeOf(c.srdf, *e) + ": the robot has no link " + name + ". Is this the SRDF of another robot?");
      return;
    }
}

}  // namespace

std::string sphereUrdf(const CoveredRobot& c, const std::filesystem::path& folder) {
  XMLDocument document;
  (void)readXml(c.robot.path, document, "a URDF");
  XmlElement& root = *document.RootElement();
  setText(root, "name", c.robot.name);  // it may have none
  moveMeshPaths(root, std::filesystem::absolute(c.robot.path).parent_path(), folder);
  std::size_t index = 0;
  for (XmlElement* link = root.FirstChildElement("link"); link; link = link->NextSiblingElement("link"), ++index) {
    while (XmlElement* collision = link->FirstChildElement("collision")) link->DeleteChild(collision);
    const LinkCover* cover = c.cover.of(index);
    if (!cover) continue;
    for (const MetreSphere& s : cover->spheres()) {
      XmlElement& collision = addElement(*link, "collision");
      XmlElement& sphere = addElement(addElement(collision, "geometry"), "sphere");
      setText(sphere, "radius", decimal(s.radius));
      XmlElement& origin = addElement(collision, "origin");
      setText(origin, "xyz", centreText(s));
      setText(origin, "rpy", "0 0 0");
    }
  }
  return xmlText(document);
}

std::string srdf(const CoveredRobot& c, std::vector<std::string>& notes) {
  XMLDocument document;
  if (c.srdf.empty()) {
    document.InsertFirstChild(document.NewDeclaration());
    setText(addElement(document, "robot"), "name", c.robot.name);
  } else {
    checkSrdf(c, readXml(c.srdf, document, "an SRDF"), notes);
  }
  XmlElement& root = *document.RootElement();
  std::set<std::pair<std::string, std::string>> known;
  for (XmlElement* e = root.FirstChildElement("disable_collisions"); e; e = e->NextSiblingElement("disable_collisions"))
    known.insert(std::minmax(requiredText(c.srdf, *e, "link1"), requiredText(c.srdf, *e, "link2")));
  for (XmlElement* e = root.FirstChildElement("link_sphere_approximation"); e;) {
    XmlElement* next = e->NextSiblingElement("link_sphere_approximation");
    root.DeleteChild(e);
    e = next;
  }
  for (const LinkCover& link : c.cover.links) {
    XmlElement& approximation = addElement(root, "link_sphere_approximation");
    setText(approximation, "link", c.robot.links[link.link].name);
    for (const MetreSphere& s : link.spheres()) {
      XmlElement& sphere = addElement(approximation, "sphere");
      setText(sphere, "center", centreText(s));
      setText(sphere, "radius", decimal(s.radius));
    }
  }
  for (const IgnoredPair& pair : c.pairs) {
    const std::string &a = c.robot.links[pair.a].name, &b = c.robot.links[pair.b].name;
    if (known.contains(std::minmax(a, b))) continue;
    XmlElement& e = addElement(root, "disable_collisions");
    setText(e, "link1", a);
    setText(e, "link2", b);
    setText(e, "reason", reasonText(pair.reason));
  }
  return xmlText(document);
}

}  // namespace spheretree::robot
