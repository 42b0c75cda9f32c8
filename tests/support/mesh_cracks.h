// Is a mesh of an octree whole? Judged from the triangles and the observed voxels alone.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "core/mesh.h"
#include "mapping/octree/octree.h"

namespace atlas::tests {

struct MeshFaults {
  size_t cracks = 0;        ///< edges with one triangle though all voxels around are observed
  size_t crowded = 0;       ///< edges with three triangles or more
  size_t flipped = 0;       ///< edges that two triangles run along in the same direction
  size_t degenerate = 0;    ///< triangles with a vertex twice or without area
  size_t duplicate = 0;     ///< triangles of the same three vertices
  size_t unused = 0;        ///< vertices without a triangle
  size_t border_edges = 0;  ///< edges with one triangle where observed space ends: no fault
  bool None() const { return cracks + crowded + flipped + degenerate + duplicate + unused == 0; }
};

/// True where all voxels are known whose centres are the corners of the cells that touch `p`.
template <typename Field>
bool ObservedAround(const mapping::Octree<Field>& map, const core::Vec3& p) {
  constexpr double kTouch = 1e-3;  // voxels
  const core::Vec3 q = p / map.resolution_m() - core::Vec3::Constant(0.5);
  const auto floors = [&](double shift) { return (q.array() + shift).floor().template cast<int>().eval(); };
  const auto low = floors(-kTouch), high = floors(kTouch);
  for (int z = low.z(); z <= high.z() + 1; ++z) {
    for (int y = low.y(); y <= high.y() + 1; ++y) {
      for (int x = low.x(); x <= high.x() + 1; ++x) {
        if (!Field::Known(map.At(mapping::NodeKey{x, y, z}))) return false;
      }
    }
  }
  return true;
}

/// @pre vertices lie on the zero level (MeshOptions::undo_shift off).
template <typename Field>
MeshFaults FindFaults(const core::TriMesh& mesh, const mapping::Octree<Field>& map) {
  MeshFaults faults;
  std::map<std::pair<uint32_t, uint32_t>, std::array<int, 2>> uses;  // along and against
  std::vector<std::array<uint32_t, 3>> sorted;
  std::vector<bool> used(mesh.vertices.size(), false);
  for (const auto& t : mesh.triangles) {
    const core::Vec3f &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    faults.degenerate += !((b - a).cross(c - a).norm() > 0.0f);
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t from = t[k], to = t[(k + 1) % 3];
      used[from] = true;
      ++uses[std::minmax(from, to)][from < to ? 0 : 1];
    }
    sorted.push_back(t);
    std::sort(sorted.back().begin(), sorted.back().end());
  }
  for (const auto& [edge, count] : uses) {
    const int sum = count[0] + count[1];
    faults.crowded += sum > 2;
    faults.flipped += sum == 2 && count[0] != 1;
    if (sum != 1) continue;
    const core::Vec3 middle =
        (0.5f * (mesh.vertices[edge.first] + mesh.vertices[edge.second])).template cast<double>();
    ++(ObservedAround(map, middle) ? faults.cracks : faults.border_edges);
  }
  std::sort(sorted.begin(), sorted.end());
  for (size_t i = 1; i < sorted.size(); ++i) faults.duplicate += sorted[i] == sorted[i - 1];
  faults.unused = static_cast<size_t>(std::count(used.begin(), used.end(), false));
  return faults;
}

/// Area-weighted distances of a mesh's points to a shape.
struct MeshError {
  double mean_m = 0.0, bias_m = 0.0, worst_m = 0.0;
};
template <typename Shape>
MeshError ErrorOf(const core::TriMesh& mesh, const Shape& shape) {
  MeshError error;
  double area = 0.0;
  for (const auto& t : mesh.triangles) {
    const core::Vec3 a = mesh.vertices[t[0]].cast<double>(), b = mesh.vertices[t[1]].cast<double>(),
                     c = mesh.vertices[t[2]].cast<double>();
    const double w = (b - a).cross(c - a).norm() / 8.0;
    for (const core::Vec3& p : {core::Vec3((a + b + c) / 3.0), core::Vec3(0.5 * (a + b)),
                                core::Vec3(0.5 * (b + c)), core::Vec3(0.5 * (c + a))}) {
      const double d = shape.Distance(p);
      error.mean_m += w * std::abs(d);
      error.bias_m += w * d;
      error.worst_m = std::max(error.worst_m, std::abs(d));
      area += w;
    }
  }
  if (area > 0.0) {
    error.mean_m /= area;
    error.bias_m /= area;
  }
  return error;
}

}  // namespace atlas::tests
