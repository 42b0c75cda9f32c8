#include "scenes/truth_check.h"

#include <array>
#include <unordered_map>

#include "core/rng.h"
#include "scenes/solid_test.h"

namespace atlas::scenes {
namespace {

using core::Vec3;
using core::Vec3f;

constexpr double kCell_m = 0.25;
constexpr int kMostRings = 12;  // of cells about a point: 3 m
// A face is exposed where nothing is this far before it.
constexpr double kClearances_m[] = {2e-4, 2e-3};

using Cell = Eigen::Vector3i;
using Triangle = std::array<Vec3, 3>;

int64_t KeyOf(const Cell& c) {
  constexpr int64_t kHalf = 1 << 20;
  return ((c.x() + kHalf) << 42) | ((c.y() + kHalf) << 21) | (c.z() + kHalf);
}

Cell CellOf(const Vec3& p, double cell_m) {
  return (p / cell_m).array().floor().cast<int>();
}

double SegmentDistance(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double length_sq = ab.squaredNorm();
  const double u = length_sq > 0.0 ? std::clamp(ab.dot(p - a) / length_sq, 0.0, 1.0) : 0.0;
  return (p - (a + u * ab)).norm();
}

/// By barycentric coordinates of the foot of the perpendicular.
double TriangleDistance(const Vec3& p, const Triangle& t) {
  const Vec3 u = t[1] - t[0], v = t[2] - t[0], w = p - t[0], n = u.cross(v);
  const double nn = n.squaredNorm();
  if (nn > 0.0) {
    const double c = u.cross(w).dot(n) / nn, b = w.cross(v).dot(n) / nn;
    if (b >= 0.0 && c >= 0.0 && b + c <= 1.0) return std::abs(w.dot(n)) / std::sqrt(nn);
  }
  return std::min(
      {SegmentDistance(p, t[0], t[1]), SegmentDistance(p, t[1], t[2]), SegmentDistance(p, t[2], t[0])});
}

/// Triangles by the cells that their boxes touch.
class TriangleCells {
 public:
  explicit TriangleCells(const std::vector<Triangle>& triangles) : triangles_(triangles) {
    for (uint32_t i = 0; i < triangles.size(); ++i) {
      const Triangle& t = triangles[i];
      const Cell lo = CellOf(t[0].cwiseMin(t[1]).cwiseMin(t[2]), kCell_m),
                 hi = CellOf(t[0].cwiseMax(t[1]).cwiseMax(t[2]), kCell_m);
      for (int z = lo.z(); z <= hi.z(); ++z) {
        for (int y = lo.y(); y <= hi.y(); ++y) {
          for (int x = lo.x(); x <= hi.x(); ++x) cells_[KeyOf({x, y, z})].push_back(i);
        }
      }
    }
  }

  /// Distance of `p` to the nearest triangle, ring after ring of cells.
  double DistanceTo(const Vec3& p) const {
    const Cell home = CellOf(p, kCell_m);
    double nearest = kMostRings * kCell_m;
    for (int ring = 0; ring <= kMostRings && nearest > (ring - 1) * kCell_m; ++ring) {
      for (int z = -ring; z <= ring; ++z) {
        for (int y = -ring; y <= ring; ++y) {
          const bool shell = std::max(std::abs(y), std::abs(z)) == ring;
          for (int x = -ring; x <= ring; x += shell || ring == 0 ? 1 : 2 * ring) {
            const auto found = cells_.find(KeyOf(home + Cell(x, y, z)));
            if (found == cells_.end()) continue;
            for (const uint32_t i : found->second)
              nearest = std::min(nearest, TriangleDistance(p, triangles_[i]));
          }
        }
      }
    }
    return nearest;
  }

