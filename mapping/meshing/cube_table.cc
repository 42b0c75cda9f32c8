#include "mapping/meshing/cube_table.h"

#include <algorithm>
#include <cassert>
#include <utility>
#include <vector>

namespace atlas::mapping {
namespace {

using Loop = std::vector<uint8_t>;

int EdgeBetween(int corner_a, int corner_b) {
  const int difference = corner_a ^ corner_b;
  const int axis = difference == 1 ? 0 : difference == 2 ? 1 : 2;
  const int low = corner_a & corner_b;
  return 4 * axis + (low >> (axis + 1) % 3 & 1) + 2 * (low >> (axis + 2) % 3 & 1);
}

/// Corners of a face, counter-clockwise seen from outside the cube.
std::array<int, 4> FaceCorners(int axis, int side) {
  const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, base = side << axis;
  if (side == 1) return {base, base | u, base | u | v, base | v};
  return {base, base | v, base | u | v, base | u};
}

/// A bit for each of the two faces that an edge borders.
int FacesOf(int edge) {
  const int axis = edge / 4, u = edge & 1, v = edge >> 1 & 1;
  return 1 << (2 * ((axis + 1) % 3) + u) | 1 << (2 * ((axis + 2) % 3) + v);
}

/// Where the surface goes from each edge over one of its faces: around every run of outside corners, so that
/// outside lies to the left of a counter-clockwise loop. -1 where it does not cross the edge.
std::array<int, 12> Successors(unsigned inside) {
  std::array<int, 12> next;
  next.fill(-1);
  const auto is_inside = [inside](int corner) { return (inside >> corner & 1u) != 0; };
  for (int face = 0; face < 6; ++face) {
    const std::array<int, 4> corner = FaceCorners(face / 2, face % 2);
    for (size_t i = 0; i < 4; ++i) {
      if (!is_inside(corner[i]) || is_inside(corner[(i + 1) % 4])) continue;
      size_t last = i + 1;  // of the run of outside corners that begins here
      while (!is_inside(corner[(last + 1) % 4])) ++last;
      const int begin = EdgeBetween(corner[i], corner[(i + 1) % 4]);
      const int end = EdgeBetween(corner[last % 4], corner[(last + 1) % 4]);
      next[static_cast<size_t>(end)] = begin;
    }
  }
  return next;
}

std::vector<Loop> LoopsOf(unsigned inside) {
  std::array<int, 12> next = Successors(inside);
  std::vector<Loop> loops;
  for (int first = 0; first < 12; ++first) {
    if (next[static_cast<size_t>(first)] < 0) continue;
    Loop loop;
    for (int edge = first; next[static_cast<size_t>(edge)] >= 0;) {
      loop.push_back(static_cast<uint8_t>(edge));
      edge = std::exchange(next[static_cast<size_t>(edge)], -1);
    }
    loops.push_back(loop);
  }
  return loops;
}

/// Cuts loop[first..last] into triangles without diagonals on a face; false where that cannot be done.
bool Cut(const Loop& loop, size_t first, size_t last, std::vector<std::array<uint8_t, 3>>* triangles) {
  if (last - first < 2) return true;
  const auto allowed = [&](size_t a, size_t b) {
    const bool side = b - a == 1 || (a == 0 && b == loop.size() - 1);
    return side || (FacesOf(loop[a]) & FacesOf(loop[b])) == 0;
  };
  const size_t before = triangles->size();
  for (size_t apex = first + 1; apex < last; ++apex) {
    if (!allowed(first, apex) || !allowed(apex, last)) continue;
    triangles->push_back({loop[first], loop[apex], loop[last]});
    if (Cut(loop, first, apex, triangles) && Cut(loop, apex, last, triangles)) return true;
    triangles->resize(before);
  }
  return false;
}

CubeCase MakeCase(unsigned inside) {
  std::vector<std::array<uint8_t, 3>> triangles;
  for (const Loop& loop : LoopsOf(inside)) {
    [[maybe_unused]] const bool cut = Cut(loop, 0, loop.size() - 1, &triangles);
    assert(cut && loop.size() >= 3);
  }
  CubeCase result;
  assert(triangles.size() <= result.triangle.size());
  result.count = static_cast<int>(triangles.size());
  std::copy(triangles.begin(), triangles.end(), result.triangle.begin());
  return result;
}

}  // namespace

CubeTable::CubeTable() {
  for (int edge = 0; edge < 12; ++edge) {
    CubeEdge e{edge / 4, {}};
    e.corner[static_cast<size_t>((e.axis + 1) % 3)] = edge & 1;
    e.corner[static_cast<size_t>((e.axis + 2) % 3)] = edge >> 1 & 1;
    edges_[static_cast<size_t>(edge)] = e;
  }
  for (unsigned inside = 0; inside < 256; ++inside) cases_[inside] = MakeCase(inside);
}

}  // namespace atlas::mapping
