// SPDX-License-Identifier: Apache-2.0
// large_mesh KIND TRIANGLES FILE: writes a closed mesh of about that number of triangles, for benchmarks of builds. The
// kinds differ in what makes large meshes expensive; each is the same on every machine. See benchmarks/large_meshes.py.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "molar.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_writer.h"

namespace {

using Eigen::Vector3d;
using spheretree::Triangle;
using spheretree::TriangleMesh;

constexpr double kNoise = 0.02;  // [mm]

/// Uniform in [-1, 1): a hash of two numbers (splitmix64).
double noiseAt(std::uint64_t a, std::uint64_t b) {
  std::uint64_t x = a * 0x9E3779B97F4A7C15u + b * 0xD1B54A32D192ED03u + 0x2545F4914F6CDD1Du;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  x ^= x >> 31;
  return static_cast<double>(x >> 11) * 0x1p-52 - 1;
}

/// Each triangle becomes parts * parts coplanar ones; neighbours share the vertices of their edge.
TriangleMesh divided(const TriangleMesh& mesh, std::uint32_t parts) {
  TriangleMesh out;
  out.positions = mesh.positions;
  std::map<std::array<std::uint32_t, 2>, std::uint32_t> first_on_edge;  // edges in ascending order of their vertices
  // Vertex at `k` parts from `a` towards `b`.
  const auto onEdge = [&](std::uint32_t a, std::uint32_t b, std::uint32_t k) {
    if (k == 0) return a;
    if (k == parts) return b;
    if (a > b) std::swap(a, b), k = parts - k;
    const auto [at, is_new] = first_on_edge.try_emplace({a, b}, static_cast<std::uint32_t>(out.positions.size()));
    for (std::uint32_t i = 1; is_new && i < parts; ++i)
      out.positions.emplace_back(mesh.positions[a] + (static_cast<double>(i) / parts) * (mesh.positions[b] - mesh.positions[a]));
    return at->second + k - 1;
  };
  std::vector<std::uint32_t> row, next;
  for (const auto& [a, b, c] : mesh.triangles) {
    row.clear();
    for (std::uint32_t j = 0; j <= parts; ++j) row.push_back(onEdge(a, b, j));
    for (std::uint32_t i = 1; i <= parts; ++i, row.swap(next)) {  // rows run parallel to ab, towards c
      next.assign(1, onEdge(a, c, i));
      const std::uint32_t last = parts - i;
      for (std::uint32_t j = 1; j < last; ++j) {
        const double u = static_cast<double>(j) / parts, v = static_cast<double>(i) / parts;
        next.push_back(static_cast<std::uint32_t>(out.positions.size()));
        out.positions.emplace_back(mesh.positions[a] + u * (mesh.positions[b] - mesh.positions[a]) +
                                   v * (mesh.positions[c] - mesh.positions[a]));
      }
      if (last > 0) next.push_back(onEdge(b, c, i));
      for (std::uint32_t j = 0; j <= last; ++j) {
        out.triangles.push_back({row[j], row[j + 1], next[j]});
        if (j < last) out.triangles.push_back({row[j + 1], next[j + 1], next[j]});
      }
    }
  }
  return out;
}

std::uint32_t partsFor(std::size_t triangles, std::size_t of) {
  return std::max(1u, static_cast<std::uint32_t>(std::lround(std::sqrt(static_cast<double>(triangles) / static_cast<double>(of)))));
}

Vector3d molarGradient(const Vector3d& p) {
  constexpr double kStep = 1e-5;
  Vector3d gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d step = kStep * Vector3d::Unit(axis);
    gradient[axis] = (spheretree::samples::molarField(p + step) - spheretree::samples::molarField(p - step)) / (2 * kStep);
  }
  return gradient;
}

TriangleMesh flatMolar(std::size_t triangles) {
  const TriangleMesh molar = spheretree::samples::makeMolar();
  return divided(molar, partsFor(triangles, molar.triangles.size()));
}

/// Its vertices lie on the implicit surface of the molar, or `noise` [mm] above or below it.
TriangleMesh curvedMolar(std::size_t triangles, double noise) {
  TriangleMesh mesh = flatMolar(triangles);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    Vector3d& p = mesh.positions[v];
    Vector3d gradient = molarGradient(p);
    for (int round = 0; round < 3; ++round) {
      p -= spheretree::samples::molarField(p) / gradient.squaredNorm() * gradient;
      if (round < 2) gradient = molarGradient(p);
    }
    p += noise * noiseAt(v, 0) * gradient.normalized();
  }
  return mesh;
}

