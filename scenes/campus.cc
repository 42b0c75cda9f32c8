// A college campus of 135 x 225 m: a quad behind three-storey ranges, a vaulted passage out of it, and a
// park.
//
// The size and the order of places are those of the thesis's outdoor experiment (Newer College, 4.10.2): the
// quad in the south (y < -28), the passage through its north range at x = 10, the park beyond. x points
// east. All of it is to be mapped.
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

constexpr double kHalfX_m = 67.5, kHalfY_m = 112.5;
constexpr double kQuadHalfX_m = 32.0, kQuadSouth_m = -92.0, kQuadNorth_m = -28.0, kRangeDepth_m = 13.0;
constexpr int kStoreys = 3;
constexpr double kStorey_m = 3.7, kEaves_m = kStoreys * kStorey_m, kRidge_m = 4.2, kFoot_m = -0.3;
constexpr double kPassageX_m = 10.0, kPassageHalf_m = 1.3, kPassageSpring_m = 2.1, kPassageTop_m = 3.8;
constexpr double kParkSouth_m = kQuadNorth_m + kRangeDepth_m;
constexpr uint64_t kSeed = 20201102;

/// Flat in the quad; a metre or two of relief in the park, fading in behind the passage.
double GroundHeight(double x, double y) {
  const double u = std::clamp((y - (kParkSouth_m + 4.0)) / 22.0, 0.0, 1.0), fade = u * u * (3.0 - 2.0 * u);
  const double hills = 0.85 * std::sin(x / 17.0 + 0.6) * std::cos(y / 21.0 - 0.4) +
                       0.55 * std::sin(0.13 * x + 0.09 * y) + 0.25 * std::cos(0.31 * x - 0.22 * y);
  return fade * hills;
}

struct Range {
  Pose T_map_wall;
  double length_m;
  std::vector<int> door_bays;
};

void AddFronts(SceneBuilder& scene) {
  const auto at = [](double x, double y, double yaw_deg) {
    return core::PoseFromXyzYaw(Vec3(x, y, 0), core::Radians(yaw_deg));
  };
  const double outer = kQuadHalfX_m + kRangeDepth_m, side = kQuadNorth_m - kQuadSouth_m;
  const Range ranges[] = {{at(-kQuadHalfX_m, kQuadNorth_m, 0), 2 * kQuadHalfX_m, {2, 13}},
                          {at(kQuadHalfX_m, kQuadSouth_m, 180), 2 * kQuadHalfX_m, {3, 8, 12}},
                          {at(-kQuadHalfX_m, kQuadSouth_m, 90), side, {2, 7, 13}},
                          {at(kQuadHalfX_m, kQuadNorth_m, -90), side, {4, 11}},
                          {at(outer, kParkSouth_m, 180), 2 * outer, {4, 18}}};
  for (const Range& range : ranges) {
    FacadeRun run;
    run.T_map_wall = range.T_map_wall;
    run.length_m = range.length_m;
    run.storeys = kStoreys;
    run.storey_m = kStorey_m;
    run.door_bays = range.door_bays;
    run.ornate = true;
    run.foot_m = kFoot_m;
    run.name = "college";
    const double x = (range.T_map_wall.inverse() * Vec3(kPassageX_m, 0, 0)).x();
    const bool north = std::abs(range.T_map_wall.linear()(1, 0)) < 0.5 &&
                       range.T_map_wall.translation().y() > kQuadSouth_m + 1.0;
    if (north) run.archway = {{x - kPassageHalf_m, kFoot_m}, {x + kPassageHalf_m, kPassageTop_m}};
    AddFacadeRun(scene, run);
  }
}

