#include "scenes/build/rough_rock.h"

#include <cmath>

#include "core/rng.h"

namespace atlas::scenes {
namespace {

using core::Vec2;
using core::Vec3;

constexpr double kFacet_m = 0.35;  ///< between corners of a face

double LatticeValue(int64_t i, int64_t j, int64_t k, uint64_t seed) {
  const auto index = static_cast<uint64_t>((i * 1000003 + j) * 1000003 + k);
  return 2.0 * core::UniformAt(seed, index) - 1.0;
}

struct Corner {
  Vec2 p, inward;
};

/// Corners along the rim of a rectangle, counter-clockwise, and which way is in.
std::vector<Corner> RimOf(const Rect& plan) {
  const Vec2 corners[] = {plan.min, {plan.max.x(), plan.min.y()}, plan.max, {plan.min.x(), plan.max.y()}};
  std::vector<Corner> rim;
  for (int side = 0; side < 4; ++side) {
    const Vec2 a = corners[side], b = corners[(side + 1) % 4], along = (b - a).normalized();
    const Vec2 before = (a - corners[(side + 3) % 4]).normalized();
    const auto left = [](const Vec2& v) { return Vec2(-v.y(), v.x()); };
    const int steps = std::max(1, static_cast<int>(std::lround((b - a).norm() / kFacet_m)));
    for (int k = 0; k < steps; ++k) {
      const Vec2 inward = k == 0 ? Vec2(left(along) + left(before)) : left(along);
      rim.push_back({a + (b - a) * (static_cast<double>(k) / steps), inward});
    }
  }
  return rim;
}

}  // namespace

double RockNoise(const Vec3& p, double wavelength_m, uint64_t seed) {
  const Vec3 at = p / wavelength_m, low = at.array().floor(), u = at - low;
  const Vec3 s = u.array() * u.array() * (3.0 - 2.0 * u.array());
  const auto i = static_cast<int64_t>(low.x()), j = static_cast<int64_t>(low.y()),
             k = static_cast<int64_t>(low.z());
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const int a = corner & 1, b = corner >> 1 & 1, c = corner >> 2 & 1;
    const double weight = (a ? s.x() : 1.0 - s.x()) * (b ? s.y() : 1.0 - s.y()) * (c ? s.z() : 1.0 - s.z());
    sum += weight * LatticeValue(i + a, j + b, k + c, seed);
  }
  return sum;
}

void AddRockBlock(SceneBuilder& scene, const Paint& paint, const Rect& plan, double z0, double z1,
                  uint64_t seed) {
  const std::vector<Corner> rim = RimOf(plan);
  const int levels = std::max(2, static_cast<int>(std::lround((z1 - z0) / kFacet_m)));
  std::vector<Ring> rings;
  for (int level = 0; level <= levels; ++level) {
    const double z = z0 + (z1 - z0) * level / levels;
    Ring ring;
    for (const Corner& corner : rim) {
      const Vec3 p(corner.p.x(), corner.p.y(), z);
      const double noise = 0.6 * RockNoise(p, 1.3, seed) + 0.4 * RockNoise(p, 0.45, seed + 1);
      const double depth = level == 0 || level == levels ? 0.0 : kHewn_m * 0.5 * (1.0 + noise);
      ring.emplace_back(p + Vec3(corner.inward.x(), corner.inward.y(), 0.0) * depth);
    }
    rings.push_back(ring);
  }
  scene.Visual(paint, MakeLoft(rings));
  const Vec2 half = 0.5 * (plan.max - plan.min) - Vec2(kHewn_m, kHewn_m),
             middle = 0.5 * (plan.min + plan.max);
  if (z0 >= kReachHeight_m || half.minCoeff() <= 0.0) return;
  scene.Collide(paint, {BoxShape{Vec3(half.x(), half.y(), 0.5 * (z1 - z0))},
                        At(Vec3(middle.x(), middle.y(), 0.5 * (z0 + z1)))});
}

core::TriMesh Overturned(const core::TriMesh& mesh) {
  core::TriMesh turned = mesh;
  for (auto& vertex : turned.vertices) vertex.z() = -vertex.z();
  for (auto& triangle : turned.triangles) std::swap(triangle[1], triangle[2]);
  return turned;
}

}  // namespace atlas::scenes
