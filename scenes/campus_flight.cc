// A training village of 70 x 160 m for a flown LiDAR: a street between buildings with roofs, a tower, a ruin,
// rubble, containers and trees.
//
// Of the size of the site that the thesis maps from the air (ARCHE, 4.10.2). x points east, the street runs
// along y. All of it is to be mapped.
#include "core/rng.h"
#include "scenes/scenes.h"
#include "scenes/town/facade_run.h"
#include "scenes/town/greenery.h"
#include "scenes/town/relief.h"
#include "scenes/town/street.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Pose;
using core::Vec2;
using core::Vec3;

constexpr double kHalfX_m = 35.0, kHalfY_m = 80.0;
constexpr uint64_t kSeed = 20190917;

/// Level along the street and where the buildings stand, rising towards the rims.
double GroundHeight(double x, double y) {
  const double rim = std::max(0.0, std::abs(x) - 27.0) / 8.0, u = std::min(rim, 1.0);
  return u * u * (3.0 - 2.0 * u) * (1.1 + 0.6 * std::sin(y / 13.0) + 0.3 * std::cos(x / 3.0 + y / 7.0));
}

struct House {
  Vec2 at;
  double yaw_deg, length, depth;
  int storeys;
  double roof_m;
};

void AddHouses(SceneBuilder& scene) {
  const House houses[] = {
      {{-16, -62}, -90, 20, 11, 2, 4.0}, {{17, -60}, 90, 16, 12, 3, 0.0},  {{-17, -36}, -90, 18, 12, 3, 4.5},
      {{16, -34}, 90, 22, 10, 2, 3.6},   {{-15, -8}, -90, 14, 10, 2, 0.0}, {{-16, 40}, -90, 20, 11, 2, 3.8},
      {{18, 34}, 90, 16, 11, 3, 4.2},    {{17, 58}, 90, 18, 12, 2, 0.0},   {{-17, 64}, -78, 14, 10, 1, 3.0}};
  for (const House& house : houses) {
    TownBlock block;
    block.middle = Vec3(house.at.x(), house.at.y(), 0.0);
    block.yaw_rad = core::Radians(house.yaw_deg);
    block.length_m = house.length;
    block.depth_m = house.depth;
    block.storeys = house.storeys;
    block.roof_m = house.roof_m;
    block.chimneys = house.roof_m > 0.0;
    block.name = "houses";
    AddTownBlock(scene, block);
    if (house.roof_m > 0.0) continue;
    // What stands on flat roofs.
    const Paint paint{"roof_units", Label::kObject, true};
    const Pose T =
        core::PoseFromXyzYaw(Vec3(house.at.x(), house.at.y(), block.storeys * block.storey_m), block.yaw_rad);
    WallBox(scene, paint, T, Vec3(-3.5, -1.5, 0.0), Vec3(-1.0, 1.0, 2.2));
    WallBox(scene, paint, T, Vec3(2.0, 0.5, 0.0), Vec3(3.2, 1.9, 0.9));
    scene.Visual(paint, MakeCylinder(0.35, 0.6, T * At(Vec3(1.0, -2.2, 0.6)), 14));
  }
}

/// A square tower with a stair drum, 14 m.
void AddTower(SceneBuilder& scene) {
  const Paint wall{"tower", Label::kWall, true}, rail{"tower_rails", Label::kRail, true};
  const Vec3 foot(12, 8, 0);
  TownBlock shaft;
  shaft.middle = foot;
  shaft.length_m = shaft.depth_m = 6.0;
  shaft.storeys = 4;
  shaft.storey_m = 3.3;
  shaft.roof_m = 0.0;
  shaft.chimneys = false;
  shaft.name = "tower";
  AddTownBlock(scene, shaft);
  scene.Cylinder(wall, foot + Vec3(4.2, 0, -0.3), foot + Vec3(4.2, 0, 14.6), 1.4, 28);
  for (double sx : {-2.4, 0.0, 2.4}) {
    for (double sy : {-2.4, 2.4}) {
      scene.Cylinder(rail, foot + Vec3(sx, sy, 13.2), foot + Vec3(sx, sy, 14.9), 0.04, 8);
    }
  }
  for (double sy : {-2.4, 2.4}) {
    scene.Cylinder(rail, foot + Vec3(-2.4, sy, 14.9), foot + Vec3(2.4, sy, 14.9), 0.04, 8);
  }
}

