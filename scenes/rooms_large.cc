// A room network of 32 x 32 m on one floor: a room in the middle with four doorways, a corridor about it
// whose stretches end at doorways, too, and twelve rooms around that; ways lead on from room to room.
//
// After the larger network of the thesis's simulation (4.10.7), whose middle room is crossed some ten times
// by different routes. Doorways are 1.2 m wide, corridors 2.85 m. All of the interior is to be mapped.
#include <fmt/format.h>

#include "core/rng.h"
#include "scenes/scenes.h"
#include "scenes/town/interior.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Vec2;
using core::Vec3;

constexpr Storey kLargeStorey{.floor_z = 0.0, .ceiling_m = 3.0};
constexpr double kHalf_m = 16.0, kRing_m = 10.0, kBelt_m = 8.0, kMiddleX_m = 7.0, kMiddleY_m = 5.0;
constexpr uint64_t kFurnitureSeed = 410007;

Opening DoorOfLarge(double at_m) {
  return {at_m, 1.2, 2.1};
}
Opening GateOfLarge(double at_m) {
  return {at_m, 1.8, 2.4};
}

/// Openings count from the wall's start, which lies west or south.
std::vector<Partition> PartitionsOfLarge() {
  const double a = kHalf_m, r = kRing_m, b = kBelt_m, mx = kMiddleX_m, my = kMiddleY_m;
  return {
      // The middle room and the ends of the corridor's stretches west and east of it.
      {{-r, my}, {r, my}, {GateOfLarge(1.5), DoorOfLarge(6.5), GateOfLarge(18.5)}},
      {{-r, -my}, {r, -my}, {GateOfLarge(1.5), DoorOfLarge(13.5), GateOfLarge(18.5)}},
      {{-mx, -my}, {-mx, my}, {DoorOfLarge(5.0)}},
      {{mx, -my}, {mx, my}, {DoorOfLarge(5.0)}},
      // Around the corridor.
      {{-a, b},
       {a, b},
       {DoorOfLarge(3.0), DoorOfLarge(7.0), DoorOfLarge(12.0), DoorOfLarge(20.0), DoorOfLarge(25.0),
        DoorOfLarge(29.0)}},
      {{-a, -b},
       {a, -b},
       {DoorOfLarge(3.0), DoorOfLarge(7.0), DoorOfLarge(12.0), DoorOfLarge(20.0), DoorOfLarge(25.0),
        DoorOfLarge(29.0)}},
      {{-r, -b}, {-r, b}, {DoorOfLarge(5.0), DoorOfLarge(11.0)}},
      {{r, -b}, {r, b}, {DoorOfLarge(5.0), DoorOfLarge(11.0)}},
      // Rooms west and east, north and south.
      {{-a, 0}, {-r, 0}, {}},
      {{r, 0}, {a, 0}, {}},
      {{-8, b}, {-8, a}, {}},
      {{0, b}, {0, a}, {DoorOfLarge(4.0)}},
      {{8, b}, {8, a}, {}},
      {{-8, -a}, {-8, -b}, {}},
      {{0, -a}, {0, -b}, {DoorOfLarge(4.0)}},
      {{8, -a}, {8, -b}, {}},
  };
}

std::vector<Room> RoomsOfLarge() {
  const double a = kHalf_m, r = kRing_m, b = kBelt_m, mx = kMiddleX_m, my = kMiddleY_m;
  std::vector<Room> rooms;
  const auto add = [&](const std::string& name, double x0, double y0, double x1, double y1) {
    rooms.push_back({name, {Vec3(x0, y0, 0.0), Vec3(x1, y1, kLargeStorey.ceiling_m)}});
  };
  add("middle", -mx, -my, mx, my);
  add("corridor_north", -r, my, r, b);
  add("corridor_south", -r, -b, r, -my);
  add("corridor_west", -r, -my, -mx, my);
  add("corridor_east", mx, -my, r, my);
  for (int k = 0; k < 4; ++k) {
    add(fmt::format("north_{}", k + 1), -a + 8.0 * k, b, -a + 8.0 * (k + 1), a);
    add(fmt::format("south_{}", k + 1), -a + 8.0 * k, -a, -a + 8.0 * (k + 1), -b);
  }
  add("west_south", -a, -b, -r, 0);
  add("west_north", -a, 0, -r, b);
  add("east_south", r, -b, a, 0);
  add("east_north", r, 0, a, b);
  return rooms;
}

