#include "planner/views/walkable.h"

#include <algorithm>
#include <cmath>

namespace atlas::planner {
namespace {

using core::Vec2;

constexpr double kCell_m = 0.05;
/// A footprint fits forwards where it fits backwards.
constexpr int kHalfTurnHeadings = 24;
constexpr double kCheckSpacing_m = 0.10;
constexpr double kEscape_m = 0.45;
constexpr double kInnerDisc_m = 0.35;

}  // namespace

Walkable::Walkable(const mapping::TraversableGround& ground, const Vec2& start, double window_m)
    : ground_(ground), start_(start), window_(ground.Window()) {
  const Vec2 half = Vec2::Constant(0.5 * window_m);
  window_.min.head<2>() = window_.min.head<2>().cwiseMax(start - half);
  window_.max.head<2>() = window_.max.head<2>().cwiseMin(start + half);
  cols_ = std::max(1, static_cast<int>(std::ceil(window_.Size().x() / kCell_m)));
  rows_ = std::max(1, static_cast<int>(std::ceil(window_.Size().y() / kCell_m)));
  const auto cells = static_cast<size_t>(cols_) * static_cast<size_t>(rows_);
  circle_.assign(cells, 0);
  footprint_.assign(cells * kHalfTurnHeadings, 0);
  start_blocked_ = !ground.CircleFree(start);
}

long Walkable::CellOf(const Vec2& p_map) const {
  const int col = static_cast<int>(std::floor((p_map.x() - window_.min.x()) / kCell_m));
  const int row = static_cast<int>(std::floor((p_map.y() - window_.min.y()) / kCell_m));
  if (col < 0 || row < 0 || col >= cols_ || row >= rows_) return -1;
  return static_cast<long>(row) * cols_ + col;
}

bool Walkable::InEscape(const Vec2& p_map) const {
  if (!start_blocked_ || (p_map - start_).norm() > kEscape_m) return false;
  if (ground_.Traversability(p_map) <= 0.0) return false;
  for (int i = 0; i < 8; ++i) {
    const double angle = i * core::kPi / 4.0;
    if (ground_.Traversability(p_map + kInnerDisc_m * Vec2(std::cos(angle), std::sin(angle))) <= 0.0)
      return false;
  }
  return true;
}

bool Walkable::CanStand(const Vec2& p_map) const {
  const long cell = CellOf(p_map);
  if (cell < 0) return false;
  int8_t& known = circle_[static_cast<size_t>(cell)];
  if (known == 0) known = ground_.CircleFree(p_map) ? 1 : -1;
  return known > 0;
}

bool Walkable::FootprintFree(const Vec2& p_map, double yaw_rad, int heading) const {
  const long cell = CellOf(p_map);
  if (cell < 0) return false;
  int8_t& known = footprint_[static_cast<size_t>(cell) * kHalfTurnHeadings + static_cast<size_t>(heading)];
  if (known == 0) known = ground_.FootprintFree(p_map, yaw_rad) ? 1 : -1;
  return known > 0 || InEscape(p_map);
}

bool Walkable::CanStep(const Vec2& a, const Vec2& b) const {
  const Vec2 step = b - a;
  const double length = step.norm();
  if (length < 1e-9) return true;
  const double yaw = std::atan2(step.y(), step.x());
  const double half_turns = yaw / core::kPi - std::floor(yaw / core::kPi);
  const int heading = static_cast<int>(std::lround(half_turns * kHalfTurnHeadings)) % kHalfTurnHeadings;
  const double snapped_yaw = heading * core::kPi / kHalfTurnHeadings;
  const int checks = std::max(1, static_cast<int>(std::ceil(length / kCheckSpacing_m)));
  for (int i = 0; i <= checks; ++i) {
    if (!FootprintFree(a + step * (static_cast<double>(i) / checks), snapped_yaw, heading)) return false;
  }
  return true;
}

double Walkable::Effort(const Vec2& a, const Vec2& b) const {
  const double length = (b - a).norm();
  const double traversability = ground_.Traversability(0.5 * (a + b));
  return length * (1.0 + 2.0 * (1.0 - std::clamp(traversability, 0.0, 1.0)));
}

}  // namespace atlas::planner
