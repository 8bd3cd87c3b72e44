// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/model/robot_shapes.h"

#include <fnmatch.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdio>
#include <set>
#include <stdexcept>

#include "program_end.h"
#include "spheretree/core/mesh_edit.h"
#include "spheretree/formats/errors.h"

namespace spheretree::robot {
namespace {

constexpr double kLargestLink = 5000;   // beyond it, a link is doubted [mm]
constexpr double kLargestRatio = 1000;  // of a link and its largest neighbour; beyond it, the link is doubted
constexpr double kUsualLink = 300;      // size of a link whose neighbours are doubtful, too [mm]
constexpr double kLikelyRatio = 10;     // of a link in another unit and what is usual; below it, the unit is proposed
constexpr std::pair<const char*, double> kUnits[] = {{"mm", 1}, {"cm", 10}, {"m", 1000}, {"in", 25.4}};

std::string metres(double mm) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.3g m", mm / 1000);
  return text.data();
}

/// Reads the shapes of one robot.
class ShapeReader {
 public:
  ShapeReader(Robot& robot, const std::vector<LinkUnit>& units, const builder::Progress& progress)
      : robot_(robot), units_(units), progress_(progress) {}

  std::vector<ShapedElement> read() {
    for (std::size_t l = 0; l < robot_.links.size(); ++l) readLink(l);
    for (const LinkUnit& unit : units_)
      if (!used_.contains(&unit))
        throw tool::UsageError("--unit " + unit.pattern + " names no link with a mesh file, or only links that an earlier pattern names.");
    if (out_.empty()) refuseNothing();
    doubtSizes();
    return std::move(out_);
  }

 private:
  double unitOf(std::size_t link) {
    for (const LinkUnit& unit : units_)
      if (fnmatch(unit.pattern.c_str(), robot_.links[link].name.c_str(), 0) == 0) {
        used_.insert(&unit);
        return unit.unit_mm;
      }
    return 1000;
  }

  void readLink(std::size_t l) {
    Link& link = robot_.links[l];
    const std::size_t all = link.collisions.size();
    std::erase_if(link.collisions, [&](const CollisionElement& element) {
      progress_.check();
      LinkShape shape = shapeIn(element, l);
      if (!shape.hasSurface()) return true;
      const auto* file = std::get_if<MeshFile>(&element.shape);
      out_.push_back({l,
                      !element.name.empty() ? element.name
                      : file                ? file->path.filename().string()
                                            : "",
                      element.place, std::move(shape)});
      return false;
    });
    if (all > 0 && link.collisions.empty()) robot_.notes.push_back(link.place + " is left without any shape, and has no spheres.");
  }

  /// Without surface for a mesh file without a triangle.
  LinkShape shapeIn(const CollisionElement& element, std::size_t link) {
    const bool is_mesh = std::holds_alternative<MeshFile>(element.shape);
    std::string why = std::holds_alternative<NoShape>(element.shape) ? "names no shape" : "is a shape of size 0";
    LinkShape shape;
    try {
      shape = shapeOf(element, is_mesh ? unitOf(link) : 1000);
      if (const auto* file = std::get_if<MeshFile>(&element.shape); file)
        why = file->path.empty() ? "names no file" : file->path.string() + " has no area";
    } catch (const formats::NoTriangleError&) {
      why = std::get<MeshFile>(element.shape).path.string() + " has no triangle";
    } catch (const formats::FormatError& error) {
      throw formats::FormatError(element.place + ": " + error.what());
    } catch (const formats::FileError& error) {
      throw formats::FileError(element.place + ": " + error.what());
    }
    if (!shape.hasSurface()) robot_.notes.push_back(element.place + ": " + why + ". It is left out.");
    return shape;
  }

  [[noreturn]] void refuseNothing() const {
    const std::string wanted = robot_.source == ShapeSource::Visual ? "<visual>" : "<collision>";
    std::string why = robot_.path.string() + ": no link has a " + wanted + " with a surface, so that there is nothing to cover.";
    if (robot_.links_with_other_shapes > 0)
      why += robot_.source == ShapeSource::Visual ? " Without --visual, the shapes of <collision> are taken."
                                                  : " --visual takes the shapes of <visual>.";
    throw formats::FormatError(why);
  }