/// Floor, ceiling, outer walls, and masonry outside that hides their outer faces.
void AddShellOfLarge(SceneBuilder& scene) {
  const Paint floor{"floor", Label::kFloor, true}, ceiling{"ceiling", Label::kLedge, true},
      masonry{"masonry", Label::kWall};
  const double a = kHalf_m, h = 0.5 * kPartition_m, b = 0.4, top = kLargeStorey.ceiling_m;
  scene.Box(floor, Vec3(-a - b, -a - b, -0.3), Vec3(a + b, a + b, 0.0));
  scene.Box(ceiling, Vec3(-a - b, -a - b, top), Vec3(a + b, a + b, top + 0.2), Physics::kNone);
  AddPartition(scene, kLargeStorey, {{-a - h, -a}, {a + h, -a}, {}});
  AddPartition(scene, kLargeStorey, {{-a - h, a}, {a + h, a}, {}});
  AddPartition(scene, kLargeStorey, {{-a, -a}, {-a, a}, {}});
  AddPartition(scene, kLargeStorey, {{a, -a}, {a, a}, {}});
  const auto outside = [&](const Vec3& min, const Vec3& max) {
    scene.Box(masonry, min, max, Physics::kNone);
  };
  outside(Vec3(-a - b, -a - b, 0.0), Vec3(a + b, -a - h, top));
  outside(Vec3(-a - b, a + h, 0.0), Vec3(a + b, a + b, top));
  outside(Vec3(-a - b, -a - h, 0.0), Vec3(-a - h, a + h, top));
  outside(Vec3(a + h, -a - h, 0.0), Vec3(a + b, a + h, top));
  outside(Vec3(-a - b, -a - b, -0.5), Vec3(a + b, a + b, -0.3));
  outside(Vec3(-a - b, -a - b, top + 0.2), Vec3(a + b, a + b, top + 0.4));
}

/// No two rooms alike, along walls without doorways.
void AddFurnitureOfLarge(SceneBuilder& scene) {
  const double quarter = 0.5 * core::kPi;
  const Storey& s = kLargeStorey;
  core::Rng rng(kFurnitureSeed);
  for (int k = 0; k < 4; ++k) {
    const double x = -12.0 + 8.0 * k;
    for (double side : {-1.0, 1.0}) {
      const double wall = side * 15.6, turn = side > 0 ? 0.0 : core::kPi;
      AddCabinet(scene, s, {x + rng.Uniform(-2.5, -1.0), wall},
                 {rng.Uniform(1.0, 2.2), 0.5, rng.Uniform(0.9, 2.0)}, turn);
      if (rng.Uniform(0, 1) < 0.5) {
        AddShelf(scene, s, {x + 2.0, side * 15.68}, 2.4, turn, rng.UniformInt(1000) + 1);
      } else {
        AddSofa(scene, s, {x + 2.0, side * 15.3}, turn);
      }
    }
  }
  for (double side : {-1.0, 1.0}) {
    AddTable(scene, s, {side * 15.2, 5.0}, 1.6, 0.8, quarter);
    AddCabinet(scene, s, {side * 15.6, -4.4}, {1.8, 0.5, 1.7}, -side * quarter);
    AddShelf(scene, s, {side * 15.68, 1.8}, 2.4, -side * quarter, 70 + (side > 0 ? 1 : 0));
  }
  AddTable(scene, s, {-4.6, -3.6}, 2.4, 1.0, 0.0);
  AddTable(scene, s, {4.8, 3.4}, 1.8, 0.9, 0.4);
  AddSofa(scene, s, {2.0, 4.45}, 0.0);
  AddSofa(scene, s, {-1.2, -4.45}, core::kPi);
  AddShelf(scene, s, {-6.68, 3.0}, 2.4, quarter, 81);
  AddCabinet(scene, s, {6.6, -3.2}, {1.6, 0.5, 1.2}, -quarter);
  const Paint column{"columns", Label::kColumn, true};
  for (const Vec2& p : {Vec2(-3.2, 1.6), Vec2(3.2, -1.6)}) {
    scene.Cylinder(column, Vec3(p.x(), p.y(), -0.05), Vec3(p.x(), p.y(), s.ceiling_m + 0.05), 0.25, 20);
  }
  for (double x : {-6.0, 1.5, 6.5}) {
    AddCabinet(scene, s, {x, 7.68}, {rng.Uniform(0.6, 1.2), 0.4, rng.Uniform(0.8, 1.9)}, 0.0);
    AddCabinet(scene, s, {-x, -7.68}, {rng.Uniform(0.6, 1.2), 0.4, rng.Uniform(0.8, 1.9)}, core::kPi);
  }
}

}  // namespace

SceneSpec BuildRoomsLarge() {
  SceneBuilder scene;
  AddShellOfLarge(scene);
  for (const Partition& wall : PartitionsOfLarge()) AddPartition(scene, kLargeStorey, wall);
  AddFurnitureOfLarge(scene);
  SceneSpec spec = scene.FinishSpace({0.0, 0.0}, 0.0, 0.03);
  const double a = kHalf_m + 0.5 * kPartition_m;
  spec.object_box = {Vec3(-a, -a, -0.1), Vec3(a, a, kLargeStorey.ceiling_m + 0.1)};
  spec.rooms = RoomsOfLarge();
  return spec;
}

}  // namespace atlas::scenes
