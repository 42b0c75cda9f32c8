// Clouds of points drawn on rectangles by formula: what a registration is asked about, made without rays.
#pragma once

#include <vector>

#include "core/geometry.h"
#include "core/rng.h"

namespace atlas::tests {

/// A rectangle: corner and two sides.
struct SampledRectangle {
  core::Vec3 corner, u, v;
};

inline void AddBoxSides(const core::Box3& box, bool with_ends, std::vector<SampledRectangle>* out) {
  const core::Vec3 s = box.Size();
  const core::Vec3 x(s.x(), 0, 0), y(0, s.y(), 0), z(0, 0, s.z());
  out->push_back({box.min, x, y});
  out->push_back({box.min + z, x, y});
  out->push_back({box.min, x, z});
  out->push_back({box.min + y, x, z});
  if (!with_ends) return;
  out->push_back({box.min, y, z});
  out->push_back({box.min + x, y, z});
}

/// `per_m2` points a square metre with normal noise of `sigma_m` on each axis, as seen from a frame in which
/// the rectangles' frame is `T_here_world`.
inline std::vector<core::Vec3f> SampleRectangles(const std::vector<SampledRectangle>& rectangles,
                                                 double per_m2, double sigma_m,
                                                 const core::Pose& T_here_world, core::Rng* rng) {
  std::vector<core::Vec3f> points;
  for (const SampledRectangle& r : rectangles) {
    const auto count = static_cast<int>(per_m2 * r.u.cross(r.v).norm());
    for (int i = 0; i < count; ++i) {
      const core::Vec3 noise(rng->Normal(), rng->Normal(), rng->Normal());
      const core::Vec3 p = r.corner + rng->Uniform() * r.u + rng->Uniform() * r.v + sigma_m * noise;
      points.push_back((T_here_world * p).cast<float>());
    }
  }
  return points;
}

/// A room of 6 x 4 x 2.7 m with a cupboard and a table; no symmetry.
inline std::vector<SampledRectangle> SampledFurnishedRoom() {
  std::vector<SampledRectangle> room;
  AddBoxSides({{-2.5, -1.8, 0.0}, {3.5, 2.2, 2.7}}, true, &room);
  AddBoxSides({{2.4, 1.6, 0.0}, {3.5, 2.2, 2.0}}, true, &room);
  AddBoxSides({{-1.6, -1.4, 0.0}, {-0.7, -0.2, 0.8}}, true, &room);
  return room;
}

}  // namespace atlas::tests
