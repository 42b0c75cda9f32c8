// From every place at the border of an area where the robot can turn, straight ways are tried in all
// headings until they come out on another such area. A gap gives many of them, side by side and slightly
// askew; each is moved to the middle of the room that it has, and of those that lie together the roomiest is
// kept.
#include "planner/views/passages.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace atlas::planner {
namespace {

using core::Vec2;
using core::Vec3;

constexpr double kGrid_m = 0.04;  ///< as the cells of terrain maps: a way may be a single one wide
constexpr int kHeadings = 48;     ///< over a full turn
constexpr double kStride_m = 0.05;
constexpr double kSideStep_m = 0.02, kWidest_m = 0.3;  ///< room to the sides is measured in steps, up to this
constexpr double kRunUp_m = 0.3;
constexpr double kSameGap_m = 0.6;  ///< between the middles of passages through one gap

/// Areas of grid places that are joined and where the robot can stand.
class Areas {
 public:
  explicit Areas(const Walkable& walkable) : walkable_(walkable) {
    const core::Box3& window = walkable.window();
    x0_ = static_cast<int>(std::ceil(window.min.x() / kGrid_m));
    y0_ = static_cast<int>(std::ceil(window.min.y() / kGrid_m));
    cols_ = std::max(0, static_cast<int>(std::floor(window.max.x() / kGrid_m)) - x0_ + 1);
    rows_ = std::max(0, static_cast<int>(std::floor(window.max.y() / kGrid_m)) - y0_ + 1);
    area_.assign(static_cast<size_t>(cols_) * static_cast<size_t>(rows_), kOff);
    for (int row = 0; row < rows_; ++row) {
      for (int col = 0; col < cols_; ++col) {
        if (CanStand(PointAt(row, col))) area_[IndexOf(row, col)] = kUnlabelled;
      }
    }
    int labels = 0;
    for (int row = 0; row < rows_; ++row) {
      for (int col = 0; col < cols_; ++col) {
        if (area_[IndexOf(row, col)] == kUnlabelled) Fill(row, col, labels++);
      }
    }
    count_ = labels;
  }

  static constexpr int kOff = -1;
  Vec3 OnGround(const Vec2& p) const { return walkable_.ground().OnRobotsLevel(p, walkable_.start().z()); }
  bool CanStand(const Vec2& p) const { return walkable_.CanStand(OnGround(p)); }
  int count() const { return count_; }
  int rows() const { return rows_; }
  int cols() const { return cols_; }
  Vec2 PointAt(int row, int col) const { return kGrid_m * Vec2(x0_ + col, y0_ + row); }
  int At(int row, int col) const {
    const bool inside = row >= 0 && col >= 0 && row < rows_ && col < cols_;
    return inside ? area_[IndexOf(row, col)] : kOff;
  }
  /// Of the grid place nearest to `p_map`.
  int Near(const Vec2& p_map) const {
    return At(static_cast<int>(std::lround(p_map.y() / kGrid_m)) - y0_,
              static_cast<int>(std::lround(p_map.x() / kGrid_m)) - x0_);
  }

 private:
  static constexpr int kUnlabelled = -2;

  size_t IndexOf(int row, int col) const {
    return static_cast<size_t>(row) * static_cast<size_t>(cols_) + static_cast<size_t>(col);
  }
  void Fill(int row, int col, int label) {
    std::vector<std::pair<int, int>> open = {{row, col}};
    area_[IndexOf(row, col)] = label;
    while (!open.empty()) {
      const auto [r, c] = open.back();
      open.pop_back();
      for (const auto& [nr, nc] : {std::pair(r - 1, c), {r + 1, c}, {r, c - 1}, {r, c + 1}}) {
        if (At(nr, nc) != kUnlabelled) continue;
        area_[IndexOf(nr, nc)] = label;
        open.emplace_back(nr, nc);
      }
    }
  }

  const Walkable& walkable_;
  int x0_ = 0, y0_ = 0, rows_ = 0, cols_ = 0, count_ = 0;
  std::vector<int> area_;
};

/// A passage on its way to be found: from `a` along `u`.
struct Way {
  Vec2 a, u;
  double length_m = 0.0;
  double clearance_m = 0.0;
  std::pair<int, int> joins;  ///< areas, the lower first
  Vec2 Middle() const { return a + 0.5 * length_m * u; }
};

class Search {
 public:
  Search(const Walkable& walkable, double longest_m)
      : walkable_(walkable), longest_m_(longest_m), areas_(walkable) {}

