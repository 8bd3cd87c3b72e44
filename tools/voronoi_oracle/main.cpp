// SPDX-License-Identifier: AGPL-3.0-only
// voronoi_oracle POINTS: the Voronoi vertices of a point set by TetGen, an independent reference for the tests of our
// own.
//
// TetGen is under the AGPL. Therefore this is a separate program: it links TetGen and nothing of this project, no other
// program links it, and it is not installed. It communicates by text only:
//   POINTS: one point a line, `x y z`. Output: one Voronoi vertex a line, `x y z`, with 17 digits.
// H. Si. TetGen, a Delaunay-based quality tetrahedral mesh generator. ACM Trans. Math. Softw. 41(2), 2015.
#include <tetgen.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <fstream>
#include <vector>

namespace {

int run(const char* path) {
  std::ifstream file(path);
  std::vector<double> numbers;
  for (double x = 0; file >> x;) numbers.push_back(x);
  if (!file.eof() || numbers.size() % 3 != 0 || numbers.size() < 12) {
    std::fprintf(stderr, "voronoi_oracle: %s: needs four points or more, one a line, as `x y z`.\n", path);
    return 4;
  }
  tetgenio in, out;
  in.numberofpoints = static_cast<int>(numbers.size() / 3);
  in.pointlist = new REAL[numbers.size()];  // freed by tetgenio
  std::copy(numbers.begin(), numbers.end(), in.pointlist);
  char switches[] = "vQ";  // Voronoi diagram, quiet
  tetrahedralize(switches, &in, &out);
  for (int i = 0; i < out.numberofvpoints; ++i)
    std::printf("%.17g %.17g %.17g\n", out.vpointlist[3 * i], out.vpointlist[3 * i + 1], out.vpointlist[3 * i + 2]);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "Usage: voronoi_oracle POINTS\n");
    return 2;
  }
  try {
    return run(argv[1]);
  } catch (int fault) {  // TetGen throws integers
    std::fprintf(stderr, "voronoi_oracle: TetGen gives up, with its fault %d.\n", fault);
    return 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "voronoi_oracle: %s\n", error.what());
    return 1;
  }
}