/// Marching cubes (W. Lorensen, H. Cline, SIGGRAPH 1987) of the molar as a scanner records it: one grey value, with
/// noise, for each voxel. Cells are met in blocks, of which only those near the surface are computed.
class ScannedMolar {
 public:
  explicit ScannedMolar(double voxel) : voxel_(voxel), count_(((kHigh - kLow) / (kBlock * voxel)).array().ceil().cast<std::int64_t>()) {}

  TriangleMesh run() {
    for (std::int64_t z = 0; z < count_.z(); ++z)
      for (std::int64_t y = 0; y < count_.y(); ++y)
        for (std::int64_t x = 0; x < count_.x(); ++x) addBlock(kBlock * Cell(x, y, z));
    return weld();
  }

 private:
  using Cell = Eigen::Array<std::int64_t, 3, 1>;
  static constexpr int kBlock = 8;
  inline static const Vector3d kLow{-7, -7, -15}, kHigh{7, 7, 10};
  static constexpr double kSlope = 3;          // bound of the gradient of the field
  static constexpr double kGreyRange = 2;      // grey values end at this distance from the surface [voxels]
  static constexpr double kVoxelNoise = 0.05;  // [voxels]

  Vector3d place(const Cell& corner) const { return kLow + voxel_ * corner.matrix().cast<double>(); }

  /// One of 256 odd grey values from -255 to 255: negative inside, never 0.
  double greyAt(const Cell& corner) const {
    const double distance =
        spheretree::samples::molarField(place(corner)) / voxel_ +
        kVoxelNoise * noiseAt(static_cast<std::uint64_t>(corner.x() << 32 | corner.y()), static_cast<std::uint64_t>(corner.z()));
    return 2 * std::floor(std::clamp(distance / kGreyRange, -1.0, 0.999) * 128) + 1;
  }

  void addBlock(const Cell& low) {
    const Vector3d middle = place(low) + Vector3d::Constant(0.5 * kBlock * voxel_);
    if (std::abs(spheretree::samples::molarField(middle)) > kSlope * (kBlock / 2 + 1) * std::sqrt(3.0) * voxel_) return;
    constexpr int kSide = kBlock + 1;
    std::array<double, kSide * kSide * kSide> grey;
    for (int i = 0; i < kSide * kSide * kSide; ++i)
      grey[static_cast<std::size_t>(i)] = greyAt(low + Cell(i % kSide, i / kSide % kSide, i / (kSide * kSide)));
    for (int i = 0; i < kBlock * kBlock * kBlock; ++i) {
      const int x = i % kBlock, y = i / kBlock % kBlock, z = i / (kBlock * kBlock);
      std::array<double, 8> at;
      for (int k = 0; k < 8; ++k)
        at[static_cast<std::size_t>(k)] = grey[static_cast<std::size_t>(x + (k & 1) + kSide * (y + (k >> 1 & 1) + kSide * (z + (k >> 2))))];
      addCell(low + Cell(x, y, z), at);
    }
  }

  /// Each run of inside corners around a face of the cell contributes one side of a polygon: from the edge where the
  /// run ends to the edge where it begins.
  void addCell(const Cell& cell, const std::array<double, 8>& grey) {
    // Corners by bits x, y, z, counter-clockwise seen from outside.
    static constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    const auto isInside = [&](int corner) { return grey[static_cast<std::size_t>(corner)] < 0; };
    int inside = 0;
    for (int k = 0; k < 8; ++k) inside += isInside(k);
    if (inside == 0 || inside == 8) return;
    std::array<std::uint32_t, 64> next{};  // by edge a * 8 + b, a < b; 0: none
    const auto edge = [](int a, int b) { return static_cast<std::uint32_t>(std::min(a, b) * 8 + std::max(a, b)); };
    for (const auto& face : kFaces)
      for (int k = 0; k < 4; ++k) {
        if (isInside(face[k]) || !isInside(face[(k + 1) % 4])) continue;  // a run begins after corner k
        int last = k + 1;
        while (isInside(face[(last + 1) % 4])) ++last;
        next[edge(face[last % 4], face[(last + 1) % 4])] = edge(face[k], face[(k + 1) % 4]);
      }
    for (std::uint32_t start = 0; start < 64; ++start) {
      std::vector<std::uint64_t> polygon;
      for (std::uint32_t e = start; next[e] != 0;) {
        polygon.push_back(vertexOn(cell, static_cast<int>(e / 8), static_cast<int>(e % 8), grey));
        const std::uint32_t following = next[e];
        next[e] = 0;
        e = following;
      }
      for (std::size_t k = 1; k + 1 < polygon.size(); ++k) corners_.push_back({polygon[0], polygon[k + 1], polygon[k]});
    }
  }