/// The solid behind the fronts, and the roofs.
void AddRanges(SceneBuilder& scene) {
  const Paint wall{"college_walls", Label::kWall, true};
  const double outer = kQuadHalfX_m + kRangeDepth_m, south = kQuadSouth_m - kRangeDepth_m, d = kFrontDepth_m;
  const auto core_box = [&](double x0, double y0, double x1, double y1, double z0 = kFoot_m) {
    scene.Box(wall, Vec3(x0, y0, z0), Vec3(x1, y1, kEaves_m));
  };
  const double left = kPassageX_m - kPassageHalf_m, right = kPassageX_m + kPassageHalf_m;
  const double y0 = kQuadNorth_m + d, y1 = kParkSouth_m - d;
  core_box(-outer, y0, left, y1);
  core_box(right, y0, outer, y1);
  core_box(left, y0, right, y1, kPassageTop_m);
  core_box(-outer, south, outer, kQuadSouth_m - d);
  core_box(-outer, kQuadSouth_m - d, -kQuadHalfX_m - d, y0);
  core_box(kQuadHalfX_m + d, kQuadSouth_m - d, outer, y0);
  const double mid_x = kQuadHalfX_m + 0.5 * kRangeDepth_m, mid_y = 0.5 * (kQuadNorth_m + kQuadSouth_m);
  const auto roof = [&](double x, double y, double yaw, double length) {
    AddGableRoof(scene, "college", core::PoseFromXyzYaw(Vec3(x, y, kEaves_m), yaw), length, kRangeDepth_m,
                 kRidge_m);
  };
  roof(0, 0.5 * (kQuadNorth_m + kParkSouth_m), 0.0, 2 * outer);
  roof(0, 0.5 * (kQuadSouth_m + south), 0.0, 2 * outer);
  for (double side : {-1.0, 1.0})
    roof(side * mid_x, mid_y, 0.5 * core::kPi, kQuadNorth_m - kQuadSouth_m + 2.0);
  const Paint chimney{"college_chimneys", Label::kChimney, true};
  for (double x = -36.0; x <= 36.0; x += 12.0) {
    for (double y : {0.5 * (kQuadNorth_m + kParkSouth_m), 0.5 * (kQuadSouth_m + south)}) {
      scene.Box(chimney, Vec3(x - 0.5, y - 1.2, kEaves_m), Vec3(x + 0.5, y + 1.2, kEaves_m + kRidge_m + 1.6));
    }
  }
}

/// Vault, ribs and a paved floor.
void AddPassage(SceneBuilder& scene) {
  const Paint vault{"passage_vault", Label::kWall, true}, rib{"passage_ribs", Label::kColumn, true};
  AddVault(scene, vault, Pose::Identity(), kPassageX_m, kPassageHalf_m, kPassageSpring_m, kPassageTop_m,
           kQuadNorth_m, kParkSouth_m);
  constexpr double kRibHalf_m = 0.16, kProud_m = 0.1;
  for (int k = 0; k < 5; ++k) {
    const double y = kQuadNorth_m + 1.0 + k * (kRangeDepth_m - 2.0) / 4.0;
    const double inner = kPassageHalf_m - kProud_m;
    AddVault(scene, rib, Pose::Identity(), kPassageX_m, inner, kPassageSpring_m,
             kPassageSpring_m + kPassageHalf_m, y - kRibHalf_m, y + kRibHalf_m);
    for (double side : {-1.0, 1.0}) {
      const double a = kPassageX_m + side * inner, b = kPassageX_m + side * (kPassageHalf_m + 0.05);
      scene.Box(rib, Vec3(std::min(a, b), y - kRibHalf_m, kFoot_m),
                Vec3(std::max(a, b), y + kRibHalf_m, kPassageSpring_m));
    }
  }
}

