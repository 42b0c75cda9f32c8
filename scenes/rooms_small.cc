// A room network of 24 x 38 m on one floor: two corridors, a hall, offices and stores, doorways 0.9 m wide.
//
// The thesis explores a small room network in simulation (4.10.7). Walls stand on a grid of lines; each wall
// is given with its doorways. All of the interior is to be mapped: floor, ceiling, walls, frames, furniture.
// A shell of masonry around it, outside the object box, hides the outer faces.
#include "core/rng.h"
#include "scenes/build/openings.h"
#include "scenes/scenes.h"
#include "scenes/town/facade_run.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Vec2;
using core::Vec3;

constexpr double kCeiling_m = 2.7, kWall_m = 0.15, kDoor_m = 0.9, kDoorHeight_m = 2.1, kJamb_m = 0.05;
constexpr double kHalfX_m = 12.0, kHalfY_m = 19.0;

const Paint kFloor{"floor", Label::kFloor, true}, kWalls{"walls", Label::kWall, true},
    kCeiling{"ceiling", Label::kLedge, true}, kFrames{"door_frames", Label::kDoor, true},
    kWindows{"windows", Label::kWindow, true}, kColumns{"columns", Label::kColumn, true};

/// A wall along x or y through `from`, with doorways and wider passages at distances from its start.
struct Opening {
  double at_m, width_m, height_m;
};
Opening Door(double at_m) {
  return {at_m, kDoor_m, kDoorHeight_m};
}
Opening Passage(double at_m, double width_m) {
  return {at_m, width_m, 2.4};
}
struct Partition {
  Vec2 from, to;
  std::vector<Opening> openings;
};

/// Jambs and head of a doorway: the wall's hole is wider by them, so that 0.9 m stay clear.
void AddFrame(SceneBuilder& scene, const core::Pose& T_map_wall, const Opening& opening) {
  constexpr double kProud_m = 0.025;
  const double half = 0.5 * opening.width_m, y = 0.5 * kWall_m + kProud_m;
  const auto box = [&](double x0, double z0, double x1, double z1, Physics physics) {
    WallBox(scene, kFrames, T_map_wall, Vec3(opening.at_m + x0, -y, z0), Vec3(opening.at_m + x1, y, z1),
            physics);
  };
  box(-half - kJamb_m, -0.05, -half, opening.height_m, Physics::kSolid);
  box(half, -0.05, half + kJamb_m, opening.height_m, Physics::kSolid);
  box(-half - kJamb_m, opening.height_m, half + kJamb_m, opening.height_m + kJamb_m, Physics::kNone);
}

void AddPartition(SceneBuilder& scene, const Partition& wall) {
  const Vec2 along = wall.to - wall.from;
  const core::Pose T =
      core::PoseFromXyzYaw(Vec3(wall.from.x(), wall.from.y(), 0), std::atan2(along.y(), along.x()));
  const double length = along.norm();
  std::vector<Rect> holes;
  for (const Opening& opening : wall.openings) {
    const double half = 0.5 * opening.width_m + kJamb_m;
    holes.push_back({{opening.at_m - half, -0.05}, {opening.at_m + half, opening.height_m + kJamb_m}});
    AddFrame(scene, T, opening);
  }
  for (const Rect& r : CoverAround({{0.0, -0.05}, {length, kCeiling_m + 0.05}}, holes)) {
    const bool low = r.min.y() < kReachHeight_m;
    WallBox(scene, kWalls, T, Vec3(r.min.x(), -0.5 * kWall_m, r.min.y()),
            Vec3(r.max.x(), 0.5 * kWall_m, r.max.y()), low ? Physics::kSolid : Physics::kNone);
  }
}

