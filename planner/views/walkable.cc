#include "planner/views/walkable.h"

#include <algorithm>
#include <cmath>

namespace atlas::planner {
namespace {

using core::Vec2;
using core::Vec3;

constexpr double kCell_m = 0.05;
/// A footprint fits forwards where it fits backwards.
constexpr int kHalfTurnHeadings = 24;
constexpr double kCheckSpacing_m = 0.10;
constexpr double kEscape_m = 0.45;
constexpr double kInnerDisc_m = 0.35;
/// From one check to the next ground may rise by this much: 4 cm on 22 degrees, and a step.
constexpr double kRise_m = 0.25;
/// Heights asked for at one cell that differ by less are of one floor.
constexpr float kSameFloor_m = 0.5f * static_cast<float>(mapping::TraversableGround::kSameLevel_m);

int ChecksAlong(double length_m) {
  return std::max(1, static_cast<int>(std::ceil(length_m / kCheckSpacing_m)));
}

}  // namespace

Walkable::Walkable(const mapping::TraversableGround& ground, const Vec2& start, double window_m)
    : ground_(ground), start_(ground.OnRobotsLevel(start, 0.0)), window_(ground.Window()) {
  const Vec2 half = Vec2::Constant(0.5 * window_m);
  window_.min.head<2>() = window_.min.head<2>().cwiseMax(start - half);
  window_.max.head<2>() = window_.max.head<2>().cwiseMin(start + half);
  cols_ = std::max(1, static_cast<int>(std::ceil(window_.Size().x() / kCell_m)));
  rows_ = std::max(1, static_cast<int>(std::ceil(window_.Size().y() / kCell_m)));
  start_blocked_ = !ground.CircleFree(start_);
}

long Walkable::CellOf(const Vec3& p_map) const {
  const int col = static_cast<int>(std::floor((p_map.x() - window_.min.x()) / kCell_m));
  const int row = static_cast<int>(std::floor((p_map.y() - window_.min.y()) / kCell_m));
  if (col < 0 || row < 0 || col >= cols_ || row >= rows_) return -1;
  return static_cast<long>(row) * cols_ + col;
}

Walkable::Storey& Walkable::StoreyAt(size_t cell, double height_m) const {
  const float height = static_cast<float>(height_m);
  for (Storey& storey : storeys_) {
    float& known = storey.height_m[cell];
    if (std::isnan(known)) known = height;
    if (std::abs(known - height) <= kSameFloor_m) return storey;
  }
  const auto cells = static_cast<size_t>(cols_) * static_cast<size_t>(rows_);
  Storey& storey = storeys_.emplace_back();
  storey.height_m.assign(cells, std::numeric_limits<float>::quiet_NaN());
  storey.circle.assign(cells, 0);
  storey.footprint.assign(cells * kHalfTurnHeadings, 0);
  storey.height_m[cell] = height;
  return storey;
}

bool Walkable::InEscape(const Vec3& p_map) const {
  if (!start_blocked_ || (p_map - start_).head<2>().norm() > kEscape_m) return false;
  if (ground_.Traversability(p_map) <= 0.0) return false;
  for (int i = 0; i < 8; ++i) {
    const double angle = i * core::kPi / 4.0;
    if (ground_.Traversability(p_map + kInnerDisc_m * Vec3(std::cos(angle), std::sin(angle), 0.0)) <= 0.0)
      return false;
  }
  return true;
}

bool Walkable::CanStand(const Vec3& p_map) const {
  const long cell = CellOf(p_map);
  if (cell < 0) return false;
  int8_t& known = StoreyAt(static_cast<size_t>(cell), p_map.z()).circle[static_cast<size_t>(cell)];
  if (known == 0) known = ground_.CircleFree(p_map) ? 1 : -1;
  return known > 0;
}

bool Walkable::FootprintFree(const Vec3& p_map, double yaw_rad, int heading) const {
  const long cell = CellOf(p_map);
  if (cell < 0) return false;
  int8_t& known =
      StoreyAt(static_cast<size_t>(cell), p_map.z())
          .footprint[static_cast<size_t>(cell) * kHalfTurnHeadings + static_cast<size_t>(heading)];
  if (known == 0) known = ground_.FootprintFree(p_map, yaw_rad) ? 1 : -1;
  return known > 0 || InEscape(p_map);
}

std::optional<Vec3> Walkable::FollowGround(const Vec3& from, const Vec2& to) const {
  const Vec2 step = to - from.head<2>();
  const int checks = ChecksAlong(step.norm());
  std::optional<Vec3> here = from;
  for (int i = 1; i <= checks && here; ++i) {
    // It ends at `to` to the last bit: places are told apart by it.
    const Vec2 p = i == checks ? to : Vec2(from.head<2>() + step * (static_cast<double>(i) / checks));
    here = ground_.OnLevel({p.x(), p.y(), here->z()}, kRise_m);
  }
  return here;
}

bool Walkable::CanStep(const Vec3& a, const Vec3& b) const {
  const Vec2 step = (b - a).head<2>();
  const double length = step.norm();
  if (length < 1e-9) return true;
  const double yaw = std::atan2(step.y(), step.x());
  const double half_turns = yaw / core::kPi - std::floor(yaw / core::kPi);
  const int heading = static_cast<int>(std::lround(half_turns * kHalfTurnHeadings)) % kHalfTurnHeadings;
  const double snapped_yaw = heading * core::kPi / kHalfTurnHeadings;
  const int checks = ChecksAlong(length);
  double height = a.z();
  for (int i = 0; i <= checks; ++i) {
    const Vec2 p = a.head<2>() + step * (static_cast<double>(i) / checks);
    Vec3 here(p.x(), p.y(), height);
    if (const auto on = ground_.OnLevel(here, i == 0 ? ground_.kSameLevel_m : kRise_m)) here = *on;
    if (!FootprintFree(here, snapped_yaw, heading)) return false;
    height = here.z();
  }
  return std::abs(height - b.z()) <= ground_.kSameLevel_m;
}

double Walkable::Effort(const Vec3& a, const Vec3& b) const {
  const double length = (b - a).head<2>().norm();
  const double traversability = ground_.Traversability(0.5 * (a + b));
  return length * (1.0 + 2.0 * (1.0 - std::clamp(traversability, 0.0, 1.0)));
}

}  // namespace atlas::planner
