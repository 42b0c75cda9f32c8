#include "scenes/town/relief.h"

#include "scenes/build/ground.h"
#include "scenes/build/smooth_way.h"

namespace atlas::scenes {
namespace {

using core::Vec2;
using core::Vec3;

Vec2 LeftOf(const Vec2& direction) {
  return {-direction.y(), direction.x()};
}

}  // namespace

Relief::Relief(const Rect& extent, double spacing_m, const std::function<double(double, double)>& height_at) {
  grid_.spacing_m = spacing_m;
  grid_.origin = extent.min;
  grid_.cols = static_cast<int>(std::lround((extent.max.x() - extent.min.x()) / spacing_m)) + 1;
  grid_.rows = static_cast<int>(std::lround((extent.max.y() - extent.min.y()) / spacing_m)) + 1;
  grid_.height_m.reserve(static_cast<size_t>(grid_.rows) * static_cast<size_t>(grid_.cols));
  for (int row = 0; row < grid_.rows; ++row) {
    for (int col = 0; col < grid_.cols; ++col) {
      const Vec2 p = grid_.origin + spacing_m * Vec2(col, row);
      grid_.height_m.push_back(static_cast<float>(height_at(p.x(), p.y())));
    }
  }
}

double Relief::HeightAt(double x, double y) const {
  const Vec2 at = (Vec2(x, y) - grid_.origin) / grid_.spacing_m;
  const double u = std::clamp(at.x(), 0.0, grid_.cols - 1.0), v = std::clamp(at.y(), 0.0, grid_.rows - 1.0);
  const int col = std::min(static_cast<int>(u), grid_.cols - 2),
            row = std::min(static_cast<int>(v), grid_.rows - 2);
  const auto z = [&](int dr, int dc) {
    return static_cast<double>(grid_.height_m[static_cast<size_t>(row + dr) * grid_.cols + col + dc]);
  };
  const double du = u - col, dv = v - row;
  return du >= dv ? z(0, 0) + du * (z(0, 1) - z(0, 0)) + dv * (z(1, 1) - z(0, 1))
                  : z(0, 0) + dv * (z(1, 0) - z(0, 0)) + du * (z(1, 1) - z(1, 0));
}

void Relief::AddTo(SceneBuilder& scene, const Paint& paint, double bottom_z) const {
  constexpr double kBed_m = 0.2;
  scene.Visual(paint, MakeHeightGridSolid(grid_, bottom_z));
  scene.Collide(paint, {grid_, core::Pose::Identity()});
  const Vec2 max = grid_.origin + grid_.spacing_m * Vec2(grid_.cols - 1, grid_.rows - 1);
  scene.Box({"bed", core::Label::kGround}, Vec3(grid_.origin.x(), grid_.origin.y(), bottom_z - kBed_m),
            Vec3(max.x(), max.y(), bottom_z), Physics::kNone);
}

void AddPath(SceneBuilder& scene, const Paint& paint, const Relief& ground, const std::vector<Vec2>& way,
             double width_m, double proud_m) {
  constexpr double kStep_m = 0.8, kThickness_m = 0.25;
  std::vector<Vec3> corners;
  for (const Vec2& p : way) corners.emplace_back(p.x(), p.y(), 0.0);
  std::vector<Vec2> curve;
  for (const Vec3& p : SmoothWay(corners, kStep_m)) curve.push_back(p.head<2>());
  std::vector<Ring> rings;
  for (size_t i = 0; i < curve.size(); ++i) {
    const Vec2 along = (curve[std::min(i + 1, curve.size() - 1)] - curve[i > 0 ? i - 1 : 0]).normalized();
    const Vec2 side = 0.5 * width_m * LeftOf(along);
    Ring ring;
    for (double share : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
      const Vec2 p = curve[i] + share * side;
      ring.push_back(ground.On(p.x(), p.y()) + Vec3(0, 0, proud_m));
    }
    const Vec3 down(0, 0, proud_m + kThickness_m);
    ring.push_back(ring[4] - down);
    ring.push_back(ring[0] - down);
    rings.push_back(ring);
  }
  scene.Visual(paint, MakeLoft(rings));
}

}  // namespace atlas::scenes
