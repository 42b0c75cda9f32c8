// The inside of buildings: walls with doorways, furniture. Heights count from the floor of a storey.
#pragma once

#include <cstdint>
#include <vector>

#include "scenes/build/scene_builder.h"

namespace atlas::scenes {

struct Storey {
  double floor_z = 0.0;
  double ceiling_m = 2.7;  ///< above the floor
};

constexpr double kPartition_m = 0.15;  ///< thickness of a wall

/// A doorway or a passage, its middle at a distance from the wall's start; its clear size.
struct Opening {
  double at_m, width_m, height_m;
};
/// A wall along x or y, with its openings, `kPartition_m` thick about its line.
struct Partition {
  core::Vec2 from, to;
  std::vector<Opening> openings;
};
/// With jambs and heads about the openings; from below the floor into the ceiling.
void AddPartition(SceneBuilder& scene, const Storey& storey, const Partition& wall);

void AddTable(SceneBuilder& scene, const Storey& storey, const core::Vec2& at, double length, double width,
              double yaw_rad);
/// A closed piece: cupboard, sideboard, crate. Doors and a plinth line are cut as thin proud panels.
void AddCabinet(SceneBuilder& scene, const Storey& storey, const core::Vec2& at, const core::Vec3& size,
                double yaw_rad);
void AddSofa(SceneBuilder& scene, const Storey& storey, const core::Vec2& at, double yaw_rad);
/// Steel uprights and five boards, with boxes on some. To the robot it is one solid.
void AddShelf(SceneBuilder& scene, const Storey& storey, const core::Vec2& at, double length, double yaw_rad,
              uint64_t seed);

}  // namespace atlas::scenes
