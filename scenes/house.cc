// A detached house with porch, pitched roof and chimney, about 8 x 10 x 6 m.
//
// The ridge runs along y; the porch faces +x. The body is one solid; frames stand proud of the walls.
#include "scenes/build/ground.h"
#include "scenes/scenes.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Vec2;
using core::Vec3;

constexpr double kBack_m = -3.8, kFront_m = 2.0, kHalfLength_m = 4.8, kEaves_m = 2.9, kFoot_m = -0.1;
constexpr double kRidge_x_m = 0.5 * (kBack_m + kFront_m), kSlope = 0.84;
constexpr double kPorchFloor_m = 0.34, kPorchFront_m = 3.8, kPorchHalfWidth_m = 2.4;

double RoofUnderside(double x) {
  return kEaves_m + kSlope * (0.5 * (kFront_m - kBack_m) - std::abs(x - kRidge_x_m));
}

void AddShell(SceneBuilder& scene) {
  const Paint walls = Object("walls", Label::kWall), roof = Object("roof", Label::kRoof);
  scene.Visual(walls, MakeExtrusion({{kBack_m, kFoot_m},
                                     {kFront_m, kFoot_m},
                                     {kFront_m, kEaves_m},
                                     {kRidge_x_m, RoofUnderside(kRidge_x_m)},
                                     {kBack_m, kEaves_m}},
                                    -kHalfLength_m, kHalfLength_m, SideOutline()));
  const Vec3 half(0.5 * (kFront_m - kBack_m), kHalfLength_m, 0.5 * kEaves_m);
  scene.Collide(walls, {BoxShape{half}, At(Vec3(kRidge_x_m, 0, half.z()))});
  scene.Box(Object("plinth", Label::kWall), Vec3(kBack_m - 0.05, -kHalfLength_m - 0.05, kFoot_m),
            Vec3(kFront_m + 0.05, kHalfLength_m + 0.05, 0.3));

  const double x0 = kBack_m - 0.45, x1 = kFront_m + 0.45, thickness = 0.18;
  scene.Visual(roof, MakeExtrusion({{x0, RoofUnderside(x0)},
                                    {kRidge_x_m, RoofUnderside(kRidge_x_m)},
                                    {x1, RoofUnderside(x1)},
                                    {x1, RoofUnderside(x1) + thickness},
                                    {kRidge_x_m, RoofUnderside(kRidge_x_m) + thickness},
                                    {x0, RoofUnderside(x0) + thickness}},
                                   -kHalfLength_m - 0.4, kHalfLength_m + 0.4, SideOutline()));
  const Paint gutter = Object("gutters", Label::kPipe);
  for (double x : {x0 - 0.05, x1 + 0.05}) {
    const double z = RoofUnderside(x0) + 0.04;
    scene.Tube(gutter, {Vec3(x, -kHalfLength_m - 0.4, z), Vec3(x, kHalfLength_m + 0.4, z)}, 0.06);
    const double wall = x < kRidge_x_m ? kBack_m - 0.07 : kFront_m + 0.07;
    for (double y : {-kHalfLength_m + 0.15, kHalfLength_m - 0.15}) {
      scene.Tube(gutter, {Vec3(x, y, z - 0.03), Vec3(wall, y, z - 0.4), Vec3(wall, y, 0.05)}, 0.045);
    }
  }
}

void AddChimney(SceneBuilder& scene) {
  const Paint chimney = Object("chimney", Label::kChimney);
  scene.Box(chimney, Vec3(-2.2, 2.4, 3.8), Vec3(-1.5, 3.3, 5.95));
  scene.Box(chimney, Vec3(-2.28, 2.32, 5.8), Vec3(-1.42, 3.38, 5.95));
  for (double y : {2.65, 3.05}) scene.Cylinder(chimney, Vec3(-1.85, y, 5.9), Vec3(-1.85, y, 6.2), 0.12);
}

/// A flat fitting on a wall: `at` is its middle on the wall, `out` the wall's outward direction.
struct WallSpot {
  Vec3 at, out;
};

/// A slab on a wall, `width` x `height`, standing `proud_m` out of it.
void AddSlab(SceneBuilder& scene, const Paint& paint, const WallSpot& spot, const Vec2& offset, double width,
             double height, double proud_m) {
  const Vec3 along = Vec3::UnitZ().cross(spot.out);
  const Vec3 middle =
      spot.at + offset.x() * along + Vec3(0, 0, offset.y()) + 0.5 * (proud_m - 0.02) * spot.out;
  const Vec3 half =
      0.5 * (width * along.cwiseAbs() + Vec3(0, 0, height) + (proud_m + 0.02) * spot.out.cwiseAbs());
  scene.Box(paint, middle - half, middle + half, Physics::kNone);
}

void AddFrame(SceneBuilder& scene, const Paint& paint, const WallSpot& spot, double width, double height) {
  constexpr double kBar_m = 0.1, kProud_m = 0.05;
  for (double side : {-0.5, 0.5}) {
    AddSlab(scene, paint, spot, {side * (width + kBar_m), 0}, kBar_m, height + 2 * kBar_m, kProud_m);
    AddSlab(scene, paint, spot, {0, side * (height + kBar_m)}, width, kBar_m, kProud_m);
  }
}

