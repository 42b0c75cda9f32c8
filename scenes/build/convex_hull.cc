#include "scenes/build/convex_hull.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>

namespace atlas::scenes {
namespace {

using core::Vec3;
using Face = std::array<uint32_t, 3>;

constexpr int kDirections = 256;
constexpr size_t kMostExact = 100;

/// The points farthest in directions of a Fibonacci sphere and along the axes, by ascending index.
std::vector<uint32_t> ExtremePoints(const std::vector<core::Vec3f>& points) {
  std::vector<Vec3> directions;
  for (int axis = 0; axis < 3; ++axis) {
    for (double sign : {-1.0, 1.0}) directions.push_back(sign * Vec3::Unit(axis));
  }
  for (int k = 0; k < kDirections; ++k) {
    const double z = 1.0 - 2.0 * (k + 0.5) / kDirections, a = k * 2.399963229728653,
                 r = std::sqrt(1.0 - z * z);
    directions.emplace_back(r * std::cos(a), r * std::sin(a), z);
  }
  std::vector<uint32_t> chosen;
  for (const Vec3& d : directions) {
    uint32_t best = 0;
    for (uint32_t i = 1; i < points.size(); ++i) {
      if (d.dot(points[i].cast<double>()) > d.dot(points[best].cast<double>())) best = i;
    }
    chosen.push_back(best);
  }
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

/// What the hull is taken of: every point while they are few, else the extreme ones; none twice.
std::vector<Vec3> HullCandidates(const std::vector<core::Vec3f>& points) {
  std::vector<uint32_t> chosen(points.size());
  std::iota(chosen.begin(), chosen.end(), 0u);
  if (points.size() > kMostExact) chosen = ExtremePoints(points);
  std::vector<Vec3> candidates;
  for (uint32_t i : chosen) {
    const Vec3 p = points[i].cast<double>();
    const auto same = [&](const Vec3& q) { return (p - q).norm() < 1e-6; };
    if (std::none_of(candidates.begin(), candidates.end(), same)) candidates.push_back(p);
  }
  return candidates;
}

double Height(const std::vector<Vec3>& p, const Face& f, const Vec3& q) {
  const Vec3 normal = (p[f[1]] - p[f[0]]).cross(p[f[2]] - p[f[0]]);
  return normal.dot(q - p[f[0]]) / std::max(normal.norm(), 1e-30);
}

/// Moves four points that span a volume to the front and returns their outward faces.
std::optional<std::vector<Face>> FirstTetrahedron(std::vector<Vec3>& p, double tolerance) {
  if (p.size() < 4) return std::nullopt;
  const auto farthest = [&](size_t from, auto&& measure) {
    std::iter_swap(p.begin() + static_cast<std::ptrdiff_t>(from),
                   std::max_element(p.begin() + static_cast<std::ptrdiff_t>(from), p.end(),
                                    [&](const Vec3& a, const Vec3& b) { return measure(a) < measure(b); }));
    return measure(p[from]) > tolerance;
  };
  if (!farthest(1, [&](const Vec3& q) { return (q - p[0]).norm(); })) return std::nullopt;
  const Vec3 p0 = p[0], along = (p[1] - p0).normalized();
  if (!farthest(2, [&](const Vec3& q) { return (q - p0).cross(along).norm(); })) return std::nullopt;
  const Vec3 normal = along.cross(p[2] - p0).normalized();
  if (!farthest(3, [&](const Vec3& q) { return std::abs(normal.dot(q - p0)); })) return std::nullopt;
  if (normal.dot(p[3] - p0) > 0) std::swap(p[1], p[2]);
  return std::vector<Face>{{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
}

/// Replaces the faces that see point k by a fan from their rim to it.
void AddPoint(const std::vector<Vec3>& p, uint32_t k, double tolerance, std::vector<Face>& faces) {
  std::map<std::pair<uint32_t, uint32_t>, int> seen_edges;
  std::vector<Face> kept;
  for (const Face& f : faces) {
    if (Height(p, f, p[k]) <= tolerance) {
      kept.push_back(f);
      continue;
    }
    for (int e = 0; e < 3; ++e) seen_edges[{f[e], f[(e + 1) % 3]}] = 1;
  }
  for (const auto& [edge, one] : seen_edges) {
    if (!seen_edges.contains({edge.second, edge.first})) kept.push_back({edge.first, edge.second, k});
  }
  faces = std::move(kept);
}

}  // namespace

core::TriMesh ConvexHull(const std::vector<core::Vec3f>& points) {
  core::TriMesh hull;
  if (points.size() < 4) return hull;
  std::vector<Vec3> p = HullCandidates(points);
  core::Box3 box;
  for (const Vec3& q : p) box.Extend(q);
  const double tolerance = 1e-6 * std::max(box.Size().norm(), 1e-3);
  auto faces = FirstTetrahedron(p, tolerance);
  if (!faces) return hull;
  for (uint32_t k = 4; k < p.size(); ++k) AddPoint(p, k, tolerance, *faces);

  std::map<uint32_t, uint32_t> place;
  for (Face f : *faces) {
    for (uint32_t& i : f) {
      const auto [it, added] = place.emplace(i, static_cast<uint32_t>(hull.vertices.size()));
      if (added) hull.vertices.push_back(p[i].cast<float>());
      i = it->second;
    }
    hull.triangles.push_back(f);
  }
  return hull;
}

}  // namespace atlas::scenes
