// The uniform cloud of an object's exposed surfaces that coverage is scored against (thesis Eq. 3.9).
//
// Each triangle carries the points of a square lattice in its plane. The lattice is anchored at the map's
// origin, so coplanar triangles share it, and is turned by an angle of irrational slope, so that strips
// narrower than the spacing get their share of points too. A point stays when a millimetre before it no solid
// fills the space. Small facets that no lattice
// point met get points of their own. So exposed surface has truth within the spacing, but for less than one
// part in a thousand at rims, and within 1.25 spacings there.
#include <unordered_map>

#include "scenes/catalog.h"
#include "scenes/solid_test.h"

namespace atlas::scenes {
namespace {

using core::Vec2;
using core::Vec3;

constexpr double kOffset_m = 1e-3;

/// Lists by cell of a cubic grid, for asking which of many places lie within a reach of a point.
class ReachCells {
 public:
  explicit ReachCells(double reach_m) : reach_m_(reach_m) {}
  void Add(const Vec3& p, uint32_t item) {
    const Cell lo = CellOf(p.array() - reach_m_), hi = CellOf(p.array() + reach_m_);
    for (int z = lo.z(); z <= hi.z(); ++z) {
      for (int y = lo.y(); y <= hi.y(); ++y) {
        for (int x = lo.x(); x <= hi.x(); ++x) cells_[KeyOf({x, y, z})].push_back(item);
      }
    }
  }
  /// All items within the reach of `p`, and some beyond.
  const std::vector<uint32_t>& Around(const Vec3& p) const {
    static const std::vector<uint32_t> kNone;
    const auto found = cells_.find(KeyOf(CellOf(p)));
    return found == cells_.end() ? kNone : found->second;
  }

