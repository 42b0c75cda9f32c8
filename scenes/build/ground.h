// Ground to walk on.
#pragma once

#include "scenes/build/openings.h"
#include "scenes/build/scene_builder.h"

namespace atlas::scenes {

/// A slab whose top is z = 0.
void AddFlatGround(SceneBuilder& scene, const Rect& extent, core::Label label = core::Label::kGround);

/// Smooth random bumps of about +-`amplitude_m` in two wavelengths (0.9 m and 0.4 m), flat within 0.7 m of
/// `flat`. Sampled every 12.5 cm; rays and feet meet the same grid.
void AddRoughGrass(SceneBuilder& scene, const Rect& extent, double amplitude_m, const core::Vec2& flat);

/// The closed solid under a grid of heights, down to z = `bottom`: two triangles a cell, split from its
/// low-row low-column corner to the opposite one.
core::TriMesh MakeHeightGridSolid(const HeightGridShape& grid, double bottom);

}  // namespace atlas::scenes
