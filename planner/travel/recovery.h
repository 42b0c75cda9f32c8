// What a robot does that finds no place to go to from where it stands.
#pragma once

#include <optional>
#include <vector>

#include "core/keyframe.h"
#include "mapping/terrain/traversable_ground.h"

namespace atlas::planner {

/// Standing somewhere is proof that the ground there carries, whatever the terrain map holds of it. Before
/// the robot gives up it tries, a plan each:
///   1. back along the way it came (once; it learnt of an overhang here, say, and knows that way to be free);
///   2. a quarter turn where it stands: the next sweep looks abeam, where the last one was blind;
///   3. a small step to the side where most ground about it is free, heading there.
class Recovery {
 public:
  /// Where to scan next; the last point of the path is the view's place.
  struct Move {
    std::vector<core::Vec2> path_map;  ///< from the robot
    double yaw_rad = 0.0;
  };

  /// The robot sets out on this way to a view.
  void SetOut(const std::vector<core::Vec3>& path_map, const core::PoseSource& poses);
  /// The next thing to try, or nothing when all was tried since the robot last set out.
  std::optional<Move> Next(const core::Pose& T_map_base, const mapping::TraversableGround& ground,
                           const core::PoseSource& poses);

 private:
  std::optional<Move> Back(const core::Vec2& here, const core::PoseSource& poses);

  std::vector<core::AnchoredPoint> way_here_;
  bool turned_ = false, stepped_ = false;
};

}  // namespace atlas::planner
