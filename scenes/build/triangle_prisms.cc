#include "scenes/build/triangle_prisms.h"

#include <algorithm>
#include <map>
#include <set>

#include "scenes/build/shapes.h"
#include "scenes/solid_test.h"

namespace atlas::scenes {
namespace {

using core::TriMesh;
using core::Vec3;

struct Corners {
  Vec3 p[3];

  Vec3 DoubledArea() const { return (p[1] - p[0]).cross(p[2] - p[0]); }
  /// Least height over a side: what tells a sliver.
  double LeastHeight() const {
    const double longest = std::max({(p[1] - p[0]).norm(), (p[2] - p[1]).norm(), (p[0] - p[2]).norm()});
    return longest > 0 ? DoubledArea().norm() / longest : 0.0;
  }
};

Corners CornersOf(const TriMesh& mesh, size_t triangle) {
  Corners c;
  for (int k = 0; k < 3; ++k) c.p[k] = mesh.vertices[mesh.triangles[triangle][k]].cast<double>();
  return c;
}

/// The reachable triangles that are wide enough to be a body.
TriMesh Reachable(const TriMesh& mesh, double reach_z_m) {
  constexpr double kLeastHeight_m = 5e-4;
  TriMesh reachable;
  reachable.vertices = mesh.vertices;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Corners c = CornersOf(mesh, i);
    if (std::min({c.p[0].z(), c.p[1].z(), c.p[2].z()}) >= reach_z_m || c.LeastHeight() < kLeastHeight_m)
      continue;
    reachable.triangles.push_back(mesh.triangles[i]);
  }
  return reachable;
}

/// Vertices in one cell of a grid become their mean; triangles that collapse or repeat go.
TriMesh Clustered(const TriMesh& mesh, double cell_m) {
  std::map<std::array<int, 3>, uint32_t> cells;
  std::map<uint32_t, uint32_t> cluster_of;
  std::vector<std::pair<Vec3, int>> sums;
  for (const auto& t : mesh.triangles) {
    for (uint32_t v : t) {
      if (cluster_of.contains(v)) continue;
      const Vec3 p = mesh.vertices[v].cast<double>();
      std::array<int, 3> cell;
      for (int k = 0; k < 3; ++k) cell[k] = static_cast<int>(std::floor(p[k] / cell_m));
      const auto [it, added] = cells.emplace(cell, static_cast<uint32_t>(sums.size()));
      if (added) sums.emplace_back(Vec3::Zero(), 0);
      sums[it->second].first += p;
      sums[it->second].second += 1;
      cluster_of[v] = it->second;
    }
  }
  TriMesh merged;
  for (const auto& [sum, count] : sums) merged.vertices.push_back((sum / count).cast<float>());
  std::set<std::array<uint32_t, 3>> known;
  for (const auto& t : mesh.triangles) {
    const std::array<uint32_t, 3> now = {cluster_of[t[0]], cluster_of[t[1]], cluster_of[t[2]]};
    std::array<uint32_t, 3> key = now;
    std::sort(key.begin(), key.end());
    if (key[0] != key[1] && key[1] != key[2] && known.insert(key).second) merged.triangles.push_back(now);
  }
  return merged;
}

}  // namespace

std::vector<CollisionShape> TrianglePrisms(const TriMesh& mesh, const PrismOptions& options) {
  const TriMesh exact = Reachable(mesh, options.reach_z_m);
  TriMesh felt = exact;
  const auto most = static_cast<size_t>(options.most_prisms);
  for (double cell_m = 0.05; felt.triangles.size() > most; cell_m *= 1.25) {
    felt = Reachable(Clustered(exact, cell_m), options.reach_z_m);
  }
  std::vector<CollisionShape> prisms;
  for (size_t i = 0; i < felt.triangles.size(); ++i) {
    const Corners c = CornersOf(felt, i);
    const Vec3 behind = -options.thickness_m * c.DoubledArea().normalized();
    prisms.push_back(
        {HullShape{MakeLoft({{c.p[0] + behind, c.p[1] + behind, c.p[2] + behind}, {c.p[0], c.p[1], c.p[2]}})},
         core::Pose::Identity()});
  }
  return prisms;
}

bool IsConvex(const TriMesh& mesh) {
  constexpr double kTolerance_m = 1e-3;
  if (!IsWatertight(mesh)) return false;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Corners c = CornersOf(mesh, i);
    const Vec3 normal = c.DoubledArea().normalized();
    for (const core::Vec3f& v : mesh.vertices) {
      if (normal.dot(v.cast<double>() - c.p[0]) > kTolerance_m) return false;
    }
  }
  return true;
}

}  // namespace atlas::scenes
