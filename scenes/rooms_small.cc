// A room network of 24 x 38 m on one floor: two corridors, a hall, offices and stores, doorways 0.9 m wide.
//
// The thesis explores a small room network in simulation (4.10.7). Walls stand on a grid of lines; each wall
// is given with its doorways. All of the interior is to be mapped: floor, ceiling, walls, frames, furniture.
// A shell of masonry around it, outside the object box, hides the outer faces.
#include "scenes/scenes.h"
#include "scenes/town/interior.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Vec2;
using core::Vec3;

constexpr Storey kStorey;
constexpr double kCeiling_m = kStorey.ceiling_m, kWall_m = kPartition_m, kDoor_m = 0.9, kDoorHeight_m = 2.1;
constexpr double kHalfX_m = 12.0, kHalfY_m = 19.0;

const Paint kFloor{"floor", Label::kFloor, true}, kCeiling{"ceiling", Label::kLedge, true},
    kFrames{"door_frames", Label::kDoor, true}, kWindows{"windows", Label::kWindow, true},
    kColumns{"columns", Label::kColumn, true};

Opening Door(double at_m) {
  return {at_m, kDoor_m, kDoorHeight_m};
}
Opening Passage(double at_m, double width_m) {
  return {at_m, width_m, 2.4};
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
  AddPartition(scene, kStorey, {{-x - h, -y}, {x + h, -y}, {}});
  AddPartition(scene, kStorey, {{-x - h, y}, {x + h, y}, {}});
  AddPartition(scene, kStorey, {{-x, -y}, {-x, y}, {}});
  AddPartition(scene, kStorey, {{x, -y}, {x, y}, {}});
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

void AddFurniture(SceneBuilder& scene) {
  const double quarter = 0.5 * core::kPi;
  AddTable(scene, kStorey, {-9.4, -9.6}, 1.8, 0.8, 0.0);
  AddTable(scene, kStorey, {-4.0, -16.4}, 1.6, 0.8, quarter);
  AddTable(scene, kStorey, {8.6, -16.6}, 2.4, 1.1, 0.0);
  AddTable(scene, kStorey, {0.6, 13.2}, 3.0, 1.2, 0.25);
  AddTable(scene, kStorey, {9.6, 8.0}, 1.6, 0.8, quarter);
  AddCabinet(scene, kStorey, {-11.6, -11.2}, {1.8, 0.5, 1.9}, quarter);
  AddCabinet(scene, kStorey, {-9.4, -18.6}, {2.0, 0.5, 2.0}, core::kPi);
  AddCabinet(scene, kStorey, {11.6, -14.0}, {1.6, 0.5, 1.1}, -quarter);
  AddCabinet(scene, kStorey, {4.0, -3.75}, {1.4, 0.45, 2.0}, 0.0);
  AddCabinet(scene, kStorey, {-4.4, 18.6}, {1.6, 0.5, 0.9}, 0.0);
  AddCabinet(scene, kStorey, {11.6, 17.6}, {2.2, 0.5, 2.0}, -quarter);
  AddSofa(scene, kStorey, {3.6, 18.4}, 0.0);
  AddSofa(scene, kStorey, {4.6, 13.0}, -quarter);
  AddSofa(scene, kStorey, {-11.2, 8.0}, quarter);
  AddShelf(scene, kStorey, {9.4, -10.6}, 3.0, core::kPi, 1);
  AddShelf(scene, kStorey, {11.68, -7.2}, 3.0, -quarter, 2);
  AddShelf(scene, kStorey, {-9.6, 18.6}, 3.4, 0.0, 3);
  AddShelf(scene, kStorey, {-6.9, -1.4}, 2.4, 0.0, 4);
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

/// Rooms end at doorways; the two corridors are one, since nothing stands between them.
std::vector<Room> RoomsOfRoomsSmall() {
  const double x = kHalfX_m, y = kHalfY_m, z = kCeiling_m;
  const auto room = [z](const char* name, double x0, double y0, double x1, double y1) {
    return Room{name, {Vec3(x0, y0, 0.0), Vec3(x1, y1, z)}};
  };
  return {room("corridor", -1.25, -y, 1.25, 3.0),        room("corridor", -x, 3.0, x, 5.4),
          room("west_store", -x, -y, -6.8, -12.6),       room("west_office_1", -6.8, -y, -1.25, -12.6),
          room("west_office_2", -x, -12.6, -1.25, -6.4), room("west_office_3", -x, -6.4, -1.25, -1.0),
          room("west_office_4", -x, -1.0, -1.25, 3.0),   room("east_office_1", 1.25, -y, x, -11.0),
          room("east_office_2", 1.25, -11.0, 6.6, -3.4), room("east_store", 6.6, -11.0, x, -3.4),
          room("east_office_3", 1.25, -3.4, x, 3.0),     room("hall", -5.6, 5.4, 5.6, y),
          room("north_west_1", -x, 5.4, -5.6, 12.0),     room("north_west_2", -x, 12.0, -5.6, y),
          room("north_east_1", 5.6, 5.4, x, 11.0),       room("north_east_2", 5.6, 11.0, x, y)};
}

}  // namespace

SceneSpec BuildRoomsSmall() {
  SceneBuilder scene;
  AddShell(scene);
  for (const Partition& wall : Partitions()) AddPartition(scene, kStorey, wall);
  AddFurniture(scene);
  AddFittings(scene);
  SceneSpec spec = scene.FinishSpace({0.0, -15.0}, 0.5 * core::kPi, 0.03);
  const double x = kHalfX_m, y = kHalfY_m, h = 0.5 * kWall_m;
  spec.object_box = {Vec3(-x - h, -y - h, -0.1), Vec3(x + h, y + h, kCeiling_m + 0.1)};
  spec.rooms = RoomsOfRoomsSmall();
  return spec;
}

}  // namespace atlas::scenes
