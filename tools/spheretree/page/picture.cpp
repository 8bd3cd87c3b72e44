// SPDX-License-Identifier: GPL-3.0-or-later
#include "page/picture.h"

#include <png.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "spheretree/formats/errors.h"

namespace spheretree {
namespace {

using Eigen::Vector3d;
constexpr double kLargest = 1e30;  // [mm]
constexpr int kSuper = 3;          // samples for each pixel, in each direction
constexpr float kFar = -1e30f;     // depth of an empty sample
constexpr float kGlass = 0.42f;    // share of the glass in the colour seen through it

// Screen frame: x right, y down, z towards the eye.
struct Camera {
  Vector3d right, down, towards;

  explicit Camera(const std::array<double, 3>& view) {
    towards = Vector3d(view[0], view[1], view[2]);
    const double length = towards.norm();
    if (!std::isfinite(length) || !(length > 0)) throw std::invalid_argument("The view must be three finite numbers, not all zero.");
    towards /= length;
    const Vector3d up = std::abs(towards.z()) < 0.999 ? Vector3d(0, 0, 1) : Vector3d(0, 1, 0);
    right = up.cross(towards).normalized();
    down = -towards.cross(right);
  }
  Vector3d project(const Vector3d& p) const { return {right.dot(p), down.dot(p), towards.dot(p)}; }
};

struct Extent {
  double left = std::numeric_limits<double>::max(), top = left, right = -left, bottom = -left;  // [mm]
  void add(double x, double y, double reach) {
    left = std::min(left, x - reach);
    right = std::max(right, x + reach);
    top = std::min(top, y - reach);
    bottom = std::max(bottom, y + reach);
  }
  double width() const { return right - left; }
  double height() const { return bottom - top; }
};

// The visible surface at each sample. The normal's third coordinate follows from the other two: it points to the eye.
struct Sample {
  float depth = kFar;  // towards the eye [samples]; kFar: empty
  float nx = 0, ny = 0;
  std::uint32_t colour = 0;  // index in the palette
};

struct Layer {
  int width, height;
  std::vector<Sample> sample;

