#include "scenes/build/shapes.h"

#include <cassert>

#include "scenes/build/triangulate.h"

namespace atlas::scenes {
namespace {

using core::Pose;
using core::TriMesh;
using core::Vec2;
using core::Vec3;

uint32_t AddVertex(TriMesh& mesh, const Vec3& p) {
  mesh.vertices.push_back(p.cast<float>());
  return static_cast<uint32_t>(mesh.vertices.size() - 1);
}

void AddQuad(TriMesh& mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

/// Fan over one end ring; `first` is the ring's first vertex.
void CapRing(TriMesh& mesh, const Ring& ring, uint32_t first, bool reversed) {
  const auto n = static_cast<uint32_t>(ring.size());
  if (n <= 4) {
    for (uint32_t j = 1; j + 1 < n; ++j) {
      mesh.triangles.push_back({first, first + (reversed ? j + 1 : j), first + (reversed ? j : j + 1)});
    }
    return;
  }
  Vec3 centre = Vec3::Zero();
  for (const Vec3& p : ring) centre += p / n;
  const uint32_t hub = AddVertex(mesh, centre);
  for (uint32_t j = 0; j < n; ++j) {
    const uint32_t a = first + j, b = first + (j + 1) % n;
    mesh.triangles.push_back({hub, reversed ? b : a, reversed ? a : b});
  }
}

void FaceOutward(TriMesh& mesh) {
  if (VolumeM3(mesh) >= 0.0) return;
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
}

Ring Circle(double radius, double z, const Pose& T, int corners) {
  Ring ring;
  for (int j = 0; j < corners; ++j) {
    const double a = 2.0 * core::kPi * j / corners;
    ring.push_back(T * Vec3(radius * std::cos(a), radius * std::sin(a), z));
  }
  return ring;
}

/// Rings of a sphere cut at the equator and pulled apart by 2 * half_length: a sphere where that is zero.
TriMesh MakeRounded(double radius, double half_length, const Pose& T, int corners) {
  std::vector<Ring> rings;
  const int steps = std::max(corners / 2, 4) / 2 * 2;
  for (int i = 0; i <= steps; ++i) {
    // The poles are tiny flats, so that end rings keep distinct corners.
    const double latitude = core::kPi * (std::clamp(static_cast<double>(i) / steps, 0.002, 0.998) - 0.5);
    const double z = radius * std::sin(latitude), r = radius * std::cos(latitude);
    if (half_length > 0.0 && i == steps / 2) rings.push_back(Circle(r, z - half_length, T, corners));
    rings.push_back(Circle(r, z + (2 * i < steps ? -half_length : half_length), T, corners));
  }
  return MakeLoft(rings);
}

}  // namespace

double VolumeM3(const TriMesh& mesh) {
  if (mesh.vertices.empty()) return 0.0;
  const Vec3 origin = mesh.vertices[0].cast<double>();
  double volume = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]].cast<double>() - origin;
    const Vec3 b = mesh.vertices[t[1]].cast<double>() - origin;
    const Vec3 c = mesh.vertices[t[2]].cast<double>() - origin;
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

Pose PoseBetween(const Vec3& a, const Vec3& b) {
  const Vec3 axis = (b - a).normalized();
  return core::MakePose(Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), axis).toRotationMatrix(),
                        0.5 * (a + b));
}

TriMesh MakeLoft(const std::vector<Ring>& rings) {
  assert(rings.size() >= 2 && rings[0].size() >= 3);
  TriMesh mesh;
  const auto n = static_cast<uint32_t>(rings[0].size());
  for (const Ring& ring : rings) {
    assert(ring.size() == n);
    for (const Vec3& p : ring) AddVertex(mesh, p);
  }
  for (uint32_t i = 0; i + 1 < rings.size(); ++i) {
    for (uint32_t j = 0; j < n; ++j) {
      const uint32_t k = (j + 1) % n;
      AddQuad(mesh, i * n + j, i * n + k, (i + 1) * n + k, (i + 1) * n + j);
    }
  }
  CapRing(mesh, rings.front(), 0, true);
  CapRing(mesh, rings.back(), static_cast<uint32_t>(rings.size() - 1) * n, false);
  FaceOutward(mesh);
  return mesh;
}

TriMesh MakeBox(const Vec3& h, const Pose& T) {
  const auto ring = [&](double z) {
    return Ring{T * Vec3(-h.x(), -h.y(), z), T * Vec3(h.x(), -h.y(), z), T * Vec3(h.x(), h.y(), z),
                T * Vec3(-h.x(), h.y(), z)};
  };
  return MakeLoft({ring(-h.z()), ring(h.z())});
}

TriMesh MakeFrustum(double bottom_radius, double top_radius, double half_length, const Pose& T, int corners) {
  return MakeLoft({Circle(std::max(bottom_radius, 1e-3), -half_length, T, corners),
                   Circle(std::max(top_radius, 1e-3), half_length, T, corners)});
}

TriMesh MakeCylinder(double radius, double half_length, const Pose& T, int corners) {
  return MakeFrustum(radius, radius, half_length, T, corners);
}

TriMesh MakeSphere(double radius, const Pose& T, int corners) {
  return MakeRounded(radius, 0.0, T, corners);
}

TriMesh MakeCapsule(double radius, double half_length, const Pose& T, int corners) {
  return MakeRounded(radius, half_length, T, corners);
}

