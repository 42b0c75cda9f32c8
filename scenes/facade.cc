// A building front, 35 m long and 4 m high, as the thesis mapped at Green Templeton College (Fig. 3.8).
//
// It runs along x and faces -y; the wall's plane is y = 0. Only the front is the object: the block behind,
// the coping on top and the neighbours at both ends close it off, so that the truth holds what can be seen
// from the ground in front.
#include "scenes/build/ground.h"
#include "scenes/build/openings.h"
#include "scenes/scenes.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Vec2;
using core::Vec3;

constexpr double kHalfLength_m = 17.5, kTop_m = 3.94, kFoot_m = -0.2, kWallDepth_m = 0.3, kRecess_m = 0.18;
constexpr double kSill_m = 0.9, kWindowTop_m = 2.6, kWindowWidth_m = 1.3, kDoorTop_m = 2.4,
                 kDoorWidth_m = 1.2;
constexpr double kBay_m = 3.5;  ///< ten bays between pilasters

bool IsDoorBay(int bay) {
  return bay == 1 || bay == 5 || bay == 8;
}
double BayMiddle(int bay) {
  return -kHalfLength_m + (bay + 0.5) * kBay_m;
}

void AddWindow(SceneBuilder& scene, double x) {
  const double half = 0.5 * kWindowWidth_m, y_bar = kRecess_m - 0.03;
  const Paint glass = Object("windows", Label::kWindow), frame = Object("frames", Label::kLedge);
  scene.Box(glass, Vec3(x - half, kRecess_m, kSill_m), Vec3(x + half, kWallDepth_m, kWindowTop_m));
  const auto bar = [&](double x0, double z0, double x1, double z1) {
    scene.Box(frame, Vec3(x0, y_bar, z0), Vec3(x1, kRecess_m, z1), Physics::kNone);
  };
  bar(x - half, kSill_m, x - half + 0.06, kWindowTop_m);
  bar(x + half - 0.06, kSill_m, x + half, kWindowTop_m);
  bar(x - 0.025, kSill_m, x + 0.025, kWindowTop_m);
  for (double z : {kSill_m, 1.75, kWindowTop_m - 0.06}) bar(x - half, z, x + half, z + 0.06);
  const Paint ledge = Object("ledges", Label::kLedge);
  scene.Box(ledge, Vec3(x - half - 0.1, -0.08, kSill_m - 0.1), Vec3(x + half + 0.1, 0.02, kSill_m));
  scene.Box(ledge, Vec3(x - half - 0.1, -0.06, kWindowTop_m),
            Vec3(x + half + 0.1, 0.02, kWindowTop_m + 0.22));
}

void AddDoor(SceneBuilder& scene, double x) {
  const double half = 0.5 * kDoorWidth_m;
  const Paint leaf = Object("doors", Label::kDoor), stone = Object("door_surrounds", Label::kLedge);
  scene.Box(leaf, Vec3(x - half, kRecess_m + 0.04, kFoot_m), Vec3(x + half, kWallDepth_m, kDoorTop_m));
  for (double dx : {-0.5 * half, 0.5 * half}) {
    for (const auto& [z0, z1] : {std::pair{0.25, 0.95}, {1.1, 1.75}, {1.87, 2.25}}) {
      scene.Box(leaf, Vec3(x + dx - 0.2, kRecess_m + 0.015, z0), Vec3(x + dx + 0.2, kRecess_m + 0.05, z1),
                Physics::kNone);
    }
  }
  for (double side : {-1.0, 1.0}) {
    const double a = x + side * half, b = x + side * (half + 0.16);
    scene.Box(stone, Vec3(std::min(a, b), -0.07, kFoot_m), Vec3(std::max(a, b), 0.02, kDoorTop_m));
  }
  scene.Box(stone, Vec3(x - half - 0.25, -0.09, kDoorTop_m), Vec3(x + half + 0.25, 0.02, kDoorTop_m + 0.25));
  scene.Box(Object("doorsteps", Label::kStairs), Vec3(x - half - 0.1, -0.3, kFoot_m),
            Vec3(x + half + 0.1, kRecess_m + 0.05, 0.1));
}

void AddPilaster(SceneBuilder& scene, double x) {
  const Paint pilaster = Object("pilasters", Label::kColumn);
  scene.Box(pilaster, Vec3(x - 0.2, -0.12, kFoot_m), Vec3(x + 0.2, 0.02, 3.5));
  scene.Box(pilaster, Vec3(x - 0.26, -0.16, kFoot_m), Vec3(x + 0.26, 0.02, 0.5));
  scene.Box(pilaster, Vec3(x - 0.26, -0.16, 3.22), Vec3(x + 0.26, 0.02, 3.5));
}

void AddDrainpipe(SceneBuilder& scene, double x) {
  const Paint pipe = Object("drainpipes", Label::kPipe);
  scene.Tube(pipe, {Vec3(x, -0.16, 0.08), Vec3(x, -0.09, 0.2), Vec3(x, -0.09, 3.1)}, 0.05);
  scene.Box(pipe, Vec3(x - 0.13, -0.2, 3.1), Vec3(x + 0.13, 0.02, 3.36));
  for (double z : {0.9, 2.0}) {
    scene.Box(pipe, Vec3(x - 0.08, -0.1, z), Vec3(x + 0.08, 0.02, z + 0.05), Physics::kNone);
  }
}

