// Marching cubes' cases, derived instead of pasted: the surface's path over each face of a cube, joined to
// loops, each loop cut into triangles.
//
//        6-------7        Corner c lies at (c & 1, c >> 1 & 1, c >> 2). Edge 4 a + u + 2 v runs along axis a
//        at
//       /|      /|        place (u, v) of the axes after it, (a + 1) mod 3 and (a + 2) mod 3.
//      4-------5 |
//      | 2-----|-3        On a face with inside corners at one diagonal only, these are joined. The rule sees
//      |/      |/         nothing but the face's own corners, so the two cubes that share a face draw the
//      same 0-------1          lines on it: no cracks, whatever the field.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace atlas::mapping {

struct CubeEdge {
  int axis;
  std::array<int, 3> corner;  ///< offset of the end with the lower coordinates
};

/// Triangles of edge numbers, counter-clockwise seen from outside (from corners whose bit is 0). No side of a
/// triangle runs over a face but the surface's own line there, which the neighbour draws once more.
struct CubeCase {
  int count = 0;
  std::array<std::array<uint8_t, 3>, 5> triangle = {};
};

/// Index: bit c is set where corner c is inside.
class CubeTable {
 public:
  CubeTable();
  const CubeCase& Case(unsigned inside) const { return cases_[inside]; }
  const CubeEdge& Edge(size_t edge) const { return edges_[edge]; }

 private:
  std::array<CubeEdge, 12> edges_;
  std::array<CubeCase, 256> cases_;
};

}  // namespace atlas::mapping
