// Shapes that explain a run: voxels, paths, arrows.
#pragma once

#include <vector>

#include "sim/render/colored_mesh.h"

namespace atlas::experiments {

/// Cubes of edge `resolution_m` about `centers` (which lie on a grid), without the faces between neighbours.
/// Colour runs from blue at `low_m` to red at `high_m`.
sim::ColoredMesh VoxelMesh(const std::vector<core::Vec3f>& centers, double resolution_m, double low_m,
                           double high_m);

/// A six-sided tube along `points`. Fewer than two give an empty mesh.
sim::ColoredMesh TubeMesh(const std::vector<core::Vec3>& points, double radius_m, const sim::Rgb& rgb);

/// A disc on the ground and, above it, an arrow along x.
sim::ColoredMesh ViewMarkerMesh(const sim::Rgb& rgb);

/// Blue, green, yellow, red for u from 0 to 1.
sim::Rgb HeightColor(double u);

}  // namespace atlas::experiments
