#include "mapping/atlas/doorway_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace atlas::mapping {
namespace {

using core::Vec2;
using core::Vec3;
using core::Vec3f;

constexpr double kColumnM = 0.1;
constexpr int kColumnPoints = 3;  ///< of an upright
constexpr double kBelowM = 0.2, kAboveM = 0.7;
constexpr double kOppositeCos = -0.5;  ///< 120 degrees
constexpr double kStepM = 0.05;        ///< of the way
constexpr double kDeepestM = 2.0;      ///< a narrow stretch that is longer is a corridor
constexpr double kPassedM = 0.25;      ///< between the ends of a stretch; less: turned back in it

uint64_t ColumnCode(int x, int y) {
  return static_cast<uint64_t>(static_cast<uint32_t>(x)) << 32 | static_cast<uint32_t>(y);
}
int ColumnAt(double m) {
  return static_cast<int>(std::floor(m / kColumnM));
}

}  // namespace

void Uprights::Add(std::span<const Vec3f> points, double height_m) {
  for (const Vec3f& point : points) {
    const Vec3 p = point.cast<double>();
    if (p.z() < height_m - kBelowM || p.z() > height_m + kAboveM) continue;
    Column& column = columns_[ColumnCode(ColumnAt(p.x()), ColumnAt(p.y()))];
    column.sum += p.head<2>();
    ++column.points;
  }
}

double Uprights::WidthAt(const Vec2& p, double widest_m) const {
  std::vector<Vec2> edges;  // from p
  const int x0 = ColumnAt(p.x()), y0 = ColumnAt(p.y()), reach = ColumnAt(widest_m) + 1;
  for (int x = x0 - reach; x <= x0 + reach; ++x) {
    for (int y = y0 - reach; y <= y0 + reach; ++y) {
      const auto found = columns_.find(ColumnCode(x, y));
      if (found == columns_.end() || found->second.points < kColumnPoints) continue;
      edges.push_back(found->second.sum / found->second.points - p);
    }
  }
  const double infinity = std::numeric_limits<double>::infinity();
  if (edges.empty()) return infinity;
  const auto nearer = [](const Vec2& a, const Vec2& b) { return a.squaredNorm() < b.squaredNorm(); };
  const Vec2 nearest = *std::min_element(edges.begin(), edges.end(), nearer);
  double width = infinity;
  for (const Vec2& edge : edges) {
    if (edge.dot(nearest) > kOppositeCos * edge.norm() * nearest.norm()) continue;
    width = std::min(width, (edge - nearest).norm());
  }
  return width <= widest_m ? width : infinity;
}

void DoorwayWatch::See(std::vector<Vec3f> points_odom, const Vec3& p_odom_sensor) {
  if (widest_m_ == 0.0) return;
  uprights_ = {};
  uprights_.Add(before_, p_odom_sensor.z());
  uprights_.Add(points_odom, p_odom_sensor.z());
  before_ = std::move(points_odom);
}

bool DoorwayWatch::Move(const Vec3& p_odom_sensor) {
  if (widest_m_ == 0.0) return false;
  const Vec2 to = p_odom_sensor.head<2>(), from = last_.value_or(to);
  last_ = to;
  bool passed = false;
  const double way = (to - from).norm();
  const int steps = std::max(1, static_cast<int>(std::ceil(way / kStepM)));
  for (int i = 1; i <= steps; ++i) {
    const Vec2 p = from + (to - from) * i / steps;
    if (uprights_.WidthAt(p, widest_m_) <= widest_m_) {
      if (!narrow_) narrow_ = Narrow{p, 0.0};
      narrow_->way_m += way / steps;
    } else if (const auto left = std::exchange(narrow_, std::nullopt)) {
      passed = passed || (left->way_m <= kDeepestM && (p - left->from).norm() >= kPassedM);
    }
  }
  return passed;
}

}  // namespace atlas::mapping