/// A corridor along x = 0 (the spine) and one across at y = 3 to 5.4; rooms on both sides.
std::vector<Partition> Partitions() {
  const double x = kHalfX_m, y = kHalfY_m;
  return {
      // The spine's west and east walls, south of the crossing.
      {{-1.25, -y}, {-1.25, 3.0}, {Door(3.2), Door(9.6), Door(15.6), Door(20.2)}},
      {{1.25, -y}, {1.25, 3.0}, {Door(4.4), Door(11.2), Door(18.4)}},
      // The crossing corridor.
      {{-x, 3.0}, {-1.25, 3.0}, {Door(2.4)}},
      {{1.25, 3.0}, {x, 3.0}, {Door(7.4)}},
      {{-x, 5.4}, {x, 5.4}, {Door(3.4), Passage(12.0, 1.8), Door(20.0)}},
      // Rooms of the west side.
      {{-x, -12.6}, {-1.25, -12.6}, {Door(6.0)}},
      {{-x, -6.4}, {-1.25, -6.4}, {}},
      {{-x, -1.0}, {-1.25, -1.0}, {Door(8.2)}},
      {{-6.8, -19.0}, {-6.8, -12.6}, {Door(4.2)}},
      // Rooms of the east side.
      {{1.25, -11.0}, {x, -11.0}, {}},
      {{1.25, -3.4}, {x, -3.4}, {Door(7.8)}},
      {{6.6, -11.0}, {6.6, -3.4}, {Door(3.6)}},
      // North of the crossing: the hall in the middle, a room on either side.
      {{-5.6, 5.4}, {-5.6, y}, {Door(3.0), Door(10.6)}},
      {{5.6, 5.4}, {5.6, y}, {Door(11.4)}},
      {{-x, 12.0}, {-5.6, 12.0}, {}},
      {{5.6, 11.0}, {x, 11.0}, {Door(2.2)}},
  };
}

void AddShell(SceneBuilder& scene) {
  const double x = kHalfX_m, y = kHalfY_m, h = 0.5 * kWall_m;
  scene.Box(kFloor, Vec3(-x - 0.4, -y - 0.4, -0.3), Vec3(x + 0.4, y + 0.4, 0.0));
  scene.Box(kCeiling, Vec3(-x - 0.4, -y - 0.4, kCeiling_m), Vec3(x + 0.4, y + 0.4, kCeiling_m + 0.2),
            Physics::kNone);
  AddPartition(scene, {{-x - h, -y}, {x + h, -y}, {}});
  AddPartition(scene, {{-x - h, y}, {x + h, y}, {}});
  AddPartition(scene, {{-x, -y}, {-x, y}, {}});
  AddPartition(scene, {{x, -y}, {x, y}, {}});
  const Paint masonry{"masonry", Label::kWall};
  const double a = h, b = 0.4;
  const auto outside = [&](const Vec3& min, const Vec3& max) {
    scene.Box(masonry, min, max, Physics::kNone);
  };
  outside(Vec3(-x - b, -y - b, 0.0), Vec3(x + b, -y - a, kCeiling_m));
  outside(Vec3(-x - b, y + a, 0.0), Vec3(x + b, y + b, kCeiling_m));
  outside(Vec3(-x - b, -y - a, 0.0), Vec3(-x - a, y + a, kCeiling_m));
  outside(Vec3(x + a, -y - a, 0.0), Vec3(x + b, y + a, kCeiling_m));
  outside(Vec3(-x - b, -y - b, -0.5), Vec3(x + b, y + b, -0.3));
  outside(Vec3(-x - b, -y - b, kCeiling_m + 0.2), Vec3(x + b, y + b, kCeiling_m + 0.4));
}

void AddTable(SceneBuilder& scene, const Vec2& at, double length, double width, double yaw_rad) {
  const Paint paint{"tables", Label::kFurniture, true};
  const core::Pose T = core::PoseFromXyzYaw(Vec3(at.x(), at.y(), 0), yaw_rad);
  const double x = 0.5 * length, y = 0.5 * width;
  WallBox(scene, paint, T, Vec3(-x, -y, 0.71), Vec3(x, y, 0.75), Physics::kSolid);
  for (double sx : {-1.0, 1.0}) {
    for (double sy : {-1.0, 1.0}) {
      const Vec3 p(sx * (x - 0.06), sy * (y - 0.06), 0.0);
      WallBox(scene, paint, T, p - Vec3(0.035, 0.035, 0.02), p + Vec3(0.035, 0.035, 0.72), Physics::kSolid);
    }
  }
}

