// Hewn rock: blocks whose faces are rough.
#pragma once

#include <cstdint>

#include "scenes/build/openings.h"
#include "scenes/build/scene_builder.h"

namespace atlas::scenes {

/// Smooth noise in [-1, 1] that varies over about `wavelength_m`.
double RockNoise(const core::Vec3& p, double wavelength_m, uint64_t seed);

/// Depth to which a face may be hewn.
constexpr double kHewn_m = 0.28;

/// A block over `plan` from z0 to z1, its sides hewn up to kHewn_m deep, never proud of the plan; foot and
/// top are flat and meant to be buried. Physics is the block without what may be hewn.
void AddRockBlock(SceneBuilder& scene, const Paint& paint, const Rect& plan, double z0, double z1,
                  uint64_t seed);

/// The mirror image below z = 0, faces outward again: a floor becomes a roof.
core::TriMesh Overturned(const core::TriMesh& mesh);

}  // namespace atlas::scenes
