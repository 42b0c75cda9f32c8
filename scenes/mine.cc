// A mine of 68 x 48 m: rooms and pillars hewn from the rock, doorways 1.5 m wide between them, roofs and
// walls rough.
//
// After the underground network in which the thesis plans (4.10.8, Corsham). Drifts run every 10 m along x
// and y between pillars 5.4 to 6.6 m wide; the plan tells which of their 58 stretches are open, have a
// doorway, or were left shut. The ways from corner to corner lead through doorways, and there are loops. All
// of the rock's faces are to be mapped.
#include <array>
#include <string_view>

#include "core/rng.h"
#include "scenes/build/ground.h"
#include "scenes/build/rough_rock.h"
#include "scenes/scenes.h"
#include "scenes/town/relief.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Vec2;
using core::Vec3;

constexpr double kPitch_m = 10.0, kRock_m = 2.0, kDoorWidth_m = 1.5, kDoorTop_m = 2.1, kStopping_m = 1.2;
constexpr double kFoot_m = -0.5, kRoof_m = 3.0, kRoofRough_m = 0.3, kFloorRough_m = 0.04, kTop_m = 3.7;
constexpr double kInnerX_m = 32.0, kInnerY_m = 22.0;
constexpr int kDriftsX = 7, kDriftsY = 5;
constexpr uint64_t kRockSeed = 410008;

const Paint kRock{"rock", Label::kRock, true}, kMineRoof{"roof", Label::kRock, true},
    kMineFloor{"floor", Label::kGround, true};

/// Stretches of drifts: - open, d a doorway, x shut. Rows from north to south; along x those between
/// neighbours in a row, along y those from each row to the one below.
constexpr std::array<std::string_view, kDriftsY> kAlongX = {"dd-dxx", "-xdxx-", "x---x-", "ddxdxx", "xd-dd-"};
constexpr std::array<std::string_view, kDriftsY - 1> kAlongY = {"x--dxd-", "---x-d-", "xdxddd-", "d-x-xx-"};

Vec2 Crossing(int i, int j) {
  return {kPitch_m * (i - (kDriftsX - 1) / 2), kPitch_m * (j - (kDriftsY - 1) / 2)};
}

class MineBuilder {
 public:
  explicit MineBuilder(SceneBuilder* scene) : scene_(*scene), rng_(kRockSeed) {}

  void AddPillars() {
    for (int i = 0; i + 1 < kDriftsX; ++i) {
      for (int j = 0; j + 1 < kDriftsY; ++j) {
        const Vec2 middle = Crossing(i, j) + 0.5 * Vec2(kPitch_m, kPitch_m);
        const Vec2 half(rng_.Uniform(2.7, 3.3), rng_.Uniform(2.7, 3.3));
        Block({middle - half, middle + half}, kFoot_m, kTop_m);
      }
    }
  }

  void AddStoppings() {
    for (int j = 0; j < kDriftsY; ++j) {
      for (int i = 0; i + 1 < kDriftsX; ++i) {
        Stop(Crossing(i, j) + Vec2(0.5 * kPitch_m, 0.0), false, kAlongX[kDriftsY - 1 - j][i], j == 0,
             j == kDriftsY - 1);
      }
    }
    for (int j = 0; j + 1 < kDriftsY; ++j) {
      for (int i = 0; i < kDriftsX; ++i) {
        Stop(Crossing(i, j) + Vec2(0.0, 0.5 * kPitch_m), true, kAlongY[kDriftsY - 2 - j][i], i == 0,
             i == kDriftsX - 1);
      }
    }
  }

  void AddRim() {
    const double x = kInnerX_m, y = kInnerY_m, d = kRock_m;
    Block({{-x - d, -y - d}, {x + d, -y}}, kFoot_m, kTop_m);
    Block({{-x - d, y}, {x + d, y + d}}, kFoot_m, kTop_m);
    Block({{-x - d, -y - 0.4}, {-x, y + 0.4}}, kFoot_m, kTop_m);
    Block({{x, -y - 0.4}, {x + d, y + 0.4}}, kFoot_m, kTop_m);
  }

 private:
  void Block(const Rect& plan, double z0, double z1) {
    AddRockBlock(scene_, kRock, plan, z0, z1, static_cast<uint64_t>(rng_.UniformInt(1 << 30)));
  }