/// A closed piece: cupboard, sideboard, crate. Doors and a plinth line are cut as thin proud panels.
void AddCabinet(SceneBuilder& scene, const Vec2& at, const Vec3& size, double yaw_rad) {
  const Paint paint{"cabinets", Label::kFurniture, true};
  const core::Pose T = core::PoseFromXyzYaw(Vec3(at.x(), at.y(), 0), yaw_rad);
  const Vec3 half = 0.5 * size;
  WallBox(scene, paint, T, Vec3(-half.x(), -half.y(), -0.02), Vec3(half.x(), half.y(), size.z()),
          Physics::kSolid);
  const int doors = std::max(1, static_cast<int>(size.x() / 0.5));
  for (int k = 0; k < doors; ++k) {
    const double x0 = -half.x() + k * size.x() / doors, x1 = x0 + size.x() / doors;
    WallBox(scene, paint, T, Vec3(x0 + 0.02, -half.y() - 0.02, 0.1),
            Vec3(x1 - 0.02, -half.y(), size.z() - 0.04));
  }
}

void AddSofa(SceneBuilder& scene, const Vec2& at, double yaw_rad) {
  const Paint paint{"sofas", Label::kFurniture, true};
  const core::Pose T = core::PoseFromXyzYaw(Vec3(at.x(), at.y(), 0), yaw_rad);
  WallBox(scene, paint, T, Vec3(-0.95, -0.42, -0.02), Vec3(0.95, 0.42, 0.42), Physics::kSolid);
  WallBox(scene, paint, T, Vec3(-0.95, 0.2, 0.4), Vec3(0.95, 0.42, 0.85));
  for (double x : {-0.95, 0.77}) WallBox(scene, paint, T, Vec3(x, -0.42, 0.4), Vec3(x + 0.18, 0.22, 0.62));
  for (double x : {-0.76, 0.01}) WallBox(scene, paint, T, Vec3(x, -0.44, 0.4), Vec3(x + 0.75, 0.2, 0.52));
}

/// Steel uprights and five boards, with boxes on some. To the robot it is one solid.
void AddShelf(SceneBuilder& scene, const Vec2& at, double length, double yaw_rad, uint64_t seed) {
  const Paint paint{"shelves", Label::kFurniture, true}, boxes{"boxes", Label::kObject, true};
  const core::Pose T = core::PoseFromXyzYaw(Vec3(at.x(), at.y(), 0), yaw_rad);
  const double x = 0.5 * length, y = 0.22;
  WallBox(scene, paint, T, Vec3(-x, -y, -0.02), Vec3(x, y, 0.12));
  scene.Collide(paint, {BoxShape{Vec3(x, y, 0.6)}, T * At(Vec3(0, 0, 0.6))});
  for (double z : {0.5, 0.9, 1.35, 1.8}) WallBox(scene, paint, T, Vec3(-x, -y, z), Vec3(x, y, z + 0.03));
  for (double sx : {-1.0, 0.0, 1.0}) {
    for (double sy : {-1.0, 1.0}) {
      const Vec3 p(sx * (x - 0.02), sy * (y - 0.02), 0.0);
      WallBox(scene, paint, T, p - Vec3(0.02, 0.02, 0.0), p + Vec3(0.02, 0.02, 1.9));
    }
  }
  core::Rng rng(seed);
  for (double z : {0.12, 0.53, 0.93, 1.38}) {
    for (double u = -x + 0.1; u + 0.45 < x; u += rng.Uniform(0.45, 0.9)) {
      const double width = rng.Uniform(0.2, 0.4), height = rng.Uniform(0.12, 0.3);
      WallBox(scene, boxes, T, Vec3(u, -0.17, z - 0.01), Vec3(u + width, 0.16, z + height));
    }
  }
}

