// Triangle meshes and point clouds, and the files they travel in.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/geometry.h"

namespace atlas::core {

/// Triangle soup with shared vertices; counter-clockwise seen from outside.
struct TriMesh {
  std::vector<Vec3f> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;

  void Append(const TriMesh& other);
  void Transform(const Pose& T);
  Box3 Bounds() const;
  double AreaM2() const;
};

struct PointCloud {
  std::vector<Vec3f> points;
};

/// Writes binary PLY, whole or not at all. @throws InputError when the path cannot be written.
void WritePly(const std::filesystem::path& path, const PointCloud& cloud);
void WritePly(const std::filesystem::path& path, const TriMesh& mesh);

/// The first point of each cell of a grid with this spacing, in input order.
PointCloud DownsampleFirst(const PointCloud& cloud, double spacing_m);

}  // namespace atlas::core