 private:
  const std::vector<Triangle>& triangles_;
  std::unordered_map<int64_t, std::vector<uint32_t>> cells_;
};

/// The object's triangles, and for each whether its shell is closed.
struct ObjectSurface {
  std::vector<Triangle> triangles;
  std::vector<bool> closed;
};

struct Surfaces {
  ObjectSurface object;
  std::vector<core::TriMesh> solids;  ///< closed shells of all parts, facing outward
};

Surfaces SurfacesOf(const SceneSpec& scene) {
  Surfaces all;
  for (const ScenePart& part : scene.parts) {
    for (core::TriMesh& shell : SplitShells(part.mesh)) {
      const bool closed = IsWatertight(shell);
      if (closed && SignedVolume(shell) < 0.0) TurnInsideOut(&shell);
      if (part.is_object) {
        for (const auto& t : shell.triangles) {
          all.object.triangles.push_back({shell.vertices[t[0]].cast<double>(),
                                          shell.vertices[t[1]].cast<double>(),
                                          shell.vertices[t[2]].cast<double>()});
          all.object.closed.push_back(closed);
        }
      }
      if (closed) all.solids.push_back(std::move(shell));
    }
  }
  return all;
}

void CheckDistances(const GroundTruth& truth, const std::vector<Triangle>& triangles, TruthReport* report) {
  const TriangleCells cells(triangles);
  double sum = 0.0;
  for (const Vec3f& p : truth.points) {
    const double distance = cells.DistanceTo(p.cast<double>());
    report->off_mesh += distance > TruthReport::kOffMesh_m;
    report->greatest_m = std::max(report->greatest_m, distance);
    sum += distance;
  }
  report->points = truth.points.size();
  report->mean_m = sum / static_cast<double>(std::max<size_t>(1, truth.points.size()));
}

/// Points drawn evenly by area, those with free space before them.
std::vector<Vec3> DrawExposed(const Surfaces& surfaces, int draws) {
  std::vector<const core::TriMesh*> shells;
  for (const core::TriMesh& shell : surfaces.solids) shells.push_back(&shell);
  const SolidTest solids(shells);
  std::vector<double> area_until;
  double area = 0.0;
  for (const Triangle& t : surfaces.object.triangles) {
    area += 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm();
    area_until.push_back(area);
  }
  std::vector<Vec3> exposed;
  if (!(area > 0.0)) return exposed;
  core::Rng rng(1);
  for (int k = 0; k < draws; ++k) {
    const double at = area * (k + rng.Uniform()) / draws;
    const auto i = std::min<size_t>(
        static_cast<size_t>(std::lower_bound(area_until.begin(), area_until.end(), at) - area_until.begin()),
        area_until.size() - 1);
    const Triangle& t = surfaces.object.triangles[i];
    const double r = std::sqrt(rng.Uniform()), s = rng.Uniform();
    const Vec3 p = (1.0 - r) * t[0] + r * (1.0 - s) * t[1] + r * s * t[2];
    const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
    const auto free = [&](const Vec3& along) {
      return std::none_of(std::begin(kClearances_m), std::end(kClearances_m),
                          [&](double ahead) { return solids.IsInside(p + ahead * along); });
    };
    if (free(normal) || (!surfaces.object.closed[i] && free(-normal))) exposed.push_back(p);
  }
  return exposed;
}

void CheckCompleteness(const GroundTruth& truth, const std::vector<Vec3>& exposed, TruthReport* report) {
  const double limit_m = 3.0 * report->spacing_m;
  std::unordered_map<int64_t, std::vector<uint32_t>> near;  // samples by the cells within reach of them
  for (uint32_t i = 0; i < exposed.size(); ++i) {
    const Cell home = CellOf(exposed[i], limit_m);
    for (int k = 0; k < 27; ++k) near[KeyOf(home + Cell(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1))].push_back(i);
  }
  std::vector<double> gap(exposed.size(), limit_m);
  for (const Vec3f& point : truth.points) {
    const Vec3 p = point.cast<double>();
    const auto found = near.find(KeyOf(CellOf(p, limit_m)));
    if (found == near.end()) continue;
    for (const uint32_t i : found->second) gap[i] = std::min(gap[i], (exposed[i] - p).norm());
  }
  report->exposed = exposed.size();
  for (size_t i = 0; i < exposed.size(); ++i) {
    report->missed += gap[i] > report->spacing_m;
    if (gap[i] <= report->worst_gap_m) continue;
    report->worst_gap_m = gap[i];
    report->worst_gap_map = exposed[i];
  }
}

}  // namespace

TruthReport CheckTruth(const SceneSpec& scene, const GroundTruth& truth, double spacing_m, int draws) {
  TruthReport report{.spacing_m = spacing_m, .drawn = static_cast<size_t>(draws)};
  const Surfaces surfaces = SurfacesOf(scene);
  CheckDistances(truth, surfaces.object.triangles, &report);
  CheckCompleteness(truth, DrawExposed(surfaces, draws), &report);
  return report;
}

std::vector<PartReport> CheckParts(const SceneSpec& scene) {
  std::vector<PartReport> reports;
  for (const ScenePart& part : scene.parts) {
    PartReport report{
        .name = part.name, .is_object = part.is_object, .triangles = part.mesh.triangles.size()};
    for (const core::TriMesh& shell : SplitShells(part.mesh)) {
      ++report.shells;
      const bool closed = IsWatertight(shell);
      report.open_shells += !closed;
      report.inward_shells += closed && SignedVolume(shell) < 0.0;
    }
    for (const auto& t : part.mesh.triangles) {
      const Vec3f a = part.mesh.vertices[t[0]], b = part.mesh.vertices[t[1]], c = part.mesh.vertices[t[2]];
      report.flat_triangles += !((b - a).cross(c - a).squaredNorm() > 0.0f);
    }
    reports.push_back(report);
  }
  return reports;
}

}  // namespace atlas::scenes
