#include "planner/travel/recovery.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace atlas::planner {
namespace {

using core::Vec2;

/// Farther from the end of the way here, the robot is not on it.
constexpr double kOffTheWay_m = 0.5;
constexpr double kStep_m = 0.3;
constexpr int kDirections = 16;
/// Free ground ahead is counted up to here, every kSample_m.
constexpr double kAhead_m = 1.2, kSample_m = 0.1;

/// Samples of free ground straight ahead of `here`.
int FreeAhead(const mapping::TraversableGround& ground, const Vec2& here, double yaw_rad) {
  int free = 0;
  for (double s = kSample_m; s <= kAhead_m; s += kSample_m) {
    const core::Vec3 p = ground.OnRobotsLevel(here + s * Vec2(std::cos(yaw_rad), std::sin(yaw_rad)), 0.0);
    free += ground.KindAt(p) == mapping::GroundKind::kFree;
  }
  return free;
}

}  // namespace

void Recovery::SetOut(const std::vector<core::Vec3>& path_map, const core::PoseSource& poses) {
  way_here_.clear();
  for (const core::Vec3& p : path_map) way_here_.push_back(core::AnchoredPoint::At(p, poses));
  turned_ = stepped_ = false;
}

std::optional<Recovery::Move> Recovery::Next(const core::Pose& T_map_base,
                                             const mapping::TraversableGround& ground,
                                             const core::PoseSource& poses) {
  const Vec2 here = T_map_base.translation().head<2>();
  const double yaw = core::YawOf(T_map_base.linear());
  if (auto back = Back(here, poses)) return back;
  if (!std::exchange(turned_, true)) return Move{{here}, core::WrapAngle(yaw + 0.5 * core::kPi)};
  if (std::exchange(stepped_, true)) return std::nullopt;
  int most = 0;
  double best = yaw;
  for (int k = 0; k < kDirections; ++k) {
    const double direction = core::WrapAngle(yaw + 2.0 * core::kPi * k / kDirections);
    const int free = FreeAhead(ground, here, direction);
    if (free > most) {
      most = free;
      best = direction;
    }
  }
  if (most == 0) return std::nullopt;
  return Move{{here, here + kStep_m * Vec2(std::cos(best), std::sin(best))}, best};
}

std::optional<Recovery::Move> Recovery::Back(const Vec2& here, const core::PoseSource& poses) {
  std::vector<Vec2> way;
  for (const core::AnchoredPoint& p : std::exchange(way_here_, {})) way.push_back(p.p_map(poses).head<2>());
  if (way.size() < 2 || (way.back() - here).norm() > kOffTheWay_m) return std::nullopt;
  std::reverse(way.begin(), way.end());
  way.front() = here;
  const Vec2 last = way.back() - way[way.size() - 2];
  return Move{way, std::atan2(last.y(), last.x())};
}

}  // namespace atlas::planner
