#include "experiments/judge/scene_surface.h"

#include <cmath>

namespace atlas::experiments {
namespace {

using core::Box3;
using core::Vec3;
using core::Vec3f;

/// The part of a convex polygon with sign * (coordinate - bound) >= 0 along `axis`.
std::vector<Vec3> ClipHalfSpace(const std::vector<Vec3>& polygon, int axis, double bound, double sign) {
  std::vector<Vec3> inside;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = sign * (a[axis] - bound), db = sign * (b[axis] - bound);
    if (da >= 0.0) inside.push_back(a);
    if ((da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0)) inside.push_back(a + (da / (da - db)) * (b - a));
  }
  return inside;
}

/// Rows parallel to the longest edge, so that slivers cost what their area does.
void SampleTriangle(Vec3 a, Vec3 b, Vec3 c, double spacing_m, std::vector<Vec3f>* points) {
  for (int turn = 0; turn < 2 && (b - a).norm() < std::max((c - a).norm(), (c - b).norm()); ++turn) {
    std::swap(a, b);
    std::swap(b, c);
  }
  const double longest = (b - a).norm();
  const double height = longest > 0.0 ? (b - a).cross(c - a).norm() / longest : 0.0;
  const int rows = std::max(1, static_cast<int>(std::ceil(height / spacing_m)));
  for (int row = 0; row <= rows; ++row) {
    const double v = static_cast<double>(row) / rows;
    const Vec3 begin = a + v * (c - a), end = b + v * (c - b);
    const int columns = std::max(1, static_cast<int>(std::ceil((end - begin).norm() / spacing_m)));
    for (int column = 0; column <= columns; ++column) {
      points->push_back((begin + static_cast<double>(column) / columns * (end - begin)).cast<float>());
    }
  }
}

}  // namespace

std::vector<Vec3> ClipTriangle(const std::array<Vec3, 3>& triangle, const Box3& box) {
  std::vector<Vec3> polygon(triangle.begin(), triangle.end());
  for (int axis = 0; axis < 3 && !polygon.empty(); ++axis) {
    polygon = ClipHalfSpace(polygon, axis, box.min[axis], 1.0);
    polygon = ClipHalfSpace(polygon, axis, box.max[axis], -1.0);
  }
  return polygon;
}

std::vector<Vec3f> SampleBackground(const scenes::SceneSpec& scene, const Box3& box, double spacing_m) {
  std::vector<Vec3f> points;
  for (const scenes::ScenePart& part : scene.parts) {
    if (part.is_object) continue;
    for (const auto& t : part.mesh.triangles) {
      const std::vector<Vec3> polygon =
          ClipTriangle({part.mesh.vertices[t[0]].cast<double>(), part.mesh.vertices[t[1]].cast<double>(),
                        part.mesh.vertices[t[2]].cast<double>()},
                       box);
      for (size_t i = 2; i < polygon.size(); ++i) {
        SampleTriangle(polygon[0], polygon[i - 1], polygon[i], spacing_m, &points);
      }
    }
  }
  return points;
}

}  // namespace atlas::experiments