  Layer(int w, int h) : width(w), height(h), sample(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  const Sample& at(int x, int y) const {
    return sample[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
  void put(int x, int y, double depth, const Vector3d& n, std::uint32_t colour) {
    Sample& old = sample[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    const auto nearer = static_cast<float>(depth);
    if (nearer > old.depth) old = {nearer, static_cast<float>(n.x()), static_cast<float>(n.y()), colour};
  }
  Eigen::Vector3f normal(int x, int y) const {
    const Sample& s = at(x, y);
    return {s.nx, s.ny, std::sqrt(std::max(0.0f, 1 - s.nx * s.nx - s.ny * s.ny))};
  }
};

// First and last sample whose centre can lie in [from, to].
std::pair<int, int> samples(double from, double to, int size) {
  return {static_cast<int>(std::clamp(std::ceil(from - 0.5), 0.0, static_cast<double>(size))),
          static_cast<int>(std::clamp(std::floor(to - 0.5), -1.0, static_cast<double>(size - 1)))};
}

void drawSphere(Layer& layer, const Vector3d& centre, double radius, std::uint32_t colour) {
  const auto [x0, x1] = samples(centre.x() - radius, centre.x() + radius, layer.width);
  const auto [y0, y1] = samples(centre.y() - radius, centre.y() + radius, layer.height);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const double dx = (x + 0.5 - centre.x()) / radius, dy = (y + 0.5 - centre.y()) / radius, inside = 1 - dx * dx - dy * dy;
      if (inside <= 0) continue;
      const double dz = std::sqrt(inside);
      layer.put(x, y, centre.z() + dz * radius, {dx, dy, dz}, colour);
    }
  }
}

void drawTriangle(Layer& layer, const std::array<Vector3d, 3>& corner, const std::array<Vector3d, 3>& normal, std::uint32_t colour) {
  const auto cross = [](const Vector3d& a, const Vector3d& b, double x, double y) {
    return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
  };
  const double area = cross(corner[0], corner[1], corner[2].x(), corner[2].y());
  if (area == 0) return;
  const auto [low_x, high_x] = std::minmax({corner[0].x(), corner[1].x(), corner[2].x()});
  const auto [low_y, high_y] = std::minmax({corner[0].y(), corner[1].y(), corner[2].y()});
  const auto [x0, x1] = samples(low_x, high_x, layer.width);
  const auto [y0, y1] = samples(low_y, high_y, layer.height);
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const double a = cross(corner[1], corner[2], x + 0.5, y + 0.5) / area, b = cross(corner[2], corner[0], x + 0.5, y + 0.5) / area;
      const double c = 1 - a - b;
      if (a < 0 || b < 0 || c < 0) continue;
      Vector3d n = a * normal[0] + b * normal[1] + c * normal[2];
      if (n.z() < 0) n.z() = -n.z();  // an edge seen from the side
      layer.put(x, y, a * corner[0].z() + b * corner[1].z() + c * corner[2].z(), n / std::max(n.norm(), 1e-12), colour);
    }
  }
}

// Draws with normals smoothed over corners whose faces meet at less than 60 degrees; sharper edges stay sharp.
void drawMesh(Layer& layer, const TriangleMesh& mesh, const std::vector<Vector3d>& screen, std::uint32_t colour) {
  std::vector<Vector3d> face(mesh.triangles.size());
  std::vector<std::vector<std::uint32_t>> around(mesh.positions.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& v = mesh.triangles[t];
    // The screen's y points down, which mirrors the frame: with the swapped factors, a normal that faces the eye has z
    // > 0.
    face[t] = (screen[v[2]] - screen[v[0]]).cross(screen[v[1]] - screen[v[0]]);
    for (const std::uint32_t corner : v) around[corner].push_back(static_cast<std::uint32_t>(t));
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (face[t].z() <= 0) continue;
    std::array<Vector3d, 3> corner, normal;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh.triangles[t][k];
      corner[k] = screen[v];
      normal[k] = Vector3d::Zero();
      for (const std::uint32_t other : around[v]) {
        if (face[other].dot(face[t]) > 0.5 * face[other].norm() * face[t].norm()) normal[k] += face[other];
      }
      normal[k] /= std::max(normal[k].norm(), 1e-12);
    }
    drawTriangle(layer, corner, normal, colour);
  }
}

// Share of a disc around the sample, at three radii, from which light reaches it. The pattern rotates from pixel to
// pixel, and the mean over the samples of a pixel hides it.
double openness(const Layer& layer, int x, int y, double reach) {
  static constexpr std::array<std::array<double, 2>, 12> kDisc{{{0.26, 0.10},
                                                                {-0.17, 0.22},
                                                                {-0.20, -0.19},
                                                                {0.11, -0.25},
                                                                {0.44, 0.42},
                                                                {-0.46, 0.40},
                                                                {-0.38, -0.47},
                                                                {0.47, -0.39},
                                                                {0.98, 0.05},
                                                                {-0.06, 0.99},
                                                                {-0.97, -0.08},
                                                                {0.09, -0.96}}};
  const double depth = static_cast<double>(layer.at(x, y).depth);
  const Vector3d n = layer.normal(x, y).cast<double>();
  const int turn = (x % kSuper) * kSuper + y % kSuper;
  const double c = 1 - turn * turn / 81.0, s = std::sqrt(1 - c * c);
  double blocked = 0;
  for (const auto& [u, v] : kDisc) {
    const double du = reach * (c * u - s * v), dv = reach * (s * u + c * v);
    const int ix = x + static_cast<int>(du), iy = y + static_cast<int>(dv);
    if (ix < 0 || iy < 0 || ix >= layer.width || iy >= layer.height) continue;
    if (layer.at(ix, iy).depth == kFar) continue;
    const double other = static_cast<double>(layer.at(ix, iy).depth);
    // Height of the neighbour over the tangent plane, relative to its distance; surfaces far in front cast no contact
    // shadow.
    const double rise =
        (ix - x) * static_cast<double>(n.x()) + (iy - y) * static_cast<double>(n.y()) + (other - depth) * static_cast<double>(n.z());
    const double away =
        std::sqrt(static_cast<double>((ix - x) * (ix - x) + (iy - y) * (iy - y)) + (other - depth) * (other - depth)) + 1e-9;
    const double fade = std::clamp(2 - (other - depth) / reach, 0.0, 1.0);
    blocked += fade * std::clamp(rise / away - 0.05, 0.0, 1.0);
  }
  return 1 - std::min(1.0, blocked / 6.0);
}

Eigen::Vector3f shade(const Layer& layer, const std::vector<Eigen::Vector3f>& palette, int x, int y, double reach, bool shiny) {
  static const Eigen::Vector3f kKey = Eigen::Vector3f(-0.45f, -0.65f, 0.75f).normalized();  // light from the upper left, in front
  static const Eigen::Vector3f kFill = Eigen::Vector3f(0.8f, 0.1f, 0.45f).normalized();
  const Eigen::Vector3f n = layer.normal(x, y);
  const auto open = static_cast<float>(openness(layer, x, y, reach));
  const float key = std::max(0.0f, n.dot(kKey)), fill = std::max(0.0f, n.dot(kFill)), sky = 0.5f - 0.5f * n.y();
  const float light = open * (0.30f + 0.22f * sky) + (0.35f + 0.65f * open) * (0.55f * key + 0.14f * fill);
  Eigen::Vector3f colour = palette[layer.at(x, y).colour] * light;
  if (shiny) {
    const float half = std::max(0.0f, n.dot(Eigen::Vector3f(kKey + Eigen::Vector3f(0, 0, 1)).normalized()));
    const float h2 = half * half, h8 = h2 * h2 * h2 * h2, h32 = h8 * h8 * h8 * h8;
    colour += Eigen::Vector3f::Constant(0.16f * h32 * open);
  }
  return colour.cwiseMin(1.0f);
}

// Linear light. Eight hues, also different in brightness, for the children of the root, in five shades each; then the
// mesh and the root.
constexpr std::uint32_t kHueCount = 8, kToneCount = 5, kMeshColour = kHueCount * kToneCount, kRootColour = kMeshColour + 1;

std::vector<Eigen::Vector3f> makePalette() {
  const std::array<Eigen::Vector3f, kHueCount> hues{{{0.12f, 0.36f, 0.72f},
                                                     {0.86f, 0.30f, 0.10f},
                                                     {0.16f, 0.55f, 0.30f},
                                                     {0.90f, 0.62f, 0.10f},
                                                     {0.50f, 0.20f, 0.58f},
                                                     {0.12f, 0.60f, 0.66f},
                                                     {0.80f, 0.22f, 0.32f},
                                                     {0.52f, 0.62f, 0.14f}}};
  std::vector<Eigen::Vector3f> palette;
  for (const Eigen::Vector3f& hue : hues) {
    for (std::uint32_t tone = 0; tone < kToneCount; ++tone) palette.push_back((0.82f + 0.09f * static_cast<float>(tone)) * hue);
  }
  palette.push_back({0.90f, 0.83f, 0.70f});
  palette.push_back({0.45f, 0.62f, 0.82f});
  return palette;
}

std::uint32_t sphereColour(std::uint32_t family, std::uint32_t member) {
  return family % kHueCount * kToneCount + (2 * member + member / 8) % kToneCount;
}

/// One level, or the mesh, projected onto the screen [mm].
struct Panel {
  struct Ball {
    Vector3d centre;
    double radius;
    std::uint32_t colour;
  };
  std::vector<Ball> balls;
  bool mesh = false;
  Extent extent;
};

struct Image {
  int width, height;
  std::vector<std::uint8_t> rgb;
};

// Colour of one sample: the spheres, the mesh, or the mesh behind glass.
Eigen::Vector3f seenAt(const Layer& spheres, const Layer& solid, const std::vector<Eigen::Vector3f>& palette, int x, int y, double reach) {
  const bool with_mesh = !solid.sample.empty();
  Eigen::Vector3f seen = Eigen::Vector3f::Ones();
  if (with_mesh && solid.at(x, y).depth != kFar) seen = shade(solid, palette, x, y, reach, false);
  if (spheres.at(x, y).depth == kFar) return seen;
  const Eigen::Vector3f front = shade(spheres, palette, x, y, reach, true);
  if (!with_mesh) return front;
  const float rim = 1 - spheres.normal(x, y).z();  // glass is denser towards its rim
  const float share = kGlass * (0.55f + 0.9f * rim);
  return share * front + (1 - share) * seen;
}

// Averages the samples of each pixel into the image, from column `left` on, with gamma 2.
void resolve(Image& image, int left, const Layer& spheres, const Layer& solid, const std::vector<Eigen::Vector3f>& palette, double reach) {
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < spheres.width / kSuper && left + x < image.width; ++x) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int sub = 0; sub < kSuper * kSuper; ++sub) {
        sum += seenAt(spheres, solid, palette, x * kSuper + sub % kSuper, y * kSuper + sub / kSuper, reach);
      }
      const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(left + x);
      for (std::size_t c = 0; c < 3; ++c) {
        const float mean = std::clamp(sum[static_cast<int>(c)] / (kSuper * kSuper), 0.0f, 1.0f);
        image.rgb[pixel * 3 + c] = static_cast<std::uint8_t>(std::lround(255 * std::sqrt(mean)));
      }
    }
  }
}

