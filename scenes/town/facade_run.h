// Fronts of town buildings: a wall of bays with recessed windows, doors, pilasters, ledges and a cornice.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scenes/build/openings.h"
#include "scenes/build/scene_builder.h"

namespace atlas::scenes {

/// A straight front of `length_m`: the wall's outer plane is local y = 0, x runs along it, +y into the
/// building, z = 0 is the ground it stands on.
struct FacadeRun {
  core::Pose T_map_wall = core::Pose::Identity();
  double length_m = 16.0;
  int storeys = 3;
  double storey_m = 3.6;
  double bay_m = 4.0;             ///< about: as many whole bays as fit best
  double foot_m = -0.3;           ///< the wall reaches down to here
  std::vector<int> door_bays;     ///< bays with a door on the ground floor; others have windows
  bool ornate = false;            ///< pilasters, string courses, glazing bars, parapet
  std::optional<Rect> archway;    ///< an opening in local x and z that `AddVault` closes above
  std::string name = "building";  ///< of the parts: "NAME_walls", "NAME_windows", ...

  double height_m() const { return storeys * storey_m; }
  int bays() const;
};

/// Depth of the front's wall; the building's core lies behind it.
constexpr double kFrontDepth_m = 0.5;

void AddFacadeRun(SceneBuilder& scene, const FacadeRun& run);

/// A barrel vault over a passage from local y0 to y1 between walls at |x - middle| = half_width: fills from
/// the arc up to `top_z`. The arc springs at `spring_z`. @pre top_z above the crown
void AddVault(SceneBuilder& scene, const Paint& paint, const core::Pose& T_map_wall, double middle_x,
              double half_width_m, double spring_z, double top_z, double y0, double y1);

/// A box given in the frame of a wall.
void WallBox(SceneBuilder& scene, const Paint& paint, const core::Pose& T_map_wall, const core::Vec3& min,
             const core::Vec3& max, Physics physics = Physics::kNone);

}  // namespace atlas::scenes