TriMesh MakeExtrusion(const std::vector<Vec2>& polygon, double z0, double z1, const Pose& T) {
  return MakeProfileLoft({polygon, polygon}, {z0, z1}, T);
}

TriMesh MakeProfileLoft(const std::vector<std::vector<Vec2>>& outlines, const std::vector<double>& z,
                        const Pose& T) {
  assert(outlines.size() == z.size() && z.size() >= 2);
  TriMesh mesh;
  const auto n = static_cast<uint32_t>(outlines[0].size()), last = static_cast<uint32_t>((z.size() - 1) * n);
  for (size_t k = 0; k < z.size(); ++k) {
    assert(outlines[k].size() == n);
    for (const Vec2& p : outlines[k]) AddVertex(mesh, T * Vec3(p.x(), p.y(), z[k]));
  }
  for (uint32_t base = 0; base < last; base += n) {
    for (uint32_t j = 0; j < n; ++j)
      AddQuad(mesh, base + j, base + (j + 1) % n, base + n + (j + 1) % n, base + n + j);
  }
  for (const auto& t : TriangulatePolygon(outlines.front())) mesh.triangles.push_back({t[0], t[2], t[1]});
  for (const auto& t : TriangulatePolygon(outlines.back())) {
    mesh.triangles.push_back({last + t[0], last + t[1], last + t[2]});
  }
  FaceOutward(mesh);
  return mesh;
}

TriMesh MakeTube(const std::vector<Vec3>& path, double radius, int corners) {
  assert(path.size() >= 2);
  std::vector<Ring> rings;
  core::Mat3 R = PoseBetween(path[0], path[1]).linear();
  for (size_t i = 0; i < path.size(); ++i) {
    const Vec3 in = (path[i] - path[i == 0 ? 0 : i - 1]).normalized();
    const Vec3 out = (path[std::min(i + 1, path.size() - 1)] - path[i]).normalized();
    const Vec3 before = i == 0 ? out : in, after = i + 1 == path.size() ? in : out;
    // The ring of the incoming bar, slid along that bar into the plane that halves the bend.
    const Vec3 mitre = (before + after).normalized();
    Ring ring = Circle(radius, 0.0, core::MakePose(R, path[i]), corners);
    for (Vec3& p : ring) p -= before * (mitre.dot(p - path[i]) / mitre.dot(before));
    rings.push_back(std::move(ring));
    R = Eigen::Quaterniond::FromTwoVectors(before, after).toRotationMatrix() * R;
  }
  return MakeLoft(rings);
}

TriMesh MakePanel(const Ring& corners, double proud, double depth) {
  assert(corners.size() == 4);
  const Vec3 normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]).normalized();
  Ring inner = corners, outer = corners;
  for (Vec3& p : inner) p -= depth * normal;
  for (Vec3& p : outer) p += proud * normal;
  return MakeLoft({inner, outer});
}

TriMesh MakeLoftPatch(const std::vector<Ring>& rings, int i0, int i1, int j0, int j1, double proud,
                      double depth) {
  const int n = static_cast<int>(rings[0].size()), last = static_cast<int>(rings.size()) - 1;
  const auto at = [&](int i, int j) -> const Vec3& {
    return rings[std::clamp(i, 0, last)][((j % n) + n) % n];
  };
  const Vec3 axis = rings.back()[0] - rings.front()[0];
  TriMesh mesh;
  const uint32_t columns = static_cast<uint32_t>(j1 - j0 + 1),
                 count = columns * static_cast<uint32_t>(i1 - i0 + 1);
  for (double offset : {-depth, proud}) {
    for (int i = i0; i <= i1; ++i) {
      Vec3 centre = Vec3::Zero();
      for (const Vec3& p : rings[std::clamp(i, 0, last)]) centre += p / n;
      for (int j = j0; j <= j1; ++j) {
        Vec3 normal = (at(i, j + 1) - at(i, j - 1)).cross(at(i + 1, j) - at(i - 1, j)).normalized();
        if (normal.dot(at(i, j) - centre - axis.normalized() * axis.normalized().dot(at(i, j) - centre)) <
            0) {
          normal = -normal;
        }
        AddVertex(mesh, at(i, j) + offset * normal);
      }
    }
  }
  const auto id = [&](int i, int j) { return static_cast<uint32_t>(i) * columns + static_cast<uint32_t>(j); };
  const int di = i1 - i0, dj = j1 - j0;
  for (int i = 0; i < di; ++i) {
    for (int j = 0; j < dj; ++j) {
      AddQuad(mesh, id(i, j), id(i, j + 1), id(i + 1, j + 1), id(i + 1, j));
      AddQuad(mesh, count + id(i, j), count + id(i + 1, j), count + id(i + 1, j + 1), count + id(i, j + 1));
    }
    AddQuad(mesh, id(i, 0), id(i + 1, 0), count + id(i + 1, 0), count + id(i, 0));
    AddQuad(mesh, id(i, dj), count + id(i, dj), count + id(i + 1, dj), id(i + 1, dj));
  }
  for (int j = 0; j < dj; ++j) {
    AddQuad(mesh, id(0, j), count + id(0, j), count + id(0, j + 1), id(0, j + 1));
    AddQuad(mesh, id(di, j), id(di, j + 1), count + id(di, j + 1), count + id(di, j));
  }
  FaceOutward(mesh);
  return mesh;
}

}  // namespace atlas::scenes