  std::uint64_t vertexOn(const Cell& cell, int a, int b, const std::array<double, 8>& grey) {
    const auto corner = [&](int k) { return Cell(cell + Cell(k & 1, k >> 1 & 1, k >> 2)); };
    const Cell at = corner(a);
    const std::uint64_t key =
        (static_cast<std::uint64_t>(at.z()) << 42 | static_cast<std::uint64_t>(at.y()) << 21 | static_cast<std::uint64_t>(at.x())) * 4 +
        (b - a == 1   ? 0u
         : b - a == 2 ? 1u
                      : 2u);
    const double from = grey[static_cast<std::size_t>(a)], to = grey[static_cast<std::size_t>(b)];
    vertices_.push_back({key, place(at) + from / (from - to) * (place(corner(b)) - place(at))});
    return key;
  }

  TriangleMesh weld() {
    const auto less = [](const Vertex& a, const Vertex& b) { return a.key < b.key; };
    std::sort(vertices_.begin(), vertices_.end(), less);
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end(), [](const Vertex& a, const Vertex& b) { return a.key == b.key; }),
                    vertices_.end());
    TriangleMesh mesh;
    for (const Vertex& v : vertices_) mesh.positions.push_back(v.position);
    for (const auto& corners : corners_) {
      Triangle triangle;
      for (std::size_t k = 0; k < 3; ++k)
        triangle[k] = static_cast<std::uint32_t>(std::lower_bound(vertices_.begin(), vertices_.end(), Vertex{corners[k], {}}, less) -
                                                 vertices_.begin());
      mesh.triangles.push_back(triangle);
    }
    return mesh;
  }

  struct Vertex {
    std::uint64_t key;  // of the edge of the grid that it lies on
    Vector3d position;
  };
  double voxel_;
  Cell count_;  // blocks
  std::vector<Vertex> vertices_;
  std::vector<std::array<std::uint64_t, 3>> corners_;
};

TriangleMesh scannedMolar(std::size_t triangles) {
  constexpr double kTrianglesInVoxelFace = 1900;  // [mm^2]: triangles times the square of the voxel
  return ScannedMolar(std::sqrt(kTrianglesInVoxelFace / static_cast<double>(triangles))).run();
}