  /// Shuts the stretch of a drift about `middle`, or leaves a doorway. A drift along the rim ends at the rim.
  void Stop(const Vec2& middle, bool along_y, char kind, bool rim_below, bool rim_above) {
    if (kind == '-') return;
    // Across the drift, from the pillar (or the rim) on one side to that on the other, well into both.
    const double low = rim_below ? -2.6 : -3.0, high = rim_above ? 2.6 : 3.0, half = 0.5 * kStopping_m;
    const auto wall = [&](double from, double to, double z0, double z1) {
      const Vec2 a(-half, from), b(half, to);
      const auto turned = [&](const Vec2& p) { return along_y ? Vec2(p.y(), p.x()) : p; };
      Block({middle + turned(a), middle + turned(b)}, z0, z1);
    };
    if (kind == 'x') return wall(low, high, kFoot_m, kTop_m);
    const double off = rng_.Uniform(-0.3, 0.3), door = 0.5 * kDoorWidth_m;
    wall(low, off - door, kFoot_m, kTop_m);
    wall(off + door, high, kFoot_m, kTop_m);
    wall(off - door - 0.4, off + door + 0.4, kDoorTop_m, kTop_m);
  }

  SceneBuilder& scene_;
  core::Rng rng_;
};

void AddFloorAndRoof(SceneBuilder& scene, const Vec2& spawn) {
  const double x = kInnerX_m + kRock_m, y = kInnerY_m + kRock_m;
  const Rect extent{{-x, -y}, {x, y}};
  const Relief floor(extent, 0.5, [&](double u, double v) {
    const double fade = std::clamp((Vec2(u, v) - spawn).norm() - 1.2, 0.0, 1.0);
    return kFloorRough_m * fade * RockNoise({u, v, 0.0}, 1.6, kRockSeed + 1);
  });
  floor.AddTo(scene, kMineFloor, kFoot_m - 0.2);
  HeightGridShape roof;
  roof.spacing_m = 0.8;
  roof.origin = extent.min;
  roof.cols = static_cast<int>(2.0 * x / roof.spacing_m) + 1;
  roof.rows = static_cast<int>(2.0 * y / roof.spacing_m) + 1;
  for (int row = 0; row < roof.rows; ++row) {
    for (int col = 0; col < roof.cols; ++col) {
      const Vec2 p = roof.origin + roof.spacing_m * Vec2(col, row);
      const double noise = 0.6 * RockNoise({p.x(), p.y(), 5.0}, 3.0, kRockSeed + 2) +
                           0.4 * RockNoise({p.x(), p.y(), 9.0}, 0.9, kRockSeed + 3);
      roof.height_m.push_back(static_cast<float>(-kRoof_m - kRoofRough_m * noise));
    }
  }
  scene.Visual(kMineRoof, Overturned(MakeHeightGridSolid(roof, -kTop_m - 0.2)));
}

}  // namespace

SceneSpec BuildMine() {
  SceneBuilder scene;
  const Vec2 spawn = Crossing(0, 0);
  AddFloorAndRoof(scene, spawn);
  MineBuilder mine(&scene);
  mine.AddPillars();
  mine.AddStoppings();
  mine.AddRim();
  // What hides the outer faces.
  const Paint hill{"hill", Label::kGround};
  const double x = kInnerX_m + kRock_m, y = kInnerY_m + kRock_m, d = 0.6, top = kTop_m + 0.1;
  const auto outside = [&](const Vec3& min, const Vec3& max) { scene.Box(hill, min, max, Physics::kNone); };
  outside(Vec3(-x - d, -y - d, -1.0), Vec3(x + d, -y + d, top));
  outside(Vec3(-x - d, y - d, -1.0), Vec3(x + d, y + d, top));
  outside(Vec3(-x - d, -y, -1.0), Vec3(-x + d, y, top));
  outside(Vec3(x - d, -y, -1.0), Vec3(x + d, y, top));
  outside(Vec3(-x - d, -y - d, top), Vec3(x + d, y + d, top + 0.4));
  SceneSpec spec = scene.FinishSpace(spawn, 0.5 * core::kPi, 0.05);
  spec.object_box = {Vec3(-kInnerX_m - 0.6, -kInnerY_m - 0.6, -0.15),
                     Vec3(kInnerX_m + 0.6, kInnerY_m + 0.6, kRoof_m + kRoofRough_m + 0.15)};
  return spec;
}

}  // namespace atlas::scenes