  /// Diagonals of the boxes around the shapes of each link [mm]; 0 without a shape.
  std::vector<double> sizes() const {
    std::vector<Eigen::AlignedBox3d> boxes(robot_.links.size());
    for (const ShapedElement& element : out_) {
      Eigen::AlignedBox3d& box = boxes[element.link];
      for (const Eigen::Vector3d& p : element.shape.mesh.positions) box.extend(p);
      if (const auto& capsule = element.shape.capsule)
        for (const double r : {-capsule->radius, capsule->radius})
          box.extend((capsule->a.array() + r).matrix()).extend((capsule->b.array() + r).matrix());
    }
    std::vector<double> out;
    for (const Eigen::AlignedBox3d& box : boxes) out.push_back(box.isEmpty() ? 0 : box.diagonal().norm());
    return out;
  }

  void doubtSizes() {
    const std::vector<double> size = sizes();
    std::vector<double> beside(size.size(), 0);  // the largest of the next links with shapes, up and down
    for (std::size_t l = 0; l < size.size(); ++l) {
      std::size_t above = l;
      do above = robot_.parent_joint[above] ? robot_.joints[*robot_.parent_joint[above]].parent : size.size();
      while (above < size.size() && size[above] == 0);
      if (size[l] == 0 || above == size.size()) continue;
      beside[l] = std::max(beside[l], size[above]);
      beside[above] = std::max(beside[above], size[l]);
    }
    for (std::size_t l = 0; l < size.size(); ++l)
      if (size[l] > kLargestLink || (beside[l] > 0 && size[l] > kLargestRatio * beside[l])) doubt(l, size[l], beside[l]);
  }

  void doubt(std::size_t l, double size, double beside) {
    const double usual = beside > 0 && beside <= kLargestLink ? beside : kUsualLink;
    std::string proposals;
    for (const auto& [name, unit] : kUnits) {
      const double other = size * unit / unitOf(l);
      if (other < kLikelyRatio * usual && usual < kLikelyRatio * other)
        proposals +=
            (proposals.empty() ? "" : ", ") + std::string("--unit ") + robot_.links[l].name + "=" + name + " makes it " + metres(other);
    }
    const auto& elements = robot_.links[l].collisions;
    if (std::none_of(elements.begin(), elements.end(), [](const CollisionElement& e) { return std::holds_alternative<MeshFile>(e.shape); }))
      proposals.clear();
    robot_.notes.push_back(robot_.links[l].place + " has a size of " + metres(size) +
                           (beside > 0 ? ", beside links of at most " + metres(beside) : std::string()) +
                           (proposals.empty() ? "; check the sizes and scales of its shapes."
                                              : "; if the numbers in its mesh files are not metres, " + proposals + "."));
  }

  Robot& robot_;
  const std::vector<LinkUnit>& units_;
  const builder::Progress& progress_;
  std::vector<ShapedElement> out_;
  std::set<const LinkUnit*> used_;
};

}  // namespace

std::optional<LinkUnit> linkUnit(const std::string& text) {
  const std::size_t at = text.rfind('=');
  if (at == 0) return std::nullopt;
  LinkUnit out{at == std::string::npos ? "*" : text.substr(0, at), 0};
  for (const auto& [name, unit] : kUnits)
    if (text.substr(at == std::string::npos ? 0 : at + 1) == name) out.unit_mm = unit;
  return out.unit_mm > 0 ? std::optional(out) : std::nullopt;
}

std::string textOf(const LinkUnit& unit) {
  for (const auto& [name, unit_mm] : kUnits)
    if (unit_mm == unit.unit_mm) return unit.pattern + "=" + name;
  throw std::invalid_argument("no unit has " + std::to_string(unit.unit_mm) + " mm");
}

std::vector<ShapedElement> readShapes(Robot& robot, const std::vector<LinkUnit>& units, const builder::Progress& progress) {
  robot.units = units;
  return ShapeReader(robot, units, progress).read();
}

std::vector<std::span<const ShapedElement>> linksOf(std::span<const ShapedElement> shapes) {
  std::vector<std::span<const ShapedElement>> out;
  for (std::size_t first = 0, last = 0; first < shapes.size(); first = last) {
    while (last < shapes.size() && shapes[last].link == shapes[first].link) ++last;
    out.push_back(shapes.subspan(first, last - first));
  }
  return out;
}

TriangleMesh meshOf(std::span<const ShapedElement> elements) {
  TriangleMesh all;
  for (const ShapedElement& element : elements)
    all = joined(std::move(all), element.shape.capsule ? capsuleMesh(*element.shape.capsule) : element.shape.mesh);
  return all;
}

}  // namespace spheretree::robot
