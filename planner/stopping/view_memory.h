// What earlier views brought: places visited, views that broke their promise, the view the robot is committed
// to.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/geometry.h"

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
  void RecordSweep(const core::Pose& T_map_base, size_t new_surface);
  /// The plan sends the robot here.
  void Commit(const Promise& promise) { commitment_ = promise; }

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
  std::vector<core::Vec2> visited_;
  std::vector<core::Vec2> broken_;
  std::optional<Promise> commitment_;
  double surface_ = 0.0;
  double latest_share_ = 1.0;
};

}  // namespace atlas::planner