std::vector<std::byte> encodePng(const Image& pixels) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(pixels.width);
  image.height = static_cast<png_uint_32>(pixels.height);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  if (!png_image_write_to_memory(&image, nullptr, &size, 0, pixels.rgb.data(), 0, nullptr)) {
    throw std::runtime_error(std::string("The picture cannot be encoded: ") + image.message);
  }
  std::vector<std::byte> bytes(size);
  if (!png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.rgb.data(), 0, nullptr)) {
    throw std::runtime_error(std::string("The picture cannot be encoded: ") + image.message);
  }
  bytes.resize(size);
  return bytes;
}

/// A panel for the mesh, if there is one, and one for each level.
std::vector<Panel> panelsOf(const std::vector<Vector3d>& mesh_points, const SphereTree& tree, SphereKind kind, int max_levels,
                            const Camera& camera) {
  // The child of the root from which each node descends.
  std::vector<std::uint32_t> family(tree.nodeCount(), 0);
  for (std::size_t node = 0; node < tree.nodeCount(); ++node) {
    for (std::uint32_t k = 0; k < tree.child_count[node]; ++k) family[tree.first_child[node] + k] = node == 0 ? k : family[node];
  }
  std::vector<Panel> panels;
  if (!mesh_points.empty()) {
    Panel& panel = panels.emplace_back();
    panel.mesh = true;
    for (const Vector3d& p : mesh_points) panel.extent.add(p.x(), p.y(), 0);
  }
  const Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  for (int level = 0; level < std::min(max_levels, tree.levelCount()); ++level) {
    Panel& panel = panels.emplace_back();
    panel.mesh = !mesh_points.empty() && level == 0;
    for (const std::uint32_t node : levelSet(tree, level)) {
      const Sphere& s = sphereOf(tree, node, kind);
      const Vector3d centre = camera.project(origin + centreOf(s));
      const auto radius = static_cast<double>(s.radius);
      const auto member = static_cast<std::uint32_t>(panel.balls.size());
      panel.balls.push_back({centre, radius, node == 0 ? kRootColour : sphereColour(family[node], member)});
      panel.extent.add(centre.x(), centre.y(), radius);
    }
  }
  return panels;
}

}  // namespace

