// What earlier views brought: places visited, views that broke their promise, the view the robot is committed
// to. Kept relative to keyframes, so that a correction of the map moves all of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/keyframe.h"

namespace atlas::planner {

/// A view that a plan chose and its robot set out for.
struct Promise {
  core::Vec2 p_map = core::Vec2::Zero();
  double yaw_rad = 0.0;
};

class ViewMemory {
 public:
  /// A sweep was taken here and added this many surface voxels. Where the robot was sent here by a promise
  /// and the sweep added next to nothing (0.5 % of what is known), the promise counts as broken.
  void RecordSweep(const core::Pose& T_map_base, size_t new_surface, const core::PoseSource& poses);
  /// The plan sends the robot here.
  void Commit(const Promise& promise, const core::PoseSource& poses);
  /// Moves everything to where its keyframe lies now.
  void Correct(const core::PoseSource& poses);

  /// Broken promises within 0.75 m.
  int BrokenPromisesNear(const core::Vec2& p_map) const;
  /// What promises about here are worth, in [0, 1]: 1 - exp(-(d / radius_m)^2) for each that was broken at a
  /// distance d, multiplied. @pre radius_m > 0.
  double TrustAt(const core::Vec2& p_map, double radius_m) const;
  const std::vector<core::Vec2>& visited() const { return visited_; }
  const std::optional<Promise>& commitment() const { return commitment_; }
  double surface_seen() const { return surface_; }  ///< voxels, over all sweeps
  /// Newly seen share of all surface seen so far, by the latest sweep; 1 before any.
  double latest_surface_share() const { return latest_share_; }

 private:
  std::vector<core::AnchoredPoint> anchors_;  ///< of visited_, in its order
  std::vector<core::Vec2> visited_;
  std::vector<size_t> broken_;  ///< of visited_
  std::optional<Promise> commitment_;
  core::Anchor commitment_anchor_;
  uint64_t version_ = 0;  ///< of the poses that all is posed by
  double surface_ = 0.0;
  double latest_share_ = 1.0;
};

}  // namespace atlas::planner