void AddQuad(SceneBuilder& scene, core::Rng* rng) {
  const Paint paving{"paths", Label::kPath, true}, lawn{"lawns", Label::kGrass, true};
  const double mid = 0.5 * (kQuadNorth_m + kQuadSouth_m), edge = kQuadHalfX_m - 3.0;
  scene.Box(paving, Vec3(-kQuadHalfX_m - 0.4, kQuadSouth_m - 0.4, -0.2),
            Vec3(kQuadHalfX_m + 0.4, kQuadNorth_m + 0.4, 0.02), Physics::kNone);
  scene.Box(paving, Vec3(kPassageX_m - kPassageHalf_m - 0.1, kQuadNorth_m + 0.4, -0.2),
            Vec3(kPassageX_m + kPassageHalf_m + 0.1, kParkSouth_m + 0.5, 0.02), Physics::kNone);
  for (double sx : {-1.0, 1.0}) {
    for (double sy : {-1.0, 1.0}) {
      const Vec3 a(sx * 3.0, mid + sy * 4.5, 0), b(sx * (edge - 3.0), mid + sy * 27.0, 0);
      const Vec3 min = a.cwiseMin(b), max = a.cwiseMax(b);
      scene.Box(lawn, Vec3(min.x(), min.y(), -0.2), Vec3(max.x(), max.y(), 0.07), Physics::kNone);
      const Vec3 inner = 0.5 * (a + b);
      AddTree(scene, inner + Vec3(0, 0, 0.07), {7.5, 2.6, 0.16, 2.3, 220}, rng);
      AddLampPost(scene, Vec3(sx * 2.2, mid + sy * 6.5, 0));
      AddHedge(scene, Vec3(sx * 5.0, mid + sy * 26.0, 0.05), Vec3(sx * 22.0, mid + sy * 26.0, 0.05), 0.8, 0.7,
               rng);
      AddBench(scene, Vec3(sx * 4.2, mid + sy * 12.0, 0.03), sx > 0 ? core::kPi : 0.0);
    }
    AddBench(scene, Vec3(sx * (kQuadHalfX_m - 1.2), mid + 6.0, 0), sx > 0 ? core::kPi : 0.0);
    AddBin(scene, Vec3(sx * (kQuadHalfX_m - 1.2), mid + 8.2, 0));
  }
  AddStatue(scene, Vec3(0, mid, 0));
}

/// The park's walk, once around; the passage leads onto it.
const std::vector<Vec2> kWalk = {{10, -8},  {16, 4},   {34, 14},  {46, 34},  {47, 58},  {36, 82}, {12, 93},
                                 {-14, 92}, {-38, 80}, {-49, 56}, {-47, 30}, {-34, 11}, {-12, 2}, {10, -8}};
const std::vector<Vec2> kCrossWalk = {{16, 4}, {10, 24}, {-4, 44}, {-8, 66}, {-14, 92}};

double DistanceToWalks(const Vec2& p) {
  double least = 1e9;
  for (const auto* way : {&kWalk, &kCrossWalk}) {
    for (size_t i = 0; i + 1 < way->size(); ++i) {
      const Vec2 a = (*way)[i], ab = (*way)[i + 1] - a;
      const double u = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (p - a - u * ab).norm());
    }
  }
  return least;
}

void AddTrees(SceneBuilder& scene, const Relief& ground, core::Rng* rng) {
  std::vector<Vec2> places;
  for (int attempt = 0; attempt < 4000 && places.size() < 62; ++attempt) {
    const Vec2 p(rng->Uniform(-54, 54), rng->Uniform(-6, 100));
    if (DistanceToWalks(p) < 4.0 || (p - Vec2(18, 52)).norm() < 11.0) continue;
    bool near = false;
    for (const Vec2& q : places) near |= (p - q).norm() < 7.5;
    if (near) continue;
    places.push_back(p);
    const double height = rng->Uniform(6.5, 13.0);
    const TreeShape shape{height, 0.32 * height * rng->Uniform(0.85, 1.1), 0.02 * height + 0.04,
                          rng->Uniform(1.9, 2.8), static_cast<int>(24.0 * height)};
    AddTree(scene, ground.On(p.x(), p.y()), shape, rng);
  }
}