void AddBench(SceneBuilder& scene, double x) {
  const Paint wood{"benches", Label::kFurniture};
  const double x0 = x - 0.8, x1 = x + 0.8, y_back = -0.5, y_front = -0.98;
  for (int k = 0; k < 3; ++k) {
    const double y = y_front + 0.02 + k * 0.15;
    scene.Box(wood, Vec3(x0, y, 0.42), Vec3(x1, y + 0.12, 0.45), Physics::kNone);
    scene.Box(wood, Vec3(x0, y_back, 0.52 + k * 0.12), Vec3(x1, y_back + 0.03, 0.61 + k * 0.12),
              Physics::kNone);
  }
  scene.Collide(wood, {BoxShape{Vec3(0.8, 0.24, 0.015)}, At(Vec3(x, -0.74, 0.435))});
  scene.Collide(wood, {BoxShape{Vec3(0.8, 0.015, 0.17)}, At(Vec3(x, y_back + 0.015, 0.69))});
  for (double leg : {x0 + 0.05, x1 - 0.11}) {
    scene.Box(wood, Vec3(leg, y_back - 0.03, kFoot_m), Vec3(leg + 0.06, y_back + 0.03, 0.88));
    scene.Box(wood, Vec3(leg, y_front, kFoot_m), Vec3(leg + 0.06, y_front + 0.06, 0.64));
    scene.Box(wood, Vec3(leg, y_front - 0.02, 0.64), Vec3(leg + 0.06, y_back, 0.68));
  }
}

/// What surrounds the front but is not part of it.
void AddNeighbours(SceneBuilder& scene) {
  const Paint block{"block_behind", Label::kWall}, beside{"neighbours", Label::kWall};
  scene.Box(block, Vec3(-kHalfLength_m, kWallDepth_m, kFoot_m), Vec3(kHalfLength_m, 1.5, kTop_m),
            Physics::kNone);
  scene.Box({"coping", Label::kRoof}, Vec3(-kHalfLength_m, -0.03, kTop_m), Vec3(kHalfLength_m, 1.5, 4.0));
  for (double side : {-1.0, 1.0}) {
    const double a = side * kHalfLength_m, b = side * (kHalfLength_m + 3.0);
    scene.Box(beside, Vec3(std::min(a, b), -0.2, kFoot_m), Vec3(std::max(a, b), 1.5, 4.6));
  }
}

void AddFront(SceneBuilder& scene) {
  const Paint wall = Object("wall", Label::kWall), ledge = Object("ledges", Label::kLedge);
  std::vector<Rect> openings, doorways;
  for (int bay = 0; bay < 10; ++bay) {
    const double x = BayMiddle(bay), half = 0.5 * (IsDoorBay(bay) ? kDoorWidth_m : kWindowWidth_m);
    if (IsDoorBay(bay)) {
      openings.push_back({{x - half, kFoot_m}, {x + half, kDoorTop_m}});
      doorways.push_back({{x - half - 0.16, kFoot_m}, {x + half + 0.16, 0.45}});
      AddDoor(scene, x);
    } else {
      openings.push_back({{x - half, kSill_m}, {x + half, kWindowTop_m}});
      AddWindow(scene, x);
    }
  }
  for (const Rect& r : CoverAround({{-kHalfLength_m, kFoot_m}, {kHalfLength_m, kTop_m}}, openings)) {
    scene.Box(wall, Vec3(r.min.x(), 0.0, r.min.y()), Vec3(r.max.x(), kWallDepth_m, r.max.y()));
  }
  for (const Rect& r : CoverAround({{-kHalfLength_m, kFoot_m}, {kHalfLength_m, 0.45}}, doorways)) {
    scene.Box(Object("plinth", Label::kWall), Vec3(r.min.x(), -0.06, r.min.y()),
              Vec3(r.max.x(), 0.02, r.max.y()));
  }
  scene.Box(ledge, Vec3(-kHalfLength_m, -0.09, 2.95), Vec3(kHalfLength_m, 0.02, 3.05));
  scene.Box(ledge, Vec3(-kHalfLength_m, -0.18, 3.5), Vec3(kHalfLength_m, 0.02, 3.6));
  scene.Box(ledge, Vec3(-kHalfLength_m, -0.1, 3.6), Vec3(kHalfLength_m, 0.02, 3.7));
  for (int k = 0; k <= 10; ++k) {
    AddPilaster(scene, std::clamp(-kHalfLength_m + k * kBay_m, -kHalfLength_m + 0.3, kHalfLength_m - 0.3));
  }
  for (int k : {1, 4, 7, 9}) AddDrainpipe(scene, -kHalfLength_m + k * kBay_m + 0.45);
}

constexpr double kSpawnX_m = -12.0, kSpawnY_m = -3.2;
const Rect kGround{{-22.0, -14.0}, {22.0, 1.5}};

SceneSpec Build(bool rough) {
  SceneBuilder scene;
  if (rough) {
    constexpr double kAmplitude_m = 0.04;
    AddRoughGrass(scene, kGround, kAmplitude_m, {kSpawnX_m, kSpawnY_m});
  } else {
    AddFlatGround(scene, kGround, Label::kPath);
  }
  AddFront(scene);
  AddNeighbours(scene);
  for (int bay : {3, 6}) AddBench(scene, BayMiddle(bay));
  return scene.Finish({kSpawnX_m, kSpawnY_m}, 0.0);
}

}  // namespace

SceneSpec BuildFacade() {
  return Build(false);
}
SceneSpec BuildFacadeGrass() {
  return Build(true);
}

}  // namespace atlas::scenes
