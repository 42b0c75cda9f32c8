#include "experiments/judge/place_errors.h"

#include <cmath>

namespace atlas::experiments {

using core::Pose;

void PlaceErrors::Observe(const Place& place) {
  if (places_.empty() || places_.back().base.keyframe != place.base.keyframe) places_.push_back(place);
}

std::optional<TrajectoryErrors> PlaceErrors::Errors(const core::PoseSource& poses) const {
  if (places_.empty()) return std::nullopt;
  const Pose T_map_odom_first = places_.front().T_map_base_true * places_.front().T_odom_base.inverse();
  double odometry = 0.0, believed = 0.0, corrected = 0.0;
  for (const Place& place : places_) {
    const core::Vec3 truth = place.T_map_base_true.translation();
    odometry += (T_map_odom_first * place.T_odom_base.translation() - truth).squaredNorm();
    believed += (place.T_map_base.translation() - truth).squaredNorm();
    corrected += (place.base.T_map_here(poses).translation() - truth).squaredNorm();
  }
  const auto n = static_cast<double>(places_.size());
  return TrajectoryErrors{std::sqrt(odometry / n), std::sqrt(believed / n), std::sqrt(corrected / n),
                          places_.size()};
}

}  // namespace atlas::experiments
