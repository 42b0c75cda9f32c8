// The uniform cloud of an object's exposed surfaces that coverage is scored against (thesis Eq. 3.9).
//
// Each triangle carries the points of a square lattice in its plane. The lattice is anchored at the map's
// origin, so coplanar triangles share it, and is turned by an angle of irrational slope, so that strips
// narrower than the spacing get their share of points too. A point stays when a millimetre before it no solid
// fills the space.
#include "scenes/catalog.h"
#include "scenes/solid_test.h"

namespace atlas::scenes {
namespace {

using core::Vec2;
using core::Vec3;

constexpr double kOffset_m = 1e-3;

struct LatticePlane {
  Vec3 origin, u, v;
};

/// Axes of the plane through `p` with this normal: a function of the plane alone, up to rounding.
LatticePlane PlaneOf(const Vec3& p, const Vec3& normal) {
  const Vec3 along = std::abs(normal.z()) > 0.999 ? Vec3::UnitX() : Vec3::UnitZ().cross(normal).normalized();
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
  if (solids.IsInside(p + kOffset_m * normal)) return false;
  const Vec3 behind = p - kOffset_m * normal;
  return own_solid < 0 || solids.Winding(behind) < 2 || solids.FirstShellAround(behind) == own_solid;
}

void SampleTriangle(const Vec3 corner[3], const SolidTest& solids, int own_solid, double spacing_m,
                    uint16_t part, GroundTruth& truth) {
  const Vec3 doubled_area = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  const double area = 0.5 * doubled_area.norm();
  if (!(area > 1e-12)) return;
  const Vec3 normal = doubled_area / (2.0 * area);
  size_t drawn = 0, kept = 0;
  ForEachLatticePoint(corner, PlaneOf(corner[0], normal), spacing_m, [&](const Vec3& p) {
    ++drawn;
    if (!IsExposed(p, normal, solids, own_solid)) return;
    ++kept;
    truth.points.push_back(p.cast<float>());
    truth.normals.push_back(normal.cast<float>());
    truth.part.push_back(part);
  });
  if (drawn == 0) {
    const Vec3 middle = (corner[0] + corner[1] + corner[2]) / 3.0;
    drawn = 1;
    kept = IsExposed(middle, normal, solids, own_solid) ? 1 : 0;
  }
  truth.part_area_m2[part] += area * static_cast<double>(kept) / static_cast<double>(drawn);
}

/// Every piece of every part; the watertight ones are numbered as solids.
std::vector<Shell> ShellsOf(const SceneSpec& scene) {
  std::vector<Shell> shells;
  int solids = 0;
  for (size_t i = 0; i < scene.parts.size(); ++i) {
    for (core::TriMesh& mesh : SplitShells(scene.parts[i].mesh)) {
      Shell shell{std::move(mesh), -1, static_cast<int>(i)};
      if (IsWatertight(shell.mesh)) shell.solid = solids++;
      shells.push_back(std::move(shell));
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
  for (const Shell& shell : shells) {
    const ScenePart& part = scene.parts[static_cast<size_t>(shell.part_index)];
    if (!part.is_object) continue;
    const uint16_t index = PartIndex(truth, part.name);
    for (const auto& t : shell.mesh.triangles) {
      Vec3 corner[3];
      for (int k = 0; k < 3; ++k) corner[k] = shell.mesh.vertices[t[k]].cast<double>();
      SampleTriangle(corner, solids, shell.solid, spacing_m, index, truth);
    }
  }
  return truth;
}

}  // namespace atlas::scenes
