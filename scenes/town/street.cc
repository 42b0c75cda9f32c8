#include "scenes/town/street.h"

#include "scenes/town/facade_run.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Pose;
using core::Vec2;
using core::Vec3;

const Paint kWood{"benches", Label::kFurniture, true}, kIron{"lamp_posts", Label::kColumn, true},
    kBollards{"bollards", Label::kColumn, true}, kBins{"bins", Label::kObject, true},
    kStone{"statue", Label::kRock, true}, kGardenWall{"garden_walls", Label::kWall, true};

}  // namespace

void AddBench(SceneBuilder& scene, const Vec3& foot, double yaw_rad) {
  const Pose T = core::PoseFromXyzYaw(foot, yaw_rad);
  const auto bar = [&](const Vec3& min, const Vec3& max) { WallBox(scene, kWood, T, min, max); };
  for (int k = 0; k < 4; ++k) {
    bar(Vec3(-0.02 + 0.12 * k, -0.9, 0.42), Vec3(0.08 + 0.12 * k, 0.9, 0.45));
    if (k < 3) bar(Vec3(-0.1, -0.9, 0.5 + 0.13 * k), Vec3(-0.07, 0.9, 0.6 + 0.13 * k));
  }
  for (double y : {-0.75, 0.0, 0.69}) {
    bar(Vec3(-0.13, y, -0.2), Vec3(-0.07, y + 0.06, 0.9));
    bar(Vec3(0.36, y, -0.2), Vec3(0.42, y + 0.06, 0.42));
  }
  for (double y : {-0.8, 0.74}) bar(Vec3(-0.1, y, 0.62), Vec3(0.42, y + 0.06, 0.66));
  scene.Collide(kWood, {BoxShape{Vec3(0.22, 0.88, 0.014)}, T * At(Vec3(0.2, 0, 0.435))});
}

void AddLampPost(SceneBuilder& scene, const Vec3& foot) {
  const auto up = [&](double z) -> Vec3 { return foot + Vec3(0, 0, z); };
  scene.Cylinder(kIron, up(-0.2), up(0.7), 0.1, 10);
  scene.Cylinder(kIron, up(0.7), up(3.5), 0.05, 10);
  scene.Cylinder(kIron, up(3.5), up(3.56), 0.16, 10);
  scene.Visual(kIron, MakeFrustum(0.12, 0.2, 0.2, At(up(3.76)), 8));
  scene.Visual(kIron, MakeFrustum(0.24, 0.03, 0.1, At(up(4.06)), 8));
}

void AddBollard(SceneBuilder& scene, const Vec3& foot) {
  scene.Cylinder(kBollards, foot - Vec3(0, 0, 0.2), foot + Vec3(0, 0, 0.82), 0.09, 12);
  scene.Visual(kBollards, MakeSphere(0.11, At(foot + Vec3(0, 0, 0.86)), 12));
}

void AddBin(SceneBuilder& scene, const Vec3& foot) {
  scene.Cylinder(kBins, foot - Vec3(0, 0, 0.1), foot + Vec3(0, 0, 0.85), 0.26, 14);
  scene.Visual(kBins, MakeFrustum(0.3, 0.12, 0.06, At(foot + Vec3(0, 0, 0.91)), 14));
}

void AddStatue(SceneBuilder& scene, const Vec3& foot) {
  const auto box = [&](double half, double z0, double z1) {
    scene.Box(kStone, foot + Vec3(-half, -half, z0), foot + Vec3(half, half, z1));
  };
  box(1.7, -0.2, 0.18);
  box(1.35, 0.18, 0.36);
  box(0.75, 0.36, 2.0);
  box(0.85, 1.85, 2.05);
  const auto up = [&](double x, double z) -> Vec3 { return foot + Vec3(x, 0, z); };
  for (double side : {-0.14, 0.14}) {
    scene.Visual(kStone, MakeTube({up(side, 2.0), up(side, 2.5), up(0.8 * side, 2.95)}, 0.13, 10));
    scene.Visual(kStone,
                 MakeTube({up(2.0 * side, 3.6), up(2.9 * side, 3.25), up(2.0 * side, 2.95)}, 0.08, 8));
  }
  scene.Visual(kStone, MakeFrustum(0.24, 0.32, 0.42, At(up(0, 3.3)), 14));
  scene.Visual(kStone, MakeCapsule(0.09, 0.1, At(up(0, 3.75)), 10));
  scene.Visual(kStone, MakeSphere(0.18, At(up(0, 4.0)), 16));
}

