// What is asked of the terrain, answered by the level that a place lies on.
#pragma once

#include <vector>

#include "mapping/terrain/elevation_map.h"
#include "mapping/terrain/traversability.h"

namespace atlas::mapping::terrain {

/// What queries read, and where the robot was then. No level before the first.
struct Published {
  std::vector<TerrainImage> levels;  ///< the robot's first, all over the same square
  core::Vec2 centre = core::Vec2::Zero();
  float ground_m = 0.0f;
};

/// As TraversableGround has them, in the odometry frame.
///
/// Where two levels hold the same ground both answer, and it is free where it is so on either: at the line
/// where a level goes from one floor to another that lies above, it sees a step that is none.
class LevelQueries {
 public:
  /// @param published  outlives this, and is read anew by every query.
  LevelQueries(const TerrainParams& params, const core::RobotExtent& robot, const Published* published)
      : params_(params), robot_(robot), published_(*published), inverse_cell_(1.0 / params.cell_m) {}

  /// Index into the images, or -1 outside.
  int IndexAt(double x, double y) const;

  TraversableGround::Levels LevelsAt(const core::Vec2& p_odom) const;
  double Traversability(const core::Vec3& p_odom) const;
  GroundKind KindAt(const core::Vec3& p_odom) const;
  bool FootprintFree(const core::Vec3& p_odom, double yaw_rad) const;
  bool CircleFree(const core::Vec3& p_odom) const;
  TraversableGround::Surface SurfaceAt(const core::Vec3& p_odom) const;

 private:
  /// The levels that answer for a place, the nearest first.
  struct Answering {
    std::array<const TerrainImage*, kMostLevels> level{};
    int count = 0;
    size_t cell = 0;
    const TerrainImage* const* begin() const { return level.data(); }
    const TerrainImage* const* end() const { return level.data() + count; }
  };
  struct Rectangle {
    core::Vec2 along;
    double half_length_m, half_width_m;
  };
  Answering At(const core::Vec3& p_odom) const;
  double Clearance(size_t cell, const std::vector<int16_t>& distance2) const;
  bool RectangleClear(const core::Vec2& centre, const Rectangle& shape,
                      const std::vector<int16_t>& distance2) const;

  const TerrainParams& params_;
  const core::RobotExtent& robot_;
  const Published& published_;
  double inverse_cell_;
};

}  // namespace atlas::mapping::terrain
