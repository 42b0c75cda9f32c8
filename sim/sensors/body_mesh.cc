#include "sim/sensors/body_mesh.h"

namespace atlas::sim {
namespace {

double SquaredDistanceToSegment(const core::Vec3& p, const core::Vec3& a, const core::Vec3& b) {
  const core::Vec3 ab = b - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp(ab.dot(p - a) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * ab).squaredNorm();
}

}  // namespace

double SquaredDistanceToTriangle(const core::Vec3& p, const core::Vec3& a, const core::Vec3& b,
                                 const core::Vec3& c) {
  const core::Vec3 n = (b - a).cross(c - a);
  const double n2 = n.squaredNorm();
  // The foot of the perpendicular is inside where it lies left of all three edges.
  const bool inside = n2 > 0.0 && n.dot((b - a).cross(p - a)) >= 0.0 && n.dot((c - b).cross(p - b)) >= 0.0 &&
                      n.dot((a - c).cross(p - c)) >= 0.0;
  if (inside) {
    const double height = n.dot(p - a);
    return height * height / n2;
  }
  return std::min({SquaredDistanceToSegment(p, a, b), SquaredDistanceToSegment(p, b, c),
                   SquaredDistanceToSegment(p, c, a)});
}

BodyMesh::BodyMesh(const core::TriMesh& mesh_body) : mesh_(mesh_body), bounds_body_(mesh_body.Bounds()) {}

bool BodyMesh::IsWithin(const core::Vec3& p_map, double margin_m) const {
  const core::Vec3 p = T_body_map_ * p_map;
  if (bounds_body_.Empty() || bounds_body_.DistanceTo(p) > margin_m) return false;
  const auto vertex = [this](uint32_t i) -> core::Vec3 { return mesh_.vertices[i].cast<double>(); };
  for (const auto& t : mesh_.triangles) {
    if (SquaredDistanceToTriangle(p, vertex(t[0]), vertex(t[1]), vertex(t[2])) <= margin_m * margin_m) {
      return true;
    }
  }
  return false;
}

double BodyMesh::Reach(const core::Vec3& p_map) const {
  if (bounds_body_.Empty()) return 0.0;
  const core::Vec3 p = T_body_map_ * p_map;
  const core::Vec3 farthest = (p - bounds_body_.min).cwiseAbs().cwiseMax((bounds_body_.max - p).cwiseAbs());
  return farthest.norm();
}

}  // namespace atlas::sim