void AddWindow(SceneBuilder& scene, const WallSpot& spot, double width, double height) {
  const Paint frame = Object("frames", Label::kLedge);
  AddSlab(scene, Object("windows", Label::kWindow), spot, {0, 0}, width, height, 0.01);
  AddFrame(scene, frame, spot, width, height);
  AddSlab(scene, frame, spot, {0, 0}, 0.05, height, 0.03);
  AddSlab(scene, frame, spot, {0, 0}, width, 0.05, 0.03);
  AddSlab(scene, frame, spot, {0, -0.5 * height - 0.12}, width + 0.3, 0.07, 0.12);
}

void AddDoor(SceneBuilder& scene, const WallSpot& spot) {
  const Paint door = Object("doors", Label::kDoor);
  AddSlab(scene, door, spot, {0, 0}, 0.95, 2.0, 0.01);
  for (double z : {-0.5, 0.45}) AddSlab(scene, door, spot, {0, z}, 0.6, 0.7, 0.025);
  AddFrame(scene, Object("frames", Label::kLedge), spot, 0.95, 2.0);
}

void AddOpenings(SceneBuilder& scene) {
  const Vec3 front = Vec3::UnitX(), back = -front, left = Vec3::UnitY(), right = -left;
  AddDoor(scene, {Vec3(kFront_m, 0, kPorchFloor_m + 1.05), front});
  AddDoor(scene, {Vec3(kBack_m, -2.6, 1.15), back});
  scene.Box(Object("doorstep", Label::kStairs), Vec3(kBack_m - 0.55, -3.3, kFoot_m),
            Vec3(kBack_m, -1.9, 0.12));
  for (double y : {-3.6, -1.4, 1.4, 3.6}) AddWindow(scene, {Vec3(kFront_m, y, 1.55), front}, 1.1, 1.2);
  for (double y : {-0.4, 1.6, 3.5}) AddWindow(scene, {Vec3(kBack_m, y, 1.55), back}, 1.1, 1.2);
  for (const Vec3& side : {left, right}) {
    for (double x : {-2.4, 0.6}) AddWindow(scene, {Vec3(x, kHalfLength_m * side.y(), 1.55), side}, 1.0, 1.2);
    AddWindow(scene, {Vec3(kRidge_x_m, kHalfLength_m * side.y(), 3.7), side}, 0.8, 0.9);
  }
}

void AddPorch(SceneBuilder& scene) {
  const Paint porch = Object("porch", Label::kPorch), steps = Object("porch_steps", Label::kStairs);
  const Paint post = Object("porch_posts", Label::kColumn), roof = Object("porch_roof", Label::kRoof);
  const double half = kPorchHalfWidth_m, x_post = kPorchFront_m - 0.12;
  scene.Box(porch, Vec3(kFront_m, -half, kFoot_m), Vec3(kPorchFront_m, half, kPorchFloor_m));
  scene.Box(steps, Vec3(kPorchFront_m, -0.8, kFoot_m), Vec3(kPorchFront_m + 0.32, 0.8, 0.17));
  constexpr double kPostTop_m = 2.22;
  for (double y : {-half + 0.12, -0.9, 0.9, half - 0.12}) {
    scene.Box(post, Vec3(x_post - 0.07, y - 0.07, kPorchFloor_m), Vec3(x_post + 0.07, y + 0.07, kPostTop_m));
  }
  scene.Box(post, Vec3(x_post - 0.08, -half, kPostTop_m - 0.1), Vec3(x_post + 0.08, half, kPostTop_m + 0.04));
  const double drop = 0.16, x1 = kPorchFront_m + 0.3, z1 = kPostTop_m - 0.02,
               z0 = z1 + drop * (x1 - kFront_m);
  scene.Visual(roof,
               MakeExtrusion({{kFront_m - 0.02, z0}, {x1, z1}, {x1, z1 + 0.12}, {kFront_m - 0.02, z0 + 0.12}},
                             -half - 0.25, half + 0.25, SideOutline()));
  // Railings: along the front beside the steps, and at both ends.
  const auto railing = [&](const Vec3& a, const Vec3& b) {
    const Paint rail = Object("porch_railing", Label::kRail);
    const Vec3 along = (b - a).normalized(), thick = Vec3(0.025, 0.025, 0);
    for (double z : {0.12, 0.85})
      scene.Box(rail, a + Vec3(0, 0, z) - thick, b + Vec3(0, 0, z + 0.06) + thick, Physics::kNone);
    const int bars = static_cast<int>((b - a).norm() / 0.2);
    for (int k = 1; k < bars; ++k) {
      const Vec3 p = a + along * ((b - a).norm() * k / bars);
      scene.Box(rail, p + Vec3(-0.015, -0.015, 0.15), p + Vec3(0.015, 0.015, 0.88), Physics::kNone);
    }
    scene.Collide(
        rail, {BoxShape{0.5 * (b - a) + thick + Vec3(0, 0, 0.395)}, At(0.5 * (a + b) + Vec3(0, 0, 0.515))});
  };
  const double z = kPorchFloor_m;
  railing(Vec3(x_post, -half + 0.19, z), Vec3(x_post, -0.97, z));
  railing(Vec3(x_post, 0.97, z), Vec3(x_post, half - 0.19, z));
  for (double y : {-half + 0.12, half - 0.12}) railing(Vec3(kFront_m, y, z), Vec3(x_post - 0.07, y, z));
}

}  // namespace

SceneSpec BuildHouse() {
  SceneBuilder scene;
  AddFlatGround(scene, {{-14.0, -15.0}, {14.0, 15.0}}, Label::kGrass);
  AddShell(scene);
  AddChimney(scene);
  AddOpenings(scene);
  AddPorch(scene);
  return scene.Finish(Vec2(6.9, -2.6), core::Radians(90.0));
}

}  // namespace atlas::scenes