void AddFurniture(SceneBuilder& scene) {
  const double quarter = 0.5 * core::kPi;
  AddTable(scene, {-9.4, -9.6}, 1.8, 0.8, 0.0);
  AddTable(scene, {-4.0, -16.4}, 1.6, 0.8, quarter);
  AddTable(scene, {8.6, -16.6}, 2.4, 1.1, 0.0);
  AddTable(scene, {0.6, 13.2}, 3.0, 1.2, 0.25);
  AddTable(scene, {9.6, 8.0}, 1.6, 0.8, quarter);
  AddCabinet(scene, {-11.6, -11.2}, {1.8, 0.5, 1.9}, quarter);
  AddCabinet(scene, {-9.4, -18.6}, {2.0, 0.5, 2.0}, core::kPi);
  AddCabinet(scene, {11.6, -14.0}, {1.6, 0.5, 1.1}, -quarter);
  AddCabinet(scene, {4.0, -3.75}, {1.4, 0.45, 2.0}, 0.0);
  AddCabinet(scene, {-4.4, 18.6}, {1.6, 0.5, 0.9}, 0.0);
  AddCabinet(scene, {11.6, 17.6}, {2.2, 0.5, 2.0}, -quarter);
  AddSofa(scene, {3.6, 18.4}, 0.0);
  AddSofa(scene, {4.6, 13.0}, -quarter);
  AddSofa(scene, {-11.2, 8.0}, quarter);
  AddShelf(scene, {9.4, -10.6}, 3.0, core::kPi, 1);
  AddShelf(scene, {11.68, -7.2}, 3.0, -quarter, 2);
  AddShelf(scene, {-9.6, 18.6}, 3.4, 0.0, 3);
  AddShelf(scene, {-6.9, -1.4}, 2.4, 0.0, 4);
  for (const Vec2& p : {Vec2(-2.6, 9.6), Vec2(2.6, 9.6), Vec2(-2.6, 15.6), Vec2(2.6, 15.6)}) {
    scene.Cylinder(kColumns, Vec3(p.x(), p.y(), -0.05), Vec3(p.x(), p.y(), kCeiling_m + 0.05), 0.2, 20);
  }
}

/// Recessed lights, skirting and windows set into the outer walls.
void AddFittings(SceneBuilder& scene) {
  const Paint lamps{"lights", Label::kObject, true};
  for (double y : {-16.0, -9.0, -2.0, 12.0}) {
    scene.Box(lamps, Vec3(-0.6, y - 0.15, kCeiling_m - 0.08), Vec3(0.6, y + 0.15, kCeiling_m + 0.02),
              Physics::kNone);
  }
  for (double side : {-1.0, 1.0}) {
    for (double y : {-15.8, -8.6, 8.2, 15.4}) {
      const double inner = side * (kHalfX_m - 0.5 * kWall_m);
      const auto slab = [&](const Paint& paint, double y0, double y1, double z0, double z1, double proud) {
        const double a = inner - side * proud, b = inner + side * 0.02;
        scene.Box(paint, Vec3(std::min(a, b), y0, z0), Vec3(std::max(a, b), y1, z1), Physics::kNone);
      };
      slab(kWindows, y - 0.8, y + 0.8, 1.0, 2.1, 0.01);
      slab(kFrames, y - 0.95, y + 0.95, 0.93, 1.0, 0.14);
      slab(kFrames, y - 0.87, y + 0.87, 2.1, 2.17, 0.05);
      for (double edge : {-0.87, -0.03, 0.8}) slab(kFrames, y + edge, y + edge + 0.07, 1.0, 2.1, 0.05);
    }
  }
}

}  // namespace

SceneSpec BuildRoomsSmall() {
  SceneBuilder scene;
  AddShell(scene);
  for (const Partition& wall : Partitions()) AddPartition(scene, wall);
  AddFurniture(scene);
  AddFittings(scene);
  SceneSpec spec = scene.FinishSpace({0.0, -15.0}, 0.5 * core::kPi, 0.03);
  const double x = kHalfX_m, y = kHalfY_m, h = 0.5 * kWall_m;
  spec.object_box = {Vec3(-x - h, -y - h, -0.1), Vec3(x + h, y + h, kCeiling_m + 0.1)};
  return spec;
}

}  // namespace atlas::scenes
