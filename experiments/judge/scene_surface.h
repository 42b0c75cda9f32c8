// Samples of a scene's surfaces that are not the object: what a measured point may lie on besides.
#pragma once

#include <array>
#include <vector>

#include "core/geometry.h"
#include "scenes/scene_spec.h"

namespace atlas::experiments {

/// Points on the triangles of all parts with is_object == false, inside `box`, on a grid of about `spacing_m`
/// in each triangle (corners and edges included). Deterministic.
std::vector<core::Vec3f> SampleBackground(const scenes::SceneSpec& scene, const core::Box3& box,
                                          double spacing_m);

/// The polygon of `triangle` inside `box` (at most nine corners); empty where they are apart.
std::vector<core::Vec3> ClipTriangle(const std::array<core::Vec3, 3>& triangle, const core::Box3& box);

}  // namespace atlas::experiments
