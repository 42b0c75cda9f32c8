// How far the robot was from where it believed to be: at each keyframe, by the truth of that moment.
#pragma once

#include <optional>
#include <vector>

#include "core/keyframe.h"

namespace atlas::experiments {

/// Absolute trajectory errors: root mean squares over keyframes of the base's distance to the truth, metres.
/// Nothing is aligned: map and truth begin as one.
struct TrajectoryErrors {
  double odometry_m = 0.0;   ///< of odometry alone
  double believed_m = 0.0;   ///< of what was believed at the time
  double corrected_m = 0.0;  ///< of what all loops since then have made of it
  size_t keyframes = 0;
};

class PlaceErrors {
 public:
  /// The base when a keyframe began. Further ones of the same keyframe are passed by.
  struct Place {
    core::Anchor base;
    core::Pose T_map_base = core::Pose::Identity();       ///< as believed
    core::Pose T_odom_base = core::Pose::Identity();      ///< odometry's
    core::Pose T_map_base_true = core::Pose::Identity();  ///< as it was
  };
  void Observe(const Place& place);
  /// One a keyframe.
  const std::vector<Place>& places() const { return places_; }
  /// Nothing before the first.
  std::optional<TrajectoryErrors> Errors(const core::PoseSource& poses) const;

 private:
  std::vector<Place> places_;
};

}  // namespace atlas::experiments