void AddGardenWall(SceneBuilder& scene, const Vec3& a, const Vec3& b, double height_m) {
  constexpr double kHalf_m = 0.18, kFoot_m = -2.0, kPiers_m = 6.0;
  const Vec3 along = b - a;
  const double length = along.norm();
  const Pose T = core::PoseFromXyzYaw(a, std::atan2(along.y(), along.x()));
  WallBox(scene, kGardenWall, T, Vec3(0, -kHalf_m, kFoot_m), Vec3(length, kHalf_m, height_m),
          Physics::kSolid);
  WallBox(scene, kGardenWall, T, Vec3(0, -kHalf_m - 0.06, height_m),
          Vec3(length, kHalf_m + 0.06, height_m + 0.1));
  const int piers = std::max(1, static_cast<int>(length / kPiers_m));
  for (int k = 0; k <= piers; ++k) {
    const double x = std::clamp(k * length / piers, 0.3, length - 0.3);
    WallBox(scene, kGardenWall, T, Vec3(x - 0.3, -0.3, kFoot_m), Vec3(x + 0.3, 0.3, height_m + 0.25));
  }
}

void AddGableRoof(SceneBuilder& scene, const std::string& name, const Pose& T_map_eaves, double length_m,
                  double depth_m, double ridge_m) {
  constexpr double kOverhang_m = 0.35;
  const double half = 0.5 * depth_m + kOverhang_m;
  const Vec3 along = T_map_eaves.linear().col(0), across = T_map_eaves.linear().col(1);
  core::Mat3 R;  // local x across, y up, z along
  R << across, Vec3::UnitZ(), across.cross(Vec3::UnitZ());
  const double sign = R.col(2).dot(along) > 0.0 ? 1.0 : -1.0, end = 0.5 * length_m + 0.2;
  scene.Visual({name + "_roofs", Label::kRoof, true},
               MakeExtrusion({{-half, -0.12}, {half, -0.12}, {half, 0.06}, {0.0, ridge_m}, {-half, 0.06}},
                             std::min(-sign * end, sign * end), std::max(-sign * end, sign * end),
                             core::MakePose(R, T_map_eaves.translation())));
}

void AddTownBlock(SceneBuilder& scene, const TownBlock& block) {
  const Pose T = core::PoseFromXyzYaw(block.middle, block.yaw_rad);
  const double hx = 0.5 * block.length_m, hy = 0.5 * block.depth_m, top = block.storeys * block.storey_m;
  const Paint wall{block.name + "_walls", Label::kWall, true};
  struct Side {
    Vec3 start;
    double yaw, length;
  };
  const Side sides[] = {{Vec3(-hx, -hy, 0), 0.0, block.length_m},
                        {Vec3(hx, hy, 0), core::kPi, block.length_m},
                        {Vec3(hx, -hy, 0), 0.5 * core::kPi, block.depth_m},
                        {Vec3(-hx, hy, 0), -0.5 * core::kPi, block.depth_m}};
  const int fronts = block.fronts_all_round ? 4 : 1;
  for (int k = 0; k < fronts; ++k) {
    FacadeRun run;
    run.T_map_wall = T * core::PoseFromXyzYaw(sides[k].start, sides[k].yaw);
    run.length_m = sides[k].length;
    run.storeys = block.storeys;
    run.storey_m = block.storey_m;
    run.foot_m = block.foot_m;
    run.name = block.name;
    if (k < 2) run.door_bays = {run.bays() / 2};
    AddFacadeRun(scene, run);
  }
  const double inset = kFrontDepth_m, other = block.fronts_all_round ? inset : 0.0;
  WallBox(scene, wall, T, Vec3(-hx + other, -hy + inset, block.foot_m), Vec3(hx - other, hy - other, top),
          Physics::kSolid);
  if (block.roof_m > 0.0) {
    AddGableRoof(scene, block.name, T * At(Vec3(0, 0, top)), block.length_m, block.depth_m, block.roof_m);
  } else {
    const Paint roof{block.name + "_roofs", Label::kRoof, true};
    WallBox(scene, roof, T, Vec3(-hx + 0.3, -hy + 0.3, top - 0.2), Vec3(hx - 0.3, hy - 0.3, top + 0.05));
    for (double side : {-1.0, 1.0}) {
      WallBox(scene, wall, T, Vec3(-hx, side * hy - 0.3 * (side + 1) * 0.5, top - 0.1),
              Vec3(hx, side * hy + 0.3 * (1 - side) * 0.5, top + 0.6));
      WallBox(scene, wall, T, Vec3(side * hx - 0.3 * (side + 1) * 0.5, -hy, top - 0.1),
              Vec3(side * hx + 0.3 * (1 - side) * 0.5, hy, top + 0.6));
    }
  }
  if (!block.chimneys) return;
  const Paint chimney{block.name + "_chimneys", Label::kChimney, true};
  for (double side : {-0.6, 0.5}) {
    const double z = top + std::max(block.roof_m, 1.0);
    WallBox(scene, chimney, T, Vec3(side * hx - 0.4, 0.2, top - 0.1), Vec3(side * hx + 0.4, 0.8, z + 0.8));
    WallBox(scene, chimney, T, Vec3(side * hx - 0.48, 0.12, z + 0.65), Vec3(side * hx + 0.48, 0.88, z + 0.8));
  }
}

}  // namespace atlas::scenes
