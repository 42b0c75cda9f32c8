#include "sim/locomotion/path_tracker.h"

namespace atlas::sim {
namespace {

using core::Vec2;

constexpr double kLookaheadM = 0.18;
constexpr double kHeadingAheadM = 0.35;  ///< the body turns before a corner
constexpr double kYawGain = 2.5, kMaxYawRate = 0.9;
constexpr double kTurnFrom = 1.0, kTurnUntil = 0.35;  ///< heading error at which the robot turns on the spot
constexpr double kLateralMps = 0.22;
constexpr double kBrakeMps2 = 0.45;
constexpr double kCornerMinMps = 0.15;
constexpr double kStandsOnM = 0.15;
constexpr double kSearchAheadM = 0.6;
constexpr double kArriveM = 0.12;  ///< from here the end is approached in any direction
constexpr double kDoneM = 0.05, kDoneYaw = 0.05;
constexpr double kSettleGain = 1.5, kSettleMps = 0.2, kSettleTimeoutS = 6.0;
constexpr double kStuckS = 8.0, kProgressM = 0.04;
constexpr double kMetresPerRadian = 0.3;

Vec2 Limited(const Vec2& v, double limit) {
  const double size = v.norm();
  return size > limit ? Vec2(v * (limit / size)) : v;
}

double YawCommand(double error) {
  return std::clamp(kYawGain * error, -kMaxYawRate, kMaxYawRate);
}

VelocityCommand InHeading(const Vec2& v_map, double yaw_rad, double yaw_rate) {
  const Vec2 v = Eigen::Rotation2Dd(-yaw_rad) * v_map;
  return {v.x(), v.y(), yaw_rate};
}

}  // namespace

PathTracker::PathTracker(std::vector<Vec2> waypoints_map, double final_yaw_rad, double speed_mps)
    : points_(std::move(waypoints_map)), final_yaw_rad_(final_yaw_rad), speed_mps_(speed_mps) {}

void PathTracker::Start(const Vec2& p_map) {
  started_ = true;
  size_t first = 0;  // waypoints that the robot stands on would only turn it round
  while (first + 1 < points_.size() && (points_[first] - p_map).norm() < kStandsOnM) ++first;
  points_.erase(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(first));
  std::vector<Vec2> kept = {p_map};
  for (const Vec2& p : points_) {
    if ((p - kept.back()).norm() > 1e-3) kept.push_back(p);
  }
  points_ = std::move(kept);
  arc_.assign(1, 0.0);
  for (size_t i = 1; i < points_.size(); ++i)
    arc_.push_back(arc_.back() + (points_[i] - points_[i - 1]).norm());
  corner_mps_.assign(points_.size(), speed_mps_);
  for (size_t i = 1; i + 1 < points_.size(); ++i) {
    const Vec2 in = (points_[i] - points_[i - 1]).normalized(),
               out = (points_[i + 1] - points_[i]).normalized();
    const double turn = std::acos(std::clamp(in.dot(out), -1.0, 1.0));
    const double share = std::clamp(1.0 - turn / (0.5 * core::kPi), 0.0, 1.0);
    corner_mps_[i] = std::max(std::min(kCornerMinMps, speed_mps_), speed_mps_ * share);
  }
  corner_mps_.back() = 0.0;
}

/// Moves on to the nearest point of the next stretch; never back, so loops and hairpins are walked in order.
void PathTracker::Project(const Vec2& p_map) {
  double best_distance = std::numeric_limits<double>::infinity(), best_arc = along_m_;
  for (size_t i = 0; i + 1 < points_.size(); ++i) {
    if (arc_[i + 1] < along_m_ || arc_[i] > along_m_ + kSearchAheadM) continue;
    const Vec2 way = points_[i + 1] - points_[i];
    const double length = arc_[i + 1] - arc_[i];
    const double from = std::max(along_m_ - arc_[i], 0.0);
    const double to = std::min(along_m_ + kSearchAheadM - arc_[i], length);
    const double on = std::clamp((p_map - points_[i]).dot(way) / length, from, to);
    const double distance = (p_map - points_[i] - way * (on / length)).norm();
    if (distance < best_distance - 1e-9) {
      best_distance = distance;
      best_arc = arc_[i] + on;
    }
  }
  along_m_ = best_arc;
}

Vec2 PathTracker::PointAt(double arc_m) const {
  if (arc_m >= arc_.back()) return points_.back();
  const auto next = static_cast<size_t>(std::upper_bound(arc_.begin(), arc_.end(), arc_m) - arc_.begin());
  const double u = (arc_m - arc_[next - 1]) / (arc_[next] - arc_[next - 1]);
  return points_[next - 1] + u * (points_[next] - points_[next - 1]);
}

double PathTracker::SpeedLimit(double arc_m) const {
  double limit = speed_mps_;
  for (size_t i = 1; i < points_.size(); ++i) {
    const double ahead = arc_[i] - arc_m;
    if (ahead < -1e-9) continue;
    limit = std::min(limit, std::sqrt(corner_mps_[i] * corner_mps_[i] + 2.0 * kBrakeMps2 * ahead));
    if (ahead > 2.0) break;
  }
  return limit;
}

VelocityCommand PathTracker::Follow(const Vec2& p_map, double yaw_rad) {
  const Vec2 ahead = PointAt(along_m_ + kHeadingAheadM) - PointAt(along_m_);
  const Vec2 to_carrot = PointAt(along_m_ + kLookaheadM) - p_map;
  const Vec2 facing = ahead.norm() > 0.05 ? ahead : to_carrot;
  const double heading_error = core::WrapAngle(std::atan2(facing.y(), facing.x()) - yaw_rad);
  turning_ = std::abs(heading_error) > (turning_ ? kTurnUntil : kTurnFrom);
  if (turning_) return {0.0, 0.0, YawCommand(heading_error)};

  const double aside =
      std::abs(std::sin(core::WrapAngle(std::atan2(to_carrot.y(), to_carrot.x()) - yaw_rad)));
  double speed = std::max(SpeedLimit(along_m_), kCornerMinMps);
  if (aside * speed > kLateralMps) speed = kLateralMps / aside;
  return InHeading(to_carrot.normalized() * speed, yaw_rad, YawCommand(heading_error));
}

VelocityCommand PathTracker::Settle(const Vec2& p_map, double yaw_rad) const {
  const Vec2 v = Limited(kSettleGain * (points_.back() - p_map), kSettleMps);
  return InHeading(v, yaw_rad, YawCommand(core::WrapAngle(final_yaw_rad_ - yaw_rad)));
}

bool PathTracker::Progressing(double time_s, double remaining) {
  if (remaining < best_remaining_ - kProgressM) {
    best_remaining_ = remaining;
    progress_time_s_ = time_s;
  }
  return time_s - progress_time_s_ < kStuckS;
}

PathTracker::Output PathTracker::Update(double time_s, const Vec2& p_map, double yaw_rad) {
  if (!started_) {
    Start(p_map);
    progress_time_s_ = time_s;
  }
  Project(p_map);
  const double to_end = (points_.back() - p_map).norm();
  if (!settling_ && arc_.back() - along_m_ < kArriveM && to_end < 2.0 * kArriveM) {
    settling_ = true;
    settling_since_s_ = progress_time_s_ = time_s;
    best_remaining_ = 1e9;
  }
  if (settling_) {
    const double yaw_error = std::abs(core::WrapAngle(final_yaw_rad_ - yaw_rad));
    const bool tired = time_s - settling_since_s_ > kSettleTimeoutS + yaw_error / 0.5;
    if ((to_end < kDoneM && yaw_error < kDoneYaw) || (tired && to_end < 3.0 * kDoneM && yaw_error < 0.2)) {
      return {Status::kArrived, {}};
    }
    if (!Progressing(time_s, to_end + kMetresPerRadian * yaw_error)) return {Status::kStuck, {}};
    return {Status::kWalking, Settle(p_map, yaw_rad)};
  }
  const VelocityCommand command = Follow(p_map, yaw_rad);
  const Vec2 ahead = PointAt(along_m_ + kHeadingAheadM) - p_map;
  const double turn = std::abs(core::WrapAngle(std::atan2(ahead.y(), ahead.x()) - yaw_rad));
  if (!Progressing(time_s, arc_.back() - along_m_ + kMetresPerRadian * turn)) return {Status::kStuck, {}};
  return {Status::kWalking, command};
}

}  // namespace atlas::sim