 private:
  using Cell = Eigen::Vector3i;
  Cell CellOf(const Vec3& p) const { return (p / (2.0 * reach_m_)).array().floor().cast<int>(); }
  static int64_t KeyOf(const Cell& c) {
    constexpr int64_t kHalf = 1 << 20;
    return ((c.x() + kHalf) << 42) | ((c.y() + kHalf) << 21) | (c.z() + kHalf);
  }
  double reach_m_;
  std::unordered_map<int64_t, std::vector<uint32_t>> cells_;
};

struct LatticePlane {
  Vec3 origin, u, v;
};

/// Orthonormal axes in the plane through `p` with this normal: a function of the plane alone, up to rounding.
LatticePlane PlaneOf(const Vec3& p, const Vec3& normal) {
  // The horizontal direction in the plane; where the plane itself is all but horizontal, x laid down onto it.
  const bool level = std::abs(normal.z()) > 0.999;
  const Vec3 in_plane = level ? Vec3(Vec3::UnitX() - normal.x() * normal) : Vec3::UnitZ().cross(normal);
  const Vec3 along = in_plane.normalized();
  const Vec3 across = normal.cross(along);
  const double c = std::cos(std::atan(0.6180339887498949)), s = std::sin(std::atan(0.6180339887498949));
  return {normal * normal.dot(p), c * along + s * across, c * across - s * along};
}

/// Calls `visit(point)` for the lattice points within the triangle.
template <typename Visit>
void ForEachLatticePoint(const Vec3 corner[3], const LatticePlane& plane, double spacing,
                         const Visit& visit) {
  Vec2 q[3];
  for (int k = 0; k < 3; ++k) q[k] = Vec2(plane.u.dot(corner[k]), plane.v.dot(corner[k])) / spacing;
  const double v_min = std::min({q[0].y(), q[1].y(), q[2].y()}),
               v_max = std::max({q[0].y(), q[1].y(), q[2].y()});
  for (double row = std::ceil(v_min); row < v_max; row += 1.0) {
    double from = 1e300, to = -1e300;
    for (int k = 0; k < 3; ++k) {
      const Vec2 *a = &q[k], *b = &q[(k + 1) % 3];
      if (a->y() > b->y()) std::swap(a, b);
      if (!(a->y() <= row && row < b->y())) continue;
      const double u = a->x() + (row - a->y()) * (b->x() - a->x()) / (b->y() - a->y());
      from = std::min(from, u);
      to = std::max(to, u);
    }
    for (double column = std::ceil(from); column < to; column += 1.0) {
      visit(Vec3(plane.origin + spacing * (column * plane.u + row * plane.v)));
    }
  }
}

uint16_t PartIndex(GroundTruth& truth, const std::string& name) {
  for (size_t i = 0; i < truth.part_names.size(); ++i) {
    if (truth.part_names[i] == name) return static_cast<uint16_t>(i);
  }
  truth.part_names.push_back(name);
  truth.part_area_m2.push_back(0.0);
  return static_cast<uint16_t>(truth.part_names.size() - 1);
}

/// One connected piece of an object part.
struct Shell {
  core::TriMesh mesh;
  int solid = -1;      ///< its index in the solid test, or -1 where it is not watertight
  int part_index = 0;  ///< in the scene
};

bool IsExposed(const Vec3& p, const Vec3& normal, const SolidTest& solids, int own_solid) {
  const Vec3 before = p + kOffset_m * normal, behind = p - kOffset_m * normal;
  if (own_solid < 0) return !solids.IsInside(before) || !solids.IsInside(behind);  // a sheet has two sides
  if (solids.IsInside(before)) return false;
  return solids.Winding(behind) < 2 || solids.FirstShellAround(behind) == own_solid;
}

/// A triangle of the object, and what its points share.
struct Facet {
  Vec3 corner[3];
  Vec3 normal;
  double area_m2;
  int own_solid;
  uint16_t part;
};

void AddPoint(const Vec3& p, const Facet& facet, GroundTruth* truth) {
  truth->points.push_back(p.cast<float>());
  truth->normals.push_back(facet.normal.cast<float>());
  truth->two_sided.push_back(facet.own_solid < 0 ? 1 : 0);
  truth->part.push_back(facet.part);
}

void SampleFacet(const Facet& facet, const SolidTest& solids, double spacing_m, GroundTruth* truth) {
  size_t drawn = 0, kept = 0;
  ForEachLatticePoint(facet.corner, PlaneOf(facet.corner[0], facet.normal), spacing_m, [&](const Vec3& p) {
    ++drawn;
    if (!IsExposed(p, facet.normal, solids, facet.own_solid)) return;
    ++kept;
    AddPoint(p, facet, truth);
  });
  if (drawn == 0) {
    const Vec3 middle = (facet.corner[0] + facet.corner[1] + facet.corner[2]) / 3.0;
    drawn = 1;
    kept = IsExposed(middle, facet.normal, solids, facet.own_solid) ? 1 : 0;
  }
  truth->part_area_m2[facet.part] += facet.area_m2 * static_cast<double>(kept) / static_cast<double>(drawn);
}

/// Facets with a corner so near the opposite side may lie between the lines of the lattice.
bool IsNarrow(const Facet& facet, double spacing_m) {
  double longest = 0.0;
  for (int k = 0; k < 3; ++k)
    longest = std::max(longest, (facet.corner[(k + 1) % 3] - facet.corner[k]).norm());
  return 2.0 * facet.area_m2 < 2.0 * spacing_m * longest;
}

/// The middle of the facet, and points a little inside its sides.
std::vector<Vec3> Probes(const Facet& facet, double step_m) {
  const Vec3 middle = (facet.corner[0] + facet.corner[1] + facet.corner[2]) / 3.0;
  std::vector<Vec3> probes = {middle};
  for (int k = 0; k < 3; ++k) {
    const Vec3 &a = facet.corner[k], &b = facet.corner[(k + 1) % 3];
    const int steps = static_cast<int>((b - a).norm() / step_m);
    for (int i = 0; i < steps; ++i) {
      const Vec3 side = a + (i + 0.5) / steps * (b - a);
      probes.push_back(side + 0.02 * (middle - side));
    }
  }
  return probes;
}

/// Points of narrow facets that the lattice left more than a spacing from all truth (a leaf, the edge of a
/// sheet) become truth too.
void FillGaps(const std::vector<Facet>& facets, const SolidTest& solids, double spacing_m,
              GroundTruth* truth) {
  const double reach_m = 1.1 * spacing_m;
  ReachCells cells(reach_m);
  std::vector<Vec3> probes;
  std::vector<uint32_t> facet_of;
  for (uint32_t f = 0; f < facets.size(); ++f) {
    if (!IsNarrow(facets[f], spacing_m)) continue;
    for (const Vec3& p : Probes(facets[f], 0.5 * spacing_m)) {
      cells.Add(p, static_cast<uint32_t>(probes.size()));
      probes.push_back(p);
      facet_of.push_back(f);
    }
  }
  std::vector<uint8_t> done(probes.size(), 0);
  const auto meet = [&](const Vec3& q) {
    for (const uint32_t i : cells.Around(q)) done[i] |= (probes[i] - q).squaredNorm() <= reach_m * reach_m;
  };
  for (const core::Vec3f& q : truth->points) meet(q.cast<double>());
  for (uint32_t i = 0; i < probes.size(); ++i) {
    const Facet& facet = facets[facet_of[i]];
    if (done[i] != 0 || !IsExposed(probes[i], facet.normal, solids, facet.own_solid)) continue;
    AddPoint(probes[i], facet, truth);
    meet(probes[i]);
  }
}

/// Every piece of every part; the watertight ones are numbered as solids and turned to face outward. The
/// object's come first: where its surface and another's coincide, it counts.
std::vector<Shell> ShellsOf(const SceneSpec& scene) {
  std::vector<Shell> shells;
  int solids = 0;
  for (const bool object : {true, false}) {
    for (size_t i = 0; i < scene.parts.size(); ++i) {
      if (scene.parts[i].is_object != object) continue;
      for (core::TriMesh& mesh : SplitShells(scene.parts[i].mesh)) {
        Shell shell{std::move(mesh), -1, static_cast<int>(i)};
        if (IsWatertight(shell.mesh)) {
          shell.solid = solids++;
          if (SignedVolume(shell.mesh) < 0.0) TurnInsideOut(&shell.mesh);
        }
        shells.push_back(std::move(shell));
      }
    }
  }
  return shells;
}

}  // namespace

GroundTruth SampleGroundTruth(const SceneSpec& scene, double spacing_m) {
  const std::vector<Shell> shells = ShellsOf(scene);
  std::vector<const core::TriMesh*> watertight;
  for (const Shell& shell : shells) {
    if (shell.solid >= 0) watertight.push_back(&shell.mesh);
  }
  const SolidTest solids(watertight);
  GroundTruth truth;
  std::vector<Facet> facets;
  for (const Shell& shell : shells) {
    const ScenePart& part = scene.parts[static_cast<size_t>(shell.part_index)];
    if (!part.is_object) continue;
    const uint16_t index = PartIndex(truth, part.name);
    for (const auto& t : shell.mesh.triangles) {
      Facet facet{.corner = {}, .normal = {}, .area_m2 = 0.0, .own_solid = shell.solid, .part = index};
      for (int k = 0; k < 3; ++k) facet.corner[k] = shell.mesh.vertices[t[k]].cast<double>();
      facet.normal = (facet.corner[1] - facet.corner[0]).cross(facet.corner[2] - facet.corner[0]);
      facet.area_m2 = 0.5 * facet.normal.norm();
      if (!(facet.area_m2 > 1e-12)) continue;
      facet.normal /= 2.0 * facet.area_m2;
      facets.push_back(facet);
    }
  }
  for (const Facet& facet : facets) SampleFacet(facet, solids, spacing_m, &truth);
  FillGaps(facets, solids, spacing_m, &truth);
  return truth;
}

}  // namespace atlas::scenes