/// Outer walls with holes for windows, no glass, floors half fallen: beams pass through.
void AddRuin(SceneBuilder& scene, core::Rng* rng) {
  const Paint wall{"ruin", Label::kWall, true}, slab{"ruin_slabs", Label::kFloor, true},
      rubble{"rubble", Label::kRock, true};
  const Vec3 corner(-21, 12, 0);
  constexpr double kLength = 13.0, kDepth = 10.0, kHeight = 6.4, kThick = 0.35;
  const struct {
    Vec3 start;
    double yaw_deg, length, height;
  } walls[] = {{{0, 0, 0}, 0, kLength, kHeight},
               {{kLength, 0, 0}, 90, kDepth, kHeight},
               {{kLength, kDepth, 0}, 180, kLength, 4.1},
               {{0, kDepth, 0}, -90, kDepth, kHeight - 1.0}};
  for (const auto& side : walls) {
    const Pose T = core::PoseFromXyzYaw(corner + side.start, core::Radians(side.yaw_deg));
    std::vector<Rect> holes;
    for (double x = 1.6; x + 1.4 < side.length; x += 3.0) {
      for (double z : {0.9, 4.0}) {
        if (z + 1.5 < side.height) holes.push_back({{x, z}, {x + 1.3, z + 1.5}});
      }
    }
    for (const Rect& r : CoverAround({{0.0, -0.3}, {side.length, side.height}}, holes)) {
      WallBox(scene, wall, T, Vec3(r.min.x(), 0, r.min.y()), Vec3(r.max.x(), kThick, r.max.y()));
    }
    scene.Collide(wall, {BoxShape{Vec3(0.5 * side.length, 0.5 * kThick, 0.5)},
                         T * At(Vec3(0.5 * side.length, 0.5 * kThick, 0.35))});
  }
  scene.Box(slab, corner + Vec3(0.2, 0.2, 3.0), corner + Vec3(7.5, kDepth - 0.2, 3.2), Physics::kNone);
  scene.Box(slab, Vec3(2.8, 4.4, 0.1),
            core::MakePose(core::RotationFromYawPitchRoll(0.1, 0.45, 0.08), corner + Vec3(9.9, 5.0, 1.75)));
  // A heap where the corner fell, and what rolled off it.
  const Vec3 heap = corner + Vec3(12.0, 8.5, 0);
  for (int k = 0; k < 150; ++k) {
    const Vec2 from(1.8 * rng->Normal(), 1.6 * rng->Normal());
    const double top = 1.3 * std::exp(-from.squaredNorm() / 5.0);
    const Vec3 at = heap + Vec3(from.x(), from.y(), rng->Uniform(-0.5, 1.0) * top + 0.05);
    const Vec3 half(rng->Uniform(0.12, 0.6), rng->Uniform(0.1, 0.4), rng->Uniform(0.06, 0.25));
    scene.Visual(rubble, MakeBox(half, core::MakePose(core::RotationFromYawPitchRoll(rng->Uniform(0, 6.3),
                                                                                     rng->Uniform(-0.6, 0.6),
                                                                                     rng->Uniform(-0.6, 0.6)),
                                                      at)));
  }
}

/// A steel box with ribs on its long sides.
void AddContainer(SceneBuilder& scene, const Vec3& foot, double yaw_rad, double length) {
  const Paint steel{"containers", Label::kVehicle, true};
  const Pose T = core::PoseFromXyzYaw(foot, yaw_rad);
  const double x = 0.5 * length, y = 1.2;
  WallBox(scene, steel, T, Vec3(-x, -y, -0.05), Vec3(x, y, 2.55), Physics::kSolid);
  for (double u = -x + 0.3; u < x - 0.2; u += 0.6) {
    for (double side : {-y - 0.05, y}) {
      WallBox(scene, steel, T, Vec3(u, side, 0.15), Vec3(u + 0.25, side + 0.05, 2.45));
    }
  }
}

void AddStreet(SceneBuilder& scene, const Relief& ground) {
  const Paint paving{"street", Label::kPath, true};
  AddPath(scene, paving, ground, {{0, -79}, {0.5, -40}, {-1, -10}, {0, 20}, {1.5, 48}, {0, 79}}, 6.0);
  AddPath(scene, paving, ground, {{-33, 1}, {-1, 1.5}, {33, -6}}, 4.0);
  for (double y : {-70.0, -48.0, -22.0, 22.0, 48.0, 72.0}) {
    AddLampPost(scene, ground.On(4.2, y));
    AddLampPost(scene, ground.On(-4.2, y + 8.0));
  }
  AddContainer(scene, Vec3(8, -12, 0), 0.2, 6.0);
  AddContainer(scene, Vec3(8.3, -12.1, 2.5), 0.2, 6.0);
  AddContainer(scene, Vec3(12, -15.5, 0), 0.25, 12.0);
  AddContainer(scene, Vec3(-6.5, 30, 0), 1.4, 6.0);
  for (double side : {-1.0, 1.0}) {
    AddGardenWall(scene, Vec3(side * 34.6, -79.4, 0), Vec3(side * 34.6, 79.4, 0), 2.4);
    AddGardenWall(scene, Vec3(-34.6, side * 79.4, 0), Vec3(34.6, side * 79.4, 0), 2.4);
  }
}

void AddTrees(SceneBuilder& scene, const Relief& ground, core::Rng* rng) {
  for (double y = -72.0; y <= 74.0; y += 9.0) {
    for (double side : {-1.0, 1.0}) {
      const Vec2 p(side * rng->Uniform(28.0, 31.5), y + rng->Uniform(-2.0, 2.0));
      const double height = rng->Uniform(6.0, 11.0);
      AddTree(scene, ground.On(p.x(), p.y()),
              {height, 0.3 * height, 0.02 * height + 0.05, 2.0, static_cast<int>(22.0 * height)}, rng);
    }
  }
  for (const Vec2& p :
       {Vec2(22, -14), Vec2(25, 2), Vec2(-26, -22), Vec2(-24, 4), Vec2(-8, 52), Vec2(25, 20)}) {
    AddTree(scene, ground.On(p.x(), p.y()), {9.5, 3.2, 0.24, 2.3, 210}, rng);
  }
}

}  // namespace

SceneSpec BuildCampusFlight() {
  core::Rng rng(kSeed);
  SceneBuilder scene;
  const Relief ground({{-kHalfX_m, -kHalfY_m}, {kHalfX_m, kHalfY_m}}, 1.0, GroundHeight);
  ground.AddTo(scene, {"ground", Label::kGrass, true}, -2.5);
  AddHouses(scene);
  AddTower(scene);
  AddRuin(scene, &rng);
  AddStreet(scene, ground);
  AddTrees(scene, ground, &rng);
  return scene.FinishSpace({4.0, -76.0}, 0.5 * core::kPi, 0.08);
}

}  // namespace atlas::scenes
