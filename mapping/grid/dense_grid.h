// A bounded dense occupancy grid that answers a planner's queries: a byte a voxel, walked by a DDA.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "mapping/map_view.h"

namespace atlas::mapping {

/// Voxel (i, j, k) spans origin + resolution * [i, i + 1) and so on; indices run x fastest. The origin is a
/// multiple of the resolution, so voxels coincide with OctoMap's.
class GridFrame {
 public:
  GridFrame(const core::Box3& region, double resolution_m);

  double resolution_m() const { return resolution_m_; }
  const core::Box3& box() const { return box_; }
  const std::array<int, 3>& size() const { return size_; }
  size_t count() const { return count_; }

  size_t IndexOf(int i, int j, int k) const {
    return static_cast<size_t>(i) +
           static_cast<size_t>(size_[0]) *
               (static_cast<size_t>(j) + static_cast<size_t>(size_[1]) * static_cast<size_t>(k));
  }
  /// -1 outside.
  int64_t IndexAt(const core::Vec3& p) const;
  core::Vec3 CenterOf(size_t index) const;

  /// Calls `visit(index, t_enter, t_leave)` on the voxels along origin + t * direction for t in [0, t_end],
  /// nearest first, until it returns false or the ray leaves the grid. Returns whether `visit` stopped it.
  template <typename Visit>
  bool Walk(const core::Vec3& origin, const core::Vec3& direction, double t_end, const Visit& visit) const {
    return WalkCells(origin, direction, t_end, [&](const int*, size_t index, double t_enter, double t_leave) {
      return visit(index, t_enter, t_leave);
    });
  }
  /// The same, with the voxel's (i, j, k) first: `visit(const int cell[3], index, t_enter, t_leave)`.
  template <typename Visit>
  bool WalkCells(const core::Vec3& origin, const core::Vec3& direction, double t_end,
                 const Visit& visit) const;

 private:
  double resolution_m_, inverse_resolution_;
  core::Box3 box_;
  std::array<int, 3> size_;
  size_t count_;
};

class DenseGrid : public MapView {
 public:
  /// Steps in which log-odds are held.
  static constexpr double kLogOddsStep = 0.05;
  static constexpr int kMostBehind = 31;  ///< voxels, of what lies behind a surface

  /// States are those of OctoMap's probabilities.
  DenseGrid(const core::Box3& region, double resolution_m);

  const GridFrame& frame() const { return frame_; }
  /// Sets a measured voxel's log-odds, rounded to kLogOddsStep for the view.
  void SetLogOdds(size_t index, float log_odds) { code_[index] = CodeOf(log_odds); }
  /// The same in two steps, for callers that set many voxels from few values.
  static uint8_t CodeOf(float log_odds);
  void SetCode(size_t index, uint8_t code) { code_[index] = code; }
  /// Marks an unmeasured voxel as lying behind a surface; the greatest value stays. No effect once measured.
  /// @pre 0 < value <= kMostBehind.
  void SetBehindSurface(size_t index, int value);
  bool Measured(size_t index) const { return code_[index] >= kFirstMeasured; }
  bool Occupied(size_t index) const { return IsOccupiedCode(code_[index]); }
  /// Rebuilds what Trace reads besides the voxels. Call after a batch of changes.
  void FinishUpdate();
  size_t Bytes() const { return code_.size() + block_is_free_.size(); }

  double resolution_m() const override { return frame_.resolution_m(); }
  const core::Box3& region() const { return frame_.box(); }
  DenseGrid Clone() const { return *this; }
  CellState StateAt(const core::Vec3& p_map) const override;
  RayEnd Trace(const core::Vec3& origin_map, const core::Vec3& direction_map, const TraceLimits& limits,
               std::vector<RaySample>* samples) const override;
  void ForEachOccupied(const core::Box3& box_map, const VisitCenter& visit) const override;

 private:
  // Codes: 0 unmeasured; 1..31 unmeasured, that many behind a surface; 32..255 log-odds in steps about 128.
  static constexpr int kFirstMeasured = kMostBehind + 1, kZeroCode = 128;
  static constexpr int kBlockSide = 8;
  struct Decoded {
    float occupancy, behind;
    CellState state;
  };
  bool IsFreeCode(uint8_t code) const { return code >= kFirstMeasured && code <= last_free_; }
  bool IsOccupiedCode(uint8_t code) const { return code >= first_occupied_; }
  void FillTable();
  bool BlockIsFree(int bx, int by, int bz) const;
  GridFrame frame_;
  int last_free_, first_occupied_;  ///< codes
  std::vector<uint8_t> code_;
  std::array<Decoded, 256> table_;
  // Blocks of 8^3 voxels that hold one free value throughout, which rays cross in one step.
  std::array<int, 3> blocks_ = {0, 0, 0};
  std::vector<uint8_t> block_is_free_;
};

template <typename Visit>
bool GridFrame::WalkCells(const core::Vec3& origin, const core::Vec3& direction, double t_end,
                          const Visit& visit) const {
  const auto span = box_.Clip(origin, direction);
  if (!span || span->first >= t_end) return false;
  // A step whose boundary lies at the end of the ray, but for rounding, would leave the grid.
  const double t_stop = std::min(span->second, t_end);
  const double t_last = t_stop - 1e-9;
  double t = span->first;
  const core::Vec3 local = (origin + t * direction - box_.min) * inverse_resolution_;
  int cell[3], step[3] = {1, 1, 1};
  double t_next[3], t_delta[3];
  int64_t jump[3] = {1, size_[0], static_cast<int64_t>(size_[0]) * size_[1]};
  for (int a = 0; a < 3; ++a) {
    cell[a] = std::clamp(static_cast<int>(std::floor(local[a])), 0, size_[static_cast<size_t>(a)] - 1);
    if (direction[a] == 0.0) {
      t_next[a] = t_delta[a] = std::numeric_limits<double>::infinity();
      continue;
    }
    const double inverse = 1.0 / direction[a];
    const double boundary = box_.min[a] + resolution_m_ * (cell[a] + (inverse > 0.0 ? 1 : 0));
    t_next[a] = (boundary - origin[a]) * inverse;
    t_delta[a] = resolution_m_ * std::abs(inverse);
    if (inverse < 0.0) {
      jump[a] = -jump[a];
      step[a] = -1;
    }
  }
  auto index = static_cast<int64_t>(IndexOf(cell[0], cell[1], cell[2]));
  double x = t_next[0], y = t_next[1], z = t_next[2];
  // Which boundary comes next is as good as random: selects, not branches.
  while (true) {
    const bool x_first = (x <= y) & (x <= z);
    const bool y_first = !x_first & (y <= z);
    const double t_leave = x_first ? x : (y_first ? y : z);
    const bool last = t_leave >= t_last;
    if (!visit(static_cast<const int*>(cell), static_cast<size_t>(index), t, last ? t_stop : t_leave))
      return true;
    if (last) return false;
    t = t_leave;
    cell[0] += x_first ? step[0] : 0;
    cell[1] += y_first ? step[1] : 0;
    cell[2] += x_first | y_first ? 0 : step[2];
    index += x_first ? jump[0] : (y_first ? jump[1] : jump[2]);
    x += x_first ? t_delta[0] : 0.0;
    y += y_first ? t_delta[1] : 0.0;
    z += x_first | y_first ? 0.0 : t_delta[2];
  }
}

}  // namespace atlas::mapping
