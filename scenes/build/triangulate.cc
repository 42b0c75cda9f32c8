#include "scenes/build/triangulate.h"

#include <cassert>
#include <numeric>

namespace atlas::scenes {
namespace {

using core::Vec2;

bool IsEar(const std::vector<Vec2>& p, const std::vector<uint32_t>& left, size_t k) {
  const size_t n = left.size();
  const uint32_t ia = left[(k + n - 1) % n], ib = left[k], ic = left[(k + 1) % n];
  if (Cross(p[ia], p[ib], p[ic]) <= 1e-12) return false;
  for (uint32_t i : left) {
    if (i == ia || i == ib || i == ic) continue;
    if (Cross(p[ia], p[ib], p[i]) >= 0 && Cross(p[ib], p[ic], p[i]) >= 0 && Cross(p[ic], p[ia], p[i]) >= 0) {
      return false;
    }
  }
  return true;
}

}  // namespace

std::vector<std::array<uint32_t, 3>> TriangulatePolygon(const std::vector<Vec2>& polygon) {
  assert(polygon.size() >= 3);
  std::vector<uint32_t> left(polygon.size());
  std::iota(left.begin(), left.end(), 0u);
  std::vector<std::array<uint32_t, 3>> triangles;
  while (left.size() > 3) {
    size_t ear = 0;
    while (ear < left.size() && !IsEar(polygon, left, ear)) ++ear;
    assert(ear < left.size() && "polygon is not simple and counter-clockwise");
    if (ear == left.size()) break;
    const size_t n = left.size();
    triangles.push_back({left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

}  // namespace atlas::scenes
