// Gently rolling ground, and paths that lie on it.
#pragma once

#include <functional>
#include <vector>

#include "scenes/build/openings.h"
#include "scenes/build/scene_builder.h"

namespace atlas::scenes {

/// Ground given by a height function, seen and felt as the triangles over a square grid.
class Relief {
 public:
  /// Samples `height_at(x, y)` over `extent` every `spacing_m`.
  Relief(const Rect& extent, double spacing_m, const std::function<double(double, double)>& height_at);

  /// Height of the triangles at (x, y), clamped to the extent.
  double HeightAt(double x, double y) const;
  core::Vec3 On(double x, double y) const { return {x, y, HeightAt(x, y)}; }

  /// The closed solid down to `bottom_z`, on a bed that buries its underside.
  void AddTo(SceneBuilder& scene, const Paint& paint, double bottom_z) const;

 private:
  HeightGridShape grid_;
};

/// A paved strip along a polyline, `proud_m` above the ground at its middle and rims, without physics: lower
/// than a foot's clearance. Corners are rounded by sampling a smooth curve through `way`.
void AddPath(SceneBuilder& scene, const Paint& paint, const Relief& ground,
             const std::vector<core::Vec2>& way, double width_m, double proud_m = 0.03);

}  // namespace atlas::scenes
