// Where a scene's surfaces are and which of them are exposed, judged from the triangles alone: distances
// point to triangle in closed form, solids by the winding number along slanted rays. Shares nothing with
// scenes/.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/geometry.h"
#include "core/rng.h"
#include "scenes/scene_spec.h"

namespace atlas::tests {

using Triangle = std::array<core::Vec3, 3>;

/// Distance of `p` to the segment a-b.
inline double DistanceToSegment(const core::Vec3& p, const core::Vec3& a, const core::Vec3& b) {
  const core::Vec3 ab = b - a;
  const double u = ab.squaredNorm() > 0.0 ? std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) : 0.0;
  return (p - a - u * ab).norm();
}

/// Distance of `p` to the triangle: to its plane where the foot of the perpendicular lies inside, else to its
/// edges.
inline double DistanceToTriangle(const core::Vec3& p, const Triangle& t) {
  const core::Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
  bool inside = n.squaredNorm() > 0.0;
  double to_edges = 1e300;
  for (int k = 0; k < 3; ++k) {
    const core::Vec3 &a = t[k], &b = t[(k + 1) % 3];
    inside = inside && n.dot((b - a).cross(p - a)) >= 0.0;
    to_edges = std::min(to_edges, DistanceToSegment(p, a, b));
  }
  return inside ? std::abs(n.dot(p - t[0])) / n.norm() : to_edges;
}

/// All triangles of the parts that `wanted` takes.
template <typename Wanted>
std::vector<Triangle> TrianglesOf(const scenes::SceneSpec& scene, const Wanted& wanted) {
  std::vector<Triangle> triangles;
  for (const scenes::ScenePart& part : scene.parts) {
    if (!wanted(part)) continue;
    for (const auto& t : part.mesh.triangles) {
      triangles.push_back({part.mesh.vertices[t[0]].cast<double>(), part.mesh.vertices[t[1]].cast<double>(),
                           part.mesh.vertices[t[2]].cast<double>()});
    }
  }
  return triangles;
}

/// Items by the cells of a cubic grid that their boxes touch.
class CellLists {
 public:
  explicit CellLists(double cell_m) : cell_m_(cell_m) {}
  void Add(const core::Vec3& lo, const core::Vec3& hi, uint32_t item) {
    const auto a = CellOf(lo), b = CellOf(hi);
    for (int64_t z = a[2]; z <= b[2]; ++z) {
      for (int64_t y = a[1]; y <= b[1]; ++y) {
        for (int64_t x = a[0]; x <= b[0]; ++x) cells_[KeyOf({x, y, z})].push_back(item);
      }
    }
  }
  const std::vector<uint32_t>& At(const core::Vec3& p) const {
    static const std::vector<uint32_t> kNone;
    const auto found = cells_.find(KeyOf(CellOf(p)));
    return found == cells_.end() ? kNone : found->second;
  }

 private:
  std::array<int64_t, 3> CellOf(const core::Vec3& p) const {
    return {static_cast<int64_t>(std::floor(p.x() / cell_m_)),
            static_cast<int64_t>(std::floor(p.y() / cell_m_)),
            static_cast<int64_t>(std::floor(p.z() / cell_m_))};
  }
  static int64_t KeyOf(const std::array<int64_t, 3>& c) {
    return (c[0] + (1 << 20)) * (1ll << 42) + (c[1] + (1 << 20)) * (1ll << 21) + (c[2] + (1 << 20));
  }
  double cell_m_;
  std::unordered_map<int64_t, std::vector<uint32_t>> cells_;
};

/// How many of `points` (every `stride`-th is looked at) lie farther than `limit_m` from all triangles.
inline size_t CountOff(const std::vector<core::Vec3f>& points, const std::vector<Triangle>& triangles,
                       double limit_m, size_t stride) {
  CellLists cells(0.25);
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    const Triangle& t = triangles[i];
    const core::Vec3 lo = t[0].cwiseMin(t[1]).cwiseMin(t[2]), hi = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
    cells.Add(lo.array() - limit_m, hi.array() + limit_m, i);
  }
  size_t off = 0;
  for (size_t i = 0; i < points.size(); i += stride) {
    const core::Vec3 p = points[i].cast<double>();
    bool met = false;
    for (const uint32_t k : cells.At(p)) {
      met = DistanceToTriangle(p, triangles[k]) <= limit_m;
      if (met) break;
    }
    off += !met;
  }
  return off;
}

