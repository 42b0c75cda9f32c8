#include "core/geometry.h"

namespace atlas::core {

Pose Interpolate(const Pose& a, const Pose& b, double u) {
  const Eigen::Quaterniond qa(a.linear()), qb(b.linear());
  return MakePose(qa.slerp(u, qb).toRotationMatrix(), (1.0 - u) * a.translation() + u * b.translation());
}

std::optional<std::pair<double, double>> Box3::Clip(const Vec3& origin, const Vec3& direction) const {
  double enter = 0.0, leave = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) {
      if (origin[axis] < min[axis] || origin[axis] > max[axis]) return std::nullopt;
      continue;
    }
    double t0 = (min[axis] - origin[axis]) / direction[axis];
    double t1 = (max[axis] - origin[axis]) / direction[axis];
    if (t0 > t1) std::swap(t0, t1);
    enter = std::max(enter, t0);
    leave = std::min(leave, t1);
    if (enter > leave) return std::nullopt;
  }
  return std::pair{enter, leave};
}

}  // namespace atlas::core