/// A stepped shaft with a flange and a tapered end, as CAD programs divide it: long triangles along the axis, about
/// 1000 times as long as wide, and two fans.
TriangleMesh turnedPart(std::size_t triangles) {
  constexpr double kSlenderness = 1000;
  constexpr std::array<std::array<double, 2>, 9> kProfile{
      // radius and height [mm]
      {{0.5, 0}, {0.9, 1}, {1.6, 8}, {1.6, 14}, {3, 14}, {3, 15.5}, {2, 15.5}, {2, 22}, {1.8, 22.2}}};
  double length = 0, largest = 0;
  for (std::size_t i = 0; i < kProfile.size(); ++i) {
    largest = std::max(largest, kProfile[i][0]);
    if (i > 0) length += std::hypot(kProfile[i][0] - kProfile[i - 1][0], kProfile[i][1] - kProfile[i - 1][1]);
  }
  // 2 * (length / long) * (around / (long / slenderness)) triangles.
  const double around = 2 * std::numbers::pi * largest;
  const double longest = std::sqrt(2 * length * around * kSlenderness / static_cast<double>(triangles));
  const auto sectors = static_cast<std::uint32_t>(std::ceil(around / longest * kSlenderness));
  std::vector<std::array<double, 2>> rings{kProfile[0]};
  for (std::size_t i = 1; i < kProfile.size(); ++i) {
    const auto [r0, z0] = kProfile[i - 1];
    const auto [r1, z1] = kProfile[i];
    const double parts = std::max(1.0, std::round(std::hypot(r1 - r0, z1 - z0) / longest));
    for (double k = 1; k <= parts; ++k) rings.push_back({r0 + k / parts * (r1 - r0), z0 + k / parts * (z1 - z0)});
  }
  TriangleMesh mesh;
  for (const auto& [r, z] : rings)
    for (std::uint32_t s = 0; s < sectors; ++s) {
      const double angle = 2 * std::numbers::pi * s / sectors;
      mesh.positions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
  const auto vertex = [&](std::size_t ring, std::uint32_t sector) { return static_cast<std::uint32_t>(ring * sectors + sector % sectors); };
  for (std::size_t ring = 0; ring + 1 < rings.size(); ++ring)
    for (std::uint32_t s = 0; s < sectors; ++s) {
      mesh.triangles.push_back({vertex(ring, s), vertex(ring, s + 1), vertex(ring + 1, s + 1)});
      mesh.triangles.push_back({vertex(ring, s), vertex(ring + 1, s + 1), vertex(ring + 1, s)});
    }
  for (const std::size_t ring : {std::size_t{0}, rings.size() - 1}) {
    const auto middle = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.emplace_back(0, 0, rings[ring][1]);
    for (std::uint32_t s = 0; s < sectors; ++s)
      mesh.triangles.push_back(ring == 0 ? Triangle{middle, vertex(ring, s + 1), vertex(ring, s)}
                                         : Triangle{middle, vertex(ring, s), vertex(ring, s + 1)});
  }
  return mesh;
}

/// Separate round bodies of 800 triangles each, of different sizes and forms.
TriangleMesh manyBodies(std::size_t triangles) {
  constexpr std::uint32_t kParts = 10;
  TriangleMesh octahedron;
  octahedron.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  octahedron.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  const TriangleMesh ball = divided(octahedron, kParts);
  const std::size_t bodies = std::max<std::size_t>(1, triangles / ball.triangles.size());
  const auto side = static_cast<std::size_t>(std::ceil(std::cbrt(static_cast<double>(bodies))));
  TriangleMesh mesh;
  for (std::size_t b = 0; b < bodies; ++b) {
    const Vector3d cell(static_cast<double>(b % side), static_cast<double>(b / side % side), static_cast<double>(b / (side * side)));
    Vector3d half;  // of an ellipsoid within the cell
    for (int axis = 0; axis < 3; ++axis) half[axis] = 0.3 + 0.1 * noiseAt(b, static_cast<std::uint64_t>(axis));
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Vector3d& p : ball.positions) mesh.positions.emplace_back(cell + half.cwiseProduct(p.normalized()));
    for (const auto& [i, j, k] : ball.triangles) mesh.triangles.push_back({first + i, first + j, first + k});
  }
  const double scale = 20 / static_cast<double>(side);  // 20 mm wide
  for (Vector3d& p : mesh.positions) p *= scale;
  return mesh;
}

std::vector<std::byte> encodeStl(const TriangleMesh& mesh) {
  constexpr std::size_t kHeader = 80, kTriangle = 50;
  std::vector<std::byte> bytes(kHeader + 4 + kTriangle * mesh.triangles.size());
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  std::memcpy(bytes.data() + kHeader, &count, sizeof count);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3f p = mesh.corner(t, k).cast<float>();  // the normal before them stays zero: readers compute it
      std::memcpy(bytes.data() + kHeader + 4 + kTriangle * t + 12 * static_cast<std::size_t>(k + 1), p.data(), 12);
    }
  return bytes;
}

std::vector<std::byte> encoded(const TriangleMesh& mesh, const std::string& extension) {
  if (extension == ".stl") return encodeStl(mesh);
  if (extension == ".ply") return spheretree::formats::encodePly(mesh);
  if (extension == ".obj") return spheretree::formats::encodeObj(mesh);
  throw std::invalid_argument("FILE ends in .stl, .ply or .obj");
}

}  // namespace

int main(int argc, char** argv) try {
  const std::map<std::string, std::function<TriangleMesh(std::size_t)>> kinds{
      {"flat", flatMolar}, {"smooth", [](std::size_t triangles) { return curvedMolar(triangles, 0); }},     {"scan", scannedMolar},
      {"cad", turnedPart}, {"noise", [](std::size_t triangles) { return curvedMolar(triangles, kNoise); }}, {"bodies", manyBodies}};
  const auto kind = argc == 4 ? kinds.find(argv[1]) : kinds.end();
  if (kind == kinds.end()) {
    std::fputs("Usage: large_mesh flat|smooth|scan|cad|noise|bodies TRIANGLES FILE.stl|.ply|.obj\n", stderr);
    return 2;
  }
  const TriangleMesh mesh = kind->second(std::stoull(argv[2]));
  const std::filesystem::path file(argv[3]);
  spheretree::formats::writeWhole(file, encoded(mesh, file.extension().string()));
  std::printf("%s: %zu triangles\n", argv[3], mesh.triangles.size());
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "large_mesh: %s\n", error.what());
  return 1;
}
