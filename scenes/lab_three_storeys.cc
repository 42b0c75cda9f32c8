// A laboratory of 28 x 16 m on three floors: a corridor along the south, two rows of rooms behind it, and a
// hall in the east with ramps from floor to floor.
//
// After the thesis's research lab (4.10.6). Floors lie 3.2 m above one another; a ramp rises 1.6 m over 7.5 m
// (12 degrees) to a landing, the next one back over the way. Doorways are 1.2 m wide. All of the interior is
// to be mapped.
//
//      y 8  +------+------+------+------+------+
//           | back | back | back | back | ramps|   a: up to the landing (north), b: back to the next floor
//       1.2 +--  --+-- ---+--  --+--  --+ a  b |
//           | front| front| front| front|      |
//      -5.6 +--  --+--  --+--  --+--  --+      |
//           | corridor                         |
//        -8 +---------------------------+------+
//         x -14   -8     -2      4     10     14
#include <fmt/format.h>

#include "core/rng.h"
#include "scenes/build/openings.h"
#include "scenes/scenes.h"
#include "scenes/town/interior.h"

namespace atlas::scenes {
namespace {

using core::Label;
using core::Vec2;
using core::Vec3;

constexpr int kFloors = 3;
constexpr double kRise_m = 3.2, kSlab_m = 0.4;
constexpr double kWest_m = -14.0, kHall_m = 10.0, kEast_m = 14.0, kSouth_m = -8.0, kNorth_m = 8.0;
constexpr double kFront_m = -5.6, kBack_m = 1.2;
constexpr double kRampFoot_m = -3.75, kRampTop_m = 3.75, kLanding_m = 6.2, kFlight_m = 12.0, kGap_m = 0.1;
constexpr double kColumnsOfRooms[] = {-14.0, -8.0, -2.0, 4.0, 10.0};

const Paint kSlabs{"floors", Label::kFloor, true}, kRamps{"ramps", Label::kPath, true},
    kRails{"rails", Label::kRail, true}, kMasonry{"masonry", Label::kWall};

Storey StoreyAt(int floor) {
  return {.floor_z = kRise_m * floor, .ceiling_m = kRise_m - kSlab_m};
}

Opening DoorOfLab(double at_m) {
  return {at_m, 1.2, 2.1};
}

/// Where doorways stand differs from floor to floor.
std::vector<Partition> PartitionsOfLab(int floor) {
  const double shift = 0.6 * (floor - 1);
  std::vector<Partition> walls = {
      {{kWest_m, kFront_m},
       {kHall_m, kFront_m},
       {DoorOfLab(3.0 + shift), DoorOfLab(9.0 - shift), DoorOfLab(15.0 + shift), DoorOfLab(21.0)}},
      {{kWest_m, kBack_m},
       {kHall_m, kBack_m},
       {DoorOfLab(2.2 - shift), DoorOfLab(9.8 + shift), DoorOfLab(14.2), DoorOfLab(21.6 - shift)}},
      {{kHall_m, kSouth_m}, {kHall_m, kNorth_m}, {DoorOfLab(1.2)}},
  };
  // Between rooms of a row: some join, so that there is more than one way about.
  const bool joined[kFloors][3] = {{true, false, true}, {false, true, true}, {true, true, false}};
  for (int k = 0; k < 3; ++k) {
    const double x = kColumnsOfRooms[k + 1];
    walls.push_back({{x, kFront_m}, {x, kBack_m}, {}});
    std::vector<Opening> doors;
    if (joined[floor][k]) doors.push_back(DoorOfLab(3.4 + shift));
    walls.push_back({{x, kBack_m}, {x, kNorth_m}, doors});
  }
  return walls;
}

std::vector<Room> RoomsOfLab() {
  std::vector<Room> rooms;
  for (int floor = 0; floor < kFloors; ++floor) {
    const double z0 = kRise_m * floor - (floor > 0 ? 0.5 * kSlab_m : 0.0),
                 z1 = kRise_m * (floor + 1) - 0.5 * kSlab_m;
    const auto add = [&](const std::string& name, double x0, double y0, double x1, double y1) {
      rooms.push_back({fmt::format("floor_{}_{}", floor, name), {Vec3(x0, y0, z0), Vec3(x1, y1, z1)}});
    };
    add("corridor", kWest_m, kSouth_m, kHall_m, kFront_m);
    add("ramps", kHall_m, kSouth_m, kEast_m, kNorth_m);
    for (int k = 0; k < 4; ++k) {
      const double x0 = kColumnsOfRooms[k], x1 = kColumnsOfRooms[k + 1];
      add(fmt::format("front_{}", k + 1), x0, kFront_m, x1, kBack_m);
      add(fmt::format("back_{}", k + 1), x0, kBack_m, x1, kNorth_m);
    }
  }
  return rooms;
}

/// The slab under a floor; above the ground it leaves the ramps open.
void AddSlab(SceneBuilder& scene, int floor) {
  const double b = 0.4, z = kRise_m * floor;
  const Rect all{{kWest_m - b, kSouth_m - b}, {kEast_m + b, kNorth_m + b}};
  std::vector<Rect> holes;
  if (floor > 0) holes.push_back({{kHall_m + 0.5 * kPartition_m, kRampFoot_m}, {kEast_m, kNorth_m}});
  for (const Rect& r : CoverAround(all, holes)) {
    scene.Box(kSlabs, Vec3(r.min.x(), r.min.y(), z - kSlab_m), Vec3(r.max.x(), r.max.y(), z));
  }
}

/// A flight along y over `plan`.
void AddFlight(SceneBuilder& scene, const Rect& plan, double z_south, double z_north) {
  constexpr double kThick_m = 0.2;
  const double x0 = plan.min.x(), x1 = plan.max.x(), y0 = plan.min.y(), y1 = plan.max.y();
  const auto end = [&](double y, double z) {
    return Ring{Vec3(x0, y, z - kThick_m), Vec3(x0, y, z), Vec3(x1, y, z), Vec3(x1, y, z - kThick_m)};
  };
  scene.Convex(kRamps, MakeLoft({end(y0, z_south), end(y1, z_north)}));
}

/// From a floor to the one above it.
void AddRamps(SceneBuilder& scene, int floor) {
  const double z = kRise_m * floor, half = 0.5 * kRise_m, w = kHall_m + 0.5 * kPartition_m,
               e = kEast_m - 0.5 * kPartition_m;
  AddFlight(scene, {{w, kRampFoot_m}, {kFlight_m - kGap_m, kRampTop_m}}, z, z + half);
  AddFlight(scene, {{kFlight_m + kGap_m, kRampFoot_m}, {e, kRampTop_m}}, z + 2.0 * half, z + half);
  scene.SetFloor(z + half);
  scene.Box(kRamps, Vec3(w, kRampTop_m, z + half - 0.2), Vec3(e, kLanding_m, z + half));
  // What closes the landing, and the way's end on the uppermost floor.
  scene.Box(kRails, Vec3(w, kLanding_m, z + half - 0.2), Vec3(e, kLanding_m + 0.1, z + half + 1.0));
  if (floor + 2 == kFloors) {
    const double up = z + kRise_m;
    scene.SetFloor(up);
    scene.Box(kRails, Vec3(w, kRampFoot_m - 0.1, up - 0.2), Vec3(kFlight_m + kGap_m, kRampFoot_m, up + 1.0));
  }
}

void AddShellOfLab(SceneBuilder& scene) {
  const double h = 0.5 * kPartition_m, b = 0.4, top = kRise_m * kFloors - kSlab_m;
  for (int floor = 0; floor < kFloors; ++floor) {
    scene.SetFloor(kRise_m * floor);
    const Storey storey = StoreyAt(floor);
    AddPartition(scene, storey, {{kWest_m - h, kSouth_m}, {kEast_m + h, kSouth_m}, {}});
    AddPartition(scene, storey, {{kWest_m - h, kNorth_m}, {kEast_m + h, kNorth_m}, {}});
    AddPartition(scene, storey, {{kWest_m, kSouth_m}, {kWest_m, kNorth_m}, {}});
    AddPartition(scene, storey, {{kEast_m, kSouth_m}, {kEast_m, kNorth_m}, {}});
  }
  scene.SetFloor(0.0);
  const Paint ceiling{"ceiling", Label::kLedge, true};
  scene.Box(ceiling, Vec3(kWest_m - b, kSouth_m - b, top), Vec3(kEast_m + b, kNorth_m + b, top + 0.2),
            Physics::kNone);
  const auto outside = [&](const Vec3& min, const Vec3& max) {
    scene.Box(kMasonry, min, max, Physics::kNone);
  };
  outside(Vec3(kWest_m - b, kSouth_m - b, -0.2), Vec3(kEast_m + b, kSouth_m - h, top + 0.1));
  outside(Vec3(kWest_m - b, kNorth_m + h, -0.2), Vec3(kEast_m + b, kNorth_m + b, top + 0.1));
  outside(Vec3(kWest_m - b, kSouth_m - h, -0.2), Vec3(kWest_m - h, kNorth_m + h, top + 0.1));
  outside(Vec3(kEast_m + h, kSouth_m - h, -0.2), Vec3(kEast_m + b, kNorth_m + h, top + 0.1));
  outside(Vec3(kWest_m - b, kSouth_m - b, -kSlab_m - 0.2), Vec3(kEast_m + b, kNorth_m + b, -kSlab_m));
  outside(Vec3(kWest_m - b, kSouth_m - b, top + 0.2), Vec3(kEast_m + b, kNorth_m + b, top + 0.4));
}

/// Along walls without doorways, no two rooms alike.
void AddFurnitureOfLab(SceneBuilder& scene, int floor, core::Rng* rng) {
  const Storey storey = StoreyAt(floor);
  const double quarter = 0.5 * core::kPi;
  for (int k = 0; k < 4; ++k) {
    const double west = kColumnsOfRooms[k], mid = west + 3.0;
    AddTable(scene, storey, {west + 0.75, -2.2 + rng->Uniform(-1.0, 0.4)}, rng->Uniform(1.4, 2.2), 0.8,
             quarter);
    AddCabinet(scene, storey, {west + 5.65, -3.2 + rng->Uniform(-0.6, 0.6)},
               {rng->Uniform(1.0, 1.8), 0.5, rng->Uniform(0.9, 2.0)}, -quarter);
    if ((k + floor) % 2 == 0) {
      AddShelf(scene, storey, {mid + rng->Uniform(-0.8, 0.8), kNorth_m - 0.32}, 2.4, 0.0,
               100 * floor + k + 1);
    } else {
      AddSofa(scene, storey, {mid + rng->Uniform(-0.8, 0.8), kNorth_m - 0.55}, 0.0);
    }
    AddTable(scene, storey, {west + 5.2, 2.3}, rng->Uniform(1.0, 1.4), 0.7, quarter);
  }
  for (double x : {-10.6, -1.4, 5.8}) {
    AddCabinet(scene, storey, {x + rng->Uniform(-0.6, 0.6), kSouth_m + 0.28},
               {rng->Uniform(0.6, 1.4), 0.4, 1.1}, core::kPi);
  }
}

}  // namespace

SceneSpec BuildLabThreeStoreys() {
  SceneBuilder scene;
  core::Rng rng(410006);
  AddShellOfLab(scene);
  for (int floor = 0; floor < kFloors; ++floor) {
    scene.SetFloor(kRise_m * floor);
    AddSlab(scene, floor);
    for (const Partition& wall : PartitionsOfLab(floor)) AddPartition(scene, StoreyAt(floor), wall);
    AddFurnitureOfLab(scene, floor, &rng);
    if (floor + 1 < kFloors) AddRamps(scene, floor);
  }
  SceneSpec spec = scene.FinishSpace({-12.5, -6.8}, 0.0, 0.03);
  const double h = 0.5 * kPartition_m;
  spec.object_box = {Vec3(kWest_m - h, kSouth_m - h, -0.1),
                     Vec3(kEast_m + h, kNorth_m + h, kRise_m * kFloors - kSlab_m + 0.1)};
  spec.rooms = RoomsOfLab();
  return spec;
}

}  // namespace atlas::scenes
