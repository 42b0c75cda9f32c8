// Ways that are too narrow for the robot, and the ground beyond them: what planning leaves out, by name.
#pragma once

#include <cstdint>
#include <vector>

#include "core/keyframe.h"
#include "planner/decision.h"
#include "planner/views/candidates.h"
#include "planner/views/walkable.h"

namespace atlas::planner {

/// What the robot needs.
struct Footprint {
  double half_width_m = 0.33;
  double turning_radius_m = 0.55;
  double edge_clearance_m = 0.10;  ///< kept from drops besides
};

/// All such ways of the level that the robot stands on, in the terrain's window. The widest way (greatest
/// least clearance) from the ground that `tree` covers leads to each place beyond; ways through one narrow
/// place are one. Left out are ways that end at ground not seen yet on either side of the narrow place: a
/// look may widen them.
std::vector<BlockedWay> FindBlockedWays(const Walkable& walkable, const CandidateTree& tree,
                                        const Footprint& footprint);

/// Blocked ways over all plans, beyond the window of the terrain map too; kept relative to keyframes.
class BlockedWays {
 public:
  /// Takes what a plan found in place of what was known in its window, and forgets ways whose far side `tree`
  /// reaches.
  void Learn(const Walkable& walkable, const CandidateTree& tree, const std::vector<BlockedWay>& found,
             const core::PoseSource& poses);
  std::vector<BlockedWay> ways() const;

  /// The ground points beyond all ways.
  std::vector<core::Vec3> PlacesBeyond() const;
  /// What views from there are worth, in the same order; a way is worth the best of its own, and promises
  /// something from `least` on.
  void SetWorth(const std::vector<double>& shares, double least);

 private:
  /// A point, anchored to the keyframe that was the youngest when it was found, and where that puts it now.
  struct Place {
    core::AnchoredPoint anchor;
    core::Vec3 p_map = core::Vec3::Zero();
  };
  struct Known {
    BlockedWay way;  ///< but for its points
    Place middle;
    std::vector<Place> beyond;
  };
  static Known Anchored(const BlockedWay& way, const core::PoseSource& poses);
  void Correct(const core::PoseSource& poses);
  /// Takes the place of a way that is known, and keeps that one's points.
  void Add(Known way);

  std::vector<Known> known_;
  uint64_t version_ = 0;
};

}  // namespace atlas::planner
