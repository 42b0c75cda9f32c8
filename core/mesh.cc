#include "core/mesh.h"

#include <fmt/format.h>

#include <cstring>
#include <string>
#include <unordered_set>

#include "core/files.h"

namespace atlas::core {
namespace {

void AppendBytes(std::string& out, const void* data, size_t size) {
  out.append(static_cast<const char*>(data), size);
}

}  // namespace

void TriMesh::Append(const TriMesh& other) {
  const auto base = static_cast<uint32_t>(vertices.size());
  vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& t : other.triangles) triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

void TriMesh::Transform(const Pose& T) {
  const Eigen::Isometry3f Tf = T.cast<float>();
  for (Vec3f& v : vertices) v = Tf * v;
}

Box3 TriMesh::Bounds() const {
  Box3 box;
  for (const Vec3f& v : vertices) box.Extend(v.cast<double>());
  return box;
}

double TriMesh::AreaM2() const {
  double area = 0.0;
  for (const auto& t : triangles) {
    const Vec3 a = vertices[t[0]].cast<double>(), b = vertices[t[1]].cast<double>(),
               c = vertices[t[2]].cast<double>();
    area += 0.5 * (b - a).cross(c - a).norm();
  }
  return area;
}

void WritePly(const std::filesystem::path& path, const PointCloud& cloud) {
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n",
      cloud.points.size());
  for (const Vec3f& p : cloud.points) AppendBytes(out, p.data(), 12);
  WriteFileAtomically(path, out);
}

void WritePly(const std::filesystem::path& path, const TriMesh& mesh) {
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
      mesh.vertices.size(), mesh.triangles.size());
  for (const Vec3f& p : mesh.vertices) AppendBytes(out, p.data(), 12);
  for (const auto& t : mesh.triangles) {
    out.push_back(3);
    AppendBytes(out, t.data(), 12);
  }
  WriteFileAtomically(path, out);
}

PointCloud DownsampleFirst(const PointCloud& cloud, double spacing_m) {
  const double inverse = 1.0 / spacing_m;
  std::unordered_set<uint64_t> seen;
  seen.reserve(cloud.points.size());
  PointCloud out;
  for (const Vec3f& p : cloud.points) {
    uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<int64_t>(std::floor(static_cast<double>(p[axis]) * inverse));
      key = (key << 21) | (static_cast<uint64_t>(cell + (1 << 20)) & 0x1fffff);
    }
    if (seen.insert(key).second) out.points.push_back(p);
  }
  return out;
}

}  // namespace atlas::core
