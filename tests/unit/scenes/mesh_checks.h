// What closed, outward-facing meshes must satisfy, checked without the code under test.
#pragma once

#include <map>
#include <utility>

#include "core/mesh.h"

namespace atlas::scenes {

/// Directed edges that are not met by exactly one opposite edge of the same two vertices.
inline int UnpairedEdges(const core::TriMesh& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> count;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++count[{t[k], t[(k + 1) % 3]}];
  }
  int unpaired = 0;
  for (const auto& [edge, times] : count) {
    const auto opposite = count.find({edge.second, edge.first});
    if (times != 1 || opposite == count.end() || opposite->second != 1) ++unpaired;
  }
  return unpaired;
}

/// What a triangle adds to the volume by the divergence theorem with the field (x, 0, 0).
inline double FluxOf(const core::Vec3& a, const core::Vec3& b, const core::Vec3& c) {
  return (a.x() + b.x() + c.x()) / 3.0 * 0.5 * (b - a).cross(c - a).x();
}

/// Volume by the divergence theorem with the field (x, 0, 0).
inline double VolumeByFlux(const core::TriMesh& mesh) {
  double volume = 0.0;
  for (const auto& t : mesh.triangles) {
    const core::Vec3 a = mesh.vertices[t[0]].cast<double>(), b = mesh.vertices[t[1]].cast<double>(),
                     c = mesh.vertices[t[2]].cast<double>();
    volume += FluxOf(a, b, c);
  }
  return volume;
}

/// Volume of each connected shell (by shared vertex indices), smallest first in the sense of `min`.
inline double LeastShellVolume(const core::TriMesh& mesh) {
  std::vector<uint32_t> root(mesh.vertices.size());
  for (uint32_t i = 0; i < root.size(); ++i) root[i] = i;
  const auto find = [&](uint32_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const auto& t : mesh.triangles) {
    root[find(t[0])] = find(t[1]);
    root[find(t[1])] = find(t[2]);
  }
  std::map<uint32_t, double> volume;
  for (const auto& t : mesh.triangles) {
    const core::Vec3 a = mesh.vertices[t[0]].cast<double>(), b = mesh.vertices[t[1]].cast<double>(),
                     c = mesh.vertices[t[2]].cast<double>();
    volume[find(t[0])] += FluxOf(a, b, c);
  }
  double least = 1e300;
  for (const auto& [id, cubic_metres] : volume) least = std::min(least, cubic_metres);
  return least;
}

}  // namespace atlas::scenes
