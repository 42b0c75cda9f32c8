#include "core/sensor_events.h"

#include <cassert>

namespace atlas::core {

Pose PoseTrajectory::At(double time_s) const {
  assert(!poses_.empty());
  const auto after = std::lower_bound(poses_.begin(), poses_.end(), time_s,
                                      [](const StampedPose& p, double t) { return p.time_s < t; });
  if (after == poses_.begin()) return poses_.front().T;
  if (after == poses_.end()) return poses_.back().T;
  const auto before = after - 1;
  const double span = after->time_s - before->time_s;
  return span <= 0.0 ? after->T : Interpolate(before->T, after->T, (time_s - before->time_s) / span);
}

}  // namespace atlas::core
