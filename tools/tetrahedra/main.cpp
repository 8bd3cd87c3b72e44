// SPDX-License-Identifier: AGPL-3.0-only
// spheretree-tetrahedra SURFACE OUTPUT VOLUME: fills a closed surface with tetrahedra, by TetGen.
//
// TetGen is under the AGPL. Therefore this is a separate program: it links TetGen and nothing of this project, and no
// other program links it. `spheretree soften` runs it as a child process with a time limit, because for bad surfaces
// TetGen can run endlessly, throw integers or corrupt memory. It communicates through text files:
//   SURFACE: a line `V T`; V lines `x y z` [mm]; T lines `a b c`, corners from 0, counter-clockwise seen from outside.
//   VOLUME:  largest volume of a tetrahedron [mm^3]; 0: no limit.
//   OUTPUT:  a line `N M`; N lines `x y z` with 17 digits, the vertices of the surface first; M lines `a b c d`.
// The surface does not change: no point is added on it (option Y). Exit codes: 0 ok, 2 usage, 4 input refused, 1
// failed.
// H. Si. TetGen, a Delaunay-based quality tetrahedral mesh generator. ACM Trans. Math. Softw. 41(2), 2015.
#include <sys/resource.h>
#include <tetgen.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <string>
#include <vector>

namespace {

constexpr rlim_t kMaxMemory = rlim_t{4} << 30;  // limit for an endless refinement [bytes]
constexpr long kMaxElements = 2'000'000;        // of the surface: keeps every product within the range of TetGen's integers

int refuse(const std::string& what) {
  std::fprintf(stderr, "spheretree-tetrahedra: %s\n", what.c_str());
  return 4;
}

bool readSurface(const char* path, tetgenio& in) {
  std::ifstream file(path);
  long vertices = 0, triangles = 0;
  if (!(file >> vertices >> triangles) || vertices < 4 || triangles < 4 || vertices > kMaxElements || triangles > kMaxElements)
    return false;
  in.firstnumber = 0;
  in.numberofpoints = static_cast<int>(vertices);
  in.pointlist = new REAL[static_cast<std::size_t>(3 * vertices)];  // tetgenio frees this and the arrays below
  for (long i = 0; i < 3 * vertices; ++i)
    if (!(file >> in.pointlist[i])) return false;
  in.numberoffacets = static_cast<int>(triangles);
  in.facetlist = new tetgenio::facet[static_cast<std::size_t>(triangles)];
  for (long t = 0; t < triangles; ++t) tetgenio::init(&in.facetlist[t]);
  for (long t = 0; t < triangles; ++t) {
    tetgenio::facet& facet = in.facetlist[t];
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    tetgenio::polygon& polygon = facet.polygonlist[0];
    polygon.numberofvertices = 3;
    polygon.vertexlist = new int[3]{};
    for (int k = 0; k < 3; ++k)
      if (!(file >> polygon.vertexlist[k]) || polygon.vertexlist[k] < 0 || polygon.vertexlist[k] >= vertices) return false;
  }
  return true;
}

bool writeTetrahedra(const char* path, const tetgenio& out) {
  std::FILE* file = std::fopen(path, "w");
  if (!file) return false;
  std::fprintf(file, "%d %d\n", out.numberofpoints, out.numberoftetrahedra);
  for (int i = 0; i < out.numberofpoints; ++i)
    std::fprintf(file, "%.17g %.17g %.17g\n", out.pointlist[3 * i], out.pointlist[3 * i + 1], out.pointlist[3 * i + 2]);
  for (int i = 0; i < out.numberoftetrahedra; ++i) {
    const int* corner = out.tetrahedronlist + i * out.numberofcorners;
    std::fprintf(file, "%d %d %d %d\n", corner[0], corner[1], corner[2], corner[3]);
  }
  const bool is_written = std::ferror(file) == 0;
  return std::fclose(file) == 0 && is_written;
}

int run(const char* surface, const char* output, const char* volume_text) {
  char* end = nullptr;
  const double volume = std::strtod(volume_text, &end);
  if (*end != 0 || !(volume >= 0)) return refuse(std::string(volume_text) + ": the largest volume must be a number of 0 or more.");
  tetgenio in, out;
  if (!readSurface(surface, in))
    return refuse(std::string(surface) +
                  ": this is not a surface file: a line with the numbers of vertices and triangles, the vertices, the triangles.");
  // p: a surface is given; q1.4: if possible, no tetrahedron has a radius above 1.4 times its shortest edge; Y: nothing
  // is added on the surface; Q: quiet; a: largest volume.
  std::string switches = "pq1.4YQ";
  char limit[64];
  std::snprintf(limit, sizeof limit, "a%.9f", volume);
  if (volume > 0) switches += limit;
  tetrahedralize(switches.data(), &in, &out);
  if (out.numberoftetrahedra == 0) return refuse("TetGen found nothing to fill.");
  if (!writeTetrahedra(output, out)) {
    std::fprintf(stderr, "spheretree-tetrahedra: %s: cannot be written.\n", output);
    return 1;
  }
  return 0;
}

/// The meaning of TetGen's exit codes, from terminatetetgen() in tetgen.h.
const char* meaningOf(int fault) {
  switch (fault) {
    case 1:
      return "out of memory";
    case 3:
      return "two triangles of the surface cross";
    case 4:
      return "a feature of the surface is too small for its arithmetic";
    case 5:
      return "two triangles of the surface nearly coincide";
    case 10:
      return "an input error";
    default:
      return "an internal error";
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "Usage: spheretree-tetrahedra SURFACE OUTPUT VOLUME\nRun by `spheretree soften`; SPDX: AGPL-3.0-only.\n");
    return 2;
  }
  const rlimit memory{kMaxMemory, kMaxMemory}, no_core{0, 0};
  setrlimit(RLIMIT_AS, &memory);
  setrlimit(RLIMIT_CORE, &no_core);
  try {
    return run(argv[1], argv[2], argv[3]);
  } catch (int fault) {  // TetGen throws integers
    return refuse(std::string("TetGen gives up: ") + meaningOf(fault) + " (its code " + std::to_string(fault) + ").");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "spheretree-tetrahedra: %s\n", error.what());
    return 1;
  }
}