std::vector<std::byte> drawPicture(const TriangleMesh* mesh, const SphereTree& tree, SphereKind kind, const PictureSettings& settings) {
  if (settings.width < kMinPictureWidth || settings.width > kMaxPictureWidth) {
    throw std::invalid_argument("The width of a picture must be " + std::to_string(kMinPictureWidth) + " to " +
                                std::to_string(kMaxPictureWidth) + " pixels.");
  }
  const Camera camera(settings.view);
  std::vector<Vector3d> points;  // of the mesh
  if (mesh)
    for (const Vector3d& p : mesh->positions) points.push_back(camera.project(p));
  const std::vector<Panel> panels = panelsOf(points, tree, kind, settings.levels, camera);
  Extent all;
  double breadth = 0;
  for (const Panel& panel : panels) {
    all.add(panel.extent.left, panel.extent.top, 0);
    all.add(panel.extent.right, panel.extent.bottom, 0);
    breadth += panel.extent.width();
  }
  if (!(breadth < kLargest) || !(all.height() < kLargest))
    throw formats::FormatError("The mesh or the tree is too large to be drawn: it spans more than 1e30 mm.");
  const int half_gap = std::max(2, settings.width / 120), gap = 2 * half_gap;
  const double gaps = gap * static_cast<double>(panels.size() + 1);
  // [pixels/mm]; the height of the picture is at most its width.
  const double scale = std::min((settings.width - gaps) / breadth, (settings.width - 2.0 * gap) / all.height());
  const double to_samples = scale * kSuper, reach = 0.045 * std::min(all.height(), all.width()) * to_samples;

  Image image{settings.width, static_cast<int>(std::ceil(all.height() * scale)) + 2 * gap, {}};
  image.rgb.assign(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 3, 255);
  const std::vector<Eigen::Vector3f> palette = makePalette();
  const double depth =
      camera.project({tree.cover[0].x + tree.origin_mm[0], tree.cover[0].y + tree.origin_mm[1], tree.cover[0].z + tree.origin_mm[2]}).z();
  double left = (settings.width - breadth * scale - gaps) / 2 + gap;
  for (const Panel& panel : panels) {
    const int width = static_cast<int>(std::ceil(panel.extent.width() * scale)) + gap;
    const Vector3d corner(panel.extent.left - half_gap / scale, all.top - gap / scale, depth);
    Layer spheres(width * kSuper, image.height * kSuper), solid(panel.mesh ? spheres.width : 0, panel.mesh ? spheres.height : 0);
    for (const Panel::Ball& ball : panel.balls)
      drawSphere(spheres, (ball.centre - corner) * to_samples, ball.radius * to_samples, ball.colour);
    if (panel.mesh) {
      std::vector<Vector3d> screen;
      for (const Vector3d& p : points) screen.push_back((p - corner) * to_samples);
      drawMesh(solid, *mesh, screen, kMeshColour);
    }
    resolve(image, static_cast<int>(left) - half_gap, spheres, solid, palette, reach);
    left += panel.extent.width() * scale + gap;
  }
  return encodePng(image);
}

}  // namespace spheretree