void AddPark(SceneBuilder& scene, const Relief& ground, core::Rng* rng) {
  const Paint paving{"paths", Label::kPath, true};
  AddPath(scene, paving, ground, {{10, -15}, {10, -8}}, 2.6);
  AddPath(scene, paving, ground, kWalk, 2.6);
  AddPath(scene, paving, ground, kCrossWalk, 2.0);
  for (double x : {7.2, 8.6, 11.4, 12.8}) AddBollard(scene, ground.On(x, kParkSouth_m + 1.8));
  for (size_t i = 1; i + 1 < kWalk.size(); ++i) {
    const Vec2 along = (kWalk[i + 1] - kWalk[i - 1]).normalized(), out(along.y(), -along.x());
    const Vec2 lamp = kWalk[i] + 2.2 * out, bench = kWalk[i] - 2.3 * out + 3.0 * along;
    AddLampPost(scene, ground.On(lamp.x(), lamp.y()));
    if (i % 2 == 0) AddBench(scene, ground.On(bench.x(), bench.y()), std::atan2(out.y(), out.x()));
    const Vec2 bin = bench + 1.6 * along;
    if (i % 4 == 0) AddBin(scene, ground.On(bin.x(), bin.y()));
  }
  AddTrees(scene, ground, rng);
  for (const auto& [a, b] : {std::pair{Vec2(-44, -9), Vec2(-20, -9)}, {Vec2(20, -9), Vec2(44, -9)}}) {
    AddHedge(scene, ground.On(a.x(), a.y()), ground.On(b.x(), b.y()), 1.3, 0.9, rng);
  }
  TownBlock pavilion;
  pavilion.middle = Vec3(18, 52, 0.0);
  pavilion.yaw_rad = 0.4;
  pavilion.length_m = 11.0;
  pavilion.depth_m = 7.0;
  pavilion.storeys = 1;
  pavilion.storey_m = 3.4;
  pavilion.roof_m = 2.6;
  pavilion.foot_m = -2.0;
  pavilion.middle.z() = ground.HeightAt(18, 52) + 0.25;
  pavilion.name = "pavilion";
  AddTownBlock(scene, pavilion);
}

/// Houses and garden walls that close the park.
void AddSurroundings(SceneBuilder& scene, core::Rng* rng) {
  const auto row = [&](const Vec2& from, const Vec2& to, double yaw_rad) {
    const Vec2 along = (to - from).normalized();
    double s = 1.0;
    const double length = (to - from).norm();
    while (s + 12.0 < length) {
      TownBlock house;
      house.length_m = std::min(rng->Uniform(12.0, 20.0), length - s);
      house.depth_m = 7.5;
      house.storeys = 2 + rng->UniformInt(2);
      house.storey_m = rng->Uniform(3.0, 3.4);
      house.roof_m = rng->Uniform(2.2, 3.4);
      house.foot_m = -2.5;
      house.yaw_rad = yaw_rad;
      house.fronts_all_round = false;
      house.name = "houses";
      const Vec2 middle = from + (s + 0.5 * house.length_m) * along;
      house.middle = Vec3(middle.x(), middle.y(), 0.1);
      AddTownBlock(scene, house);
      s += house.length_m + rng->Uniform(3.0, 6.0);
    }
  };
  row({-63.5, 106}, {-63.5, -14}, 0.5 * core::kPi);
  row({63.5, -14}, {63.5, 106}, -0.5 * core::kPi);
  row({58, 108.5}, {-58, 108.5}, 0.0);
  for (double side : {-1.0, 1.0}) {
    AddGardenWall(scene, Vec3(side * 59.4, kParkSouth_m + 1, 0), Vec3(side * 59.4, 104.6, 0), 2.3);
    AddGardenWall(scene, Vec3(side * 45.3, kParkSouth_m + 1, 0), Vec3(side * 59.4, kParkSouth_m + 1, 0), 2.6);
    AddGardenWall(scene, Vec3(side * 67.2, kParkSouth_m, 0), Vec3(side * 67.2, -112.2, 0), 2.6);
    for (double y : {-30.0, -48.0, -70.0, -88.0}) {
      AddTree(scene, Vec3(side * 56.0, y, 0), {9.0, 2.9, 0.2, 2.4, 150}, rng);
    }
  }
  AddGardenWall(scene, Vec3(-59.4, 104.6, 0), Vec3(59.4, 104.6, 0), 2.3);
  AddGardenWall(scene, Vec3(-67.2, -112.2, 0), Vec3(67.2, -112.2, 0), 2.6);
}

}  // namespace

SceneSpec BuildCampus() {
  core::Rng rng(kSeed);
  SceneBuilder scene;
  const Relief ground({{-kHalfX_m, -kHalfY_m}, {kHalfX_m, kHalfY_m}}, 1.5, GroundHeight);
  ground.AddTo(scene, {"ground", Label::kGrass, true}, -3.0);
  AddFronts(scene);
  AddRanges(scene);
  AddPassage(scene);
  AddQuad(scene, &rng);
  AddPark(scene, ground, &rng);
  AddSurroundings(scene, &rng);
  return scene.FinishSpace({-29.0, -84.0}, core::Radians(90.0), 0.10);
}

}  // namespace atlas::scenes