  std::vector<Way> AllWays() const {
    std::vector<Way> ways;
    if (areas_.count() < 2) return ways;
    for (int row = 0; row < areas_.rows(); ++row) {
      for (int col = 0; col < areas_.cols(); ++col) {
        if (!OnBorder(row, col)) continue;
        for (int k = 0; k < kHeadings; ++k) {
          const double yaw = 2.0 * core::kPi * k / kHeadings;
          const auto way = WayFrom(areas_.PointAt(row, col), Vec2(std::cos(yaw), std::sin(yaw)));
          // Found from either end; one of them is enough.
          if (!way || areas_.At(row, col) != way->joins.first) continue;
          if (const auto centred = Centred(*way)) ways.push_back(*centred);
        }
      }
    }
    return ways;
  }

  /// From its end at `p`, on along `u` for a run-up where the robot can stand.
  Vec3 WithRunUp(const Vec2& p, const Vec2& u) const {
    double run_m = 0.0;
    while (run_m + kStride_m <= kRunUp_m && areas_.CanStand(p + (run_m + kStride_m) * u)) {
      run_m += kStride_m;
    }
    return areas_.OnGround(p + run_m * u);
  }

 private:
  bool OnBorder(int row, int col) const {
    if (areas_.At(row, col) == Areas::kOff) return false;
    for (const auto& [dr, dc] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      if (areas_.At(row + dr, col + dc) == Areas::kOff) return true;
    }
    return false;
  }
  bool Fits(const Vec2& p, const Vec2& u) const {
    return walkable_.ground().FootprintFree(areas_.OnGround(p), std::atan2(u.y(), u.x()));
  }

  /// The straight way that leaves the area at `a` and comes out on another one.
  /// @param leave_m  within so much of `a` it may still be in that area.
  std::optional<Way> WayFrom(const Vec2& a, const Vec2& u, double leave_m = 0.0) const {
    const int from = areas_.Near(a);
    for (double s = kStride_m; s <= longest_m_; s += kStride_m) {
      const Vec2 p = a + s * u;
      const int area = areas_.Near(p);
      if (!Fits(p, u)) return std::nullopt;
      if (area == from) {
        if (s <= leave_m) continue;
        return std::nullopt;
      }
      if (area == Areas::kOff || !areas_.CanStand(p)) continue;
      return Way{a, u, s, 0.0, {std::min(from, area), std::max(from, area)}};
    }
    return std::nullopt;
  }

  /// Room to one side of the whole way.
  double Room(const Way& way, const Vec2& side) const {
    double room_m = 0.0;
    for (double shift = kSideStep_m; shift <= kWidest_m; shift += kSideStep_m) {
      for (double s = 0.0; s <= way.length_m + 1e-9; s += kStride_m) {
        if (!Fits(way.a + s * way.u + shift * side, way.u)) return room_m;
      }
      room_m = shift;
    }
    return room_m;
  }

  /// Moved to the middle of its room; none if it does not come out there on the same areas.
  std::optional<Way> Centred(const Way& way) const {
    const Vec2 left(-way.u.y(), way.u.x());
    const double to_left = Room(way, left), to_right = Room(way, -left);
    Vec2 a = way.a + 0.5 * (to_left - to_right) * left;
    const int from = areas_.Near(way.a);
    // Its start may lie off the area now: back until the robot can stand.
    for (int k = 0; k < 8 && !areas_.CanStand(a); ++k) a -= kStride_m * way.u;
    if (!areas_.CanStand(a) || areas_.Near(a) != from || !Fits(a, way.u)) return std::nullopt;
    // Forward again to the last such place.
    while (areas_.CanStand(a + kStride_m * way.u) && areas_.Near(a + kStride_m * way.u) == from) {
      a += kStride_m * way.u;
    }
    // Beside the places of the grid the area may end elsewhere than on them.
    auto centred = WayFrom(a, way.u, 2.0 * kGrid_m);
    if (!centred || centred->joins != way.joins) return std::nullopt;
    centred->clearance_m = 0.5 * (to_left + to_right);
    return centred;
  }

  const Walkable& walkable_;
  double longest_m_;
  Areas areas_;
};

}  // namespace

std::vector<Passage> FindPassages(const Walkable& walkable, double longest_m) {
  const Search search(walkable, longest_m);
  std::vector<Way> ways = search.AllWays();
  // Roomiest first; of equally roomy ones the shortest, which is the squarest.
  std::stable_sort(ways.begin(), ways.end(), [](const Way& a, const Way& b) {
    return std::pair(-a.clearance_m, a.length_m) < std::pair(-b.clearance_m, b.length_m);
  });
  std::vector<Way> kept;
  for (const Way& way : ways) {
    const bool taken = std::any_of(kept.begin(), kept.end(), [&](const Way& other) {
      return other.joins == way.joins && (other.Middle() - way.Middle()).norm() < kSameGap_m;
    });
    if (!taken) kept.push_back(way);
  }
  std::vector<Passage> passages;
  for (const Way& way : kept) {
    passages.push_back({search.WithRunUp(way.a, -way.u),
                        search.WithRunUp(way.a + way.length_m * way.u, way.u), way.clearance_m});
  }
  return passages;
}

}  // namespace atlas::planner