/// Winding number of `p` with respect to closed, outward-facing shells: signed crossings of a slanted ray, by
/// brute force over all triangles.
inline int WindingAlong(const core::Vec3& p, const core::Vec3& direction,
                        const std::vector<Triangle>& triangles) {
  int winding = 0;
  for (const Triangle& t : triangles) {
    const core::Vec3 e1 = t[1] - t[0], e2 = t[2] - t[0], h = direction.cross(e2);
    const double det = e1.dot(h);
    if (std::abs(det) < 1e-15) continue;
    const core::Vec3 s = p - t[0];
    const double u = s.dot(h) / det;
    if (u < 0.0 || u > 1.0) continue;
    const core::Vec3 q = s.cross(e1);
    const double v = direction.dot(q) / det;
    if (v < 0.0 || u + v > 1.0 || e2.dot(q) / det <= 0.0) continue;
    winding += direction.dot(e1.cross(e2)) > 0.0 ? 1 : -1;
  }
  return winding;
}

/// Majority over three directions, so that a ray through an edge decides nothing.
inline bool IsFilled(const core::Vec3& p, const std::vector<Triangle>& solids) {
  static const core::Vec3 kDirections[] = {core::Vec3(0.31, 0.52, 0.79).normalized(),
                                           core::Vec3(-0.62, 0.23, 0.71).normalized(),
                                           core::Vec3(0.17, -0.83, 0.44).normalized()};
  const bool a = WindingAlong(p, kDirections[0], solids) != 0,
             b = WindingAlong(p, kDirections[1], solids) != 0;
  return a == b ? a : WindingAlong(p, kDirections[2], solids) != 0;
}

struct SurfaceSample {
  core::Vec3 p;
  core::Vec3 normal;
};

/// Points drawn evenly by area from `surfaces`, those kept before which nothing of `solids` is, neither 0.2
/// mm nor 2 mm along the outer normal. No scene-specific rule.
inline std::vector<SurfaceSample> ExposedSamples(const std::vector<Triangle>& surfaces,
                                                 const std::vector<Triangle>& solids, int draws,
                                                 uint64_t seed) {
  std::vector<double> area_until;
  double area = 0.0;
  for (const Triangle& t : surfaces) {
    area += 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm();
    area_until.push_back(area);
  }
  core::Rng rng(seed);
  std::vector<SurfaceSample> samples;
  for (int k = 0; k < draws; ++k) {
    // Stratified over the area.
    const double at = area * (k + rng.Uniform()) / draws;
    const auto i =
        static_cast<size_t>(std::lower_bound(area_until.begin(), area_until.end(), at) - area_until.begin());
    const Triangle& t = surfaces[std::min(i, surfaces.size() - 1)];
    const double r = std::sqrt(rng.Uniform()), s = rng.Uniform();
    const core::Vec3 p = (1.0 - r) * t[0] + r * (1.0 - s) * t[1] + r * s * t[2];
    const core::Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
    if (!IsFilled(p + 2e-3 * n, solids) && !IsFilled(p + 2e-4 * n, solids)) samples.push_back({p, n});
  }
  return samples;
}

/// For each sample the distance to the nearest of `points`, or `limit_m` where none is as near.
inline std::vector<double> DistancesToPoints(const std::vector<SurfaceSample>& samples,
                                             const std::vector<core::Vec3f>& points, double limit_m) {
  CellLists cells(limit_m);  // of samples, so that the many points need no table
  const core::Vec3 reach = core::Vec3::Constant(limit_m);
  for (uint32_t i = 0; i < samples.size(); ++i) cells.Add(samples[i].p - reach, samples[i].p + reach, i);
  std::vector<double> nearest(samples.size(), limit_m);
  for (const core::Vec3f& point : points) {
    const core::Vec3 p = point.cast<double>();
    for (const uint32_t i : cells.At(p)) nearest[i] = std::min(nearest[i], (samples[i].p - p).norm());
  }
  return nearest;
}

}  // namespace atlas::tests
