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
constexpr double kJumpM = 5.0;     ///< from one revolution to the next; farther, nothing is known of the way
constexpr double kDeepestM = 1.5;  ///< a narrow stretch that is longer is a corridor
constexpr double kApartM = 1.8;    ///< way between two doorways; sooner it is furniture beside one
constexpr double kSameM = 0.5;     ///< unless the sensor turned and passes the same one again
constexpr double kPastM = 0.1;     ///< beyond the middle of the near edges: half of a thin wall

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

std::optional<Uprights::Opening> Uprights::OpeningAt(const Vec2& p, double widest_m) const {
  std::vector<Vec2> edges;  // from p
  const int x0 = ColumnAt(p.x()), y0 = ColumnAt(p.y()), reach = ColumnAt(widest_m) + 1;
  for (int x = x0 - reach; x <= x0 + reach; ++x) {
    for (int y = y0 - reach; y <= y0 + reach; ++y) {
      const auto found = columns_.find(ColumnCode(x, y));
      if (found == columns_.end() || found->second.points < kColumnPoints) continue;
      edges.push_back(found->second.sum / found->second.points - p);
    }
  }
  if (edges.empty()) return std::nullopt;
  const auto nearer = [](const Vec2& a, const Vec2& b) { return a.squaredNorm() < b.squaredNorm(); };
  const Vec2 nearest = *std::min_element(edges.begin(), edges.end(), nearer);
  std::optional<Opening> opening;
  for (const Vec2& edge : edges) {
    if (edge.dot(nearest) > kOppositeCos * edge.norm() * nearest.norm()) continue;
    const double width = (edge - nearest).norm();
    if (width <= widest_m && (!opening || width < opening->width_m))
      opening = Opening{width, p + 0.5 * (edge + nearest)};
  }
  return opening;
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
  const double way = (to - from).norm();
  if (way == 0.0) return false;
  if (way > kJumpM) {
    narrow_.reset();
    passed_at_.reset();
    return false;
  }
  bool passed = false;
  const int steps = std::max(1, static_cast<int>(std::ceil(way / kStepM)));
  // Out and in again within one move is nothing.
  for (int i = 1; i <= steps; ++i)
    passed ^= Step(from + (to - from) * i / steps, (to - from) / way, way / steps);
  return passed;
}

bool DoorwayWatch::OpensAhead(const Vec2& p, const Vec2& direction) const {
  for (double d = kStepM; d <= kDeepestM; d += 2.0 * kStepM) {
    if (!uprights_.OpeningAt(p + d * direction, widest_m_)) return true;
  }
  return false;
}

bool DoorwayWatch::Step(const Vec2& p, const Vec2& direction, double step_m) {
  since_m_ += step_m;
  const auto opening = uprights_.OpeningAt(p, widest_m_);
  if (opening && !narrow_) narrow_ = Narrow{p, opening->middle, direction};
  if (!narrow_) return false;
  Narrow& narrow = *narrow_;
  narrow.way_m += step_m;
  const double past = (p - narrow.middle).dot(narrow.direction);
  bool passed = false;
  if (narrow.beyond && past <= -kPastM) {
    passed = true;
    narrow.beyond = false;
  } else if (!narrow.beyond && past >= kPastM && (p - narrow.begin).norm() >= kPastM) {
    passed = narrow.beyond = narrow.way_m <= kDeepestM && (!opening || OpensAhead(p, direction));
  }
  const Vec2 middle = narrow.middle;
  if (!opening) narrow_.reset();
  if (!passed) return false;
  const bool is_same = passed_at_ && (*passed_at_ - middle).norm() < kSameM;
  if (passed_at_ && since_m_ < kApartM && !is_same) return false;
  passed_at_ = middle;
  since_m_ = 0.0;
  return true;
}

}  // namespace atlas::mapping
