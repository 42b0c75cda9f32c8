// Where the space that the body needs was seen to be empty. Ground that shows below an overhanging thing (a
// car, a bench, a helicopter's belly) is no evidence of the space above it: rays must have passed there.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry.h"

namespace atlas::mapping::terrain {

/// Columns of about 0.2 m with a bit for each eighth of a metre of height. Direct-mapped: a column that the
/// robot left far behind makes room for the one that falls on its slot.
class HeadroomGrid {
 public:
  /// @param reach_m  side of the square about the robot that is to be held at once.
  explicit HeadroomGrid(double reach_m);

  /// The ray is clear from `origin` for `clear_m` along `direction` (unit).
  void AddClearRay(const core::Vec3f& origin, const core::Vec3f& direction, float clear_m);
  /// All from `low_m` to `high_m` is clear within `radius_m`: the robot is there itself.
  void AddClearDisc(const core::Vec2& centre, double radius_m, double low_m, double high_m);

  /// Whether most of the upper body's space, from 0.4 m above `ground_m` to `headroom_m`, was seen to be
  /// empty.
  bool IsClear(float x, float y, float ground_m, float headroom_m) const;

 private:
  struct Column {
    int32_t ix = INT32_MIN, iy = INT32_MIN;
    uint64_t seen = 0;  ///< bit k: heights that floor to k modulo 64 eighths
  };
  size_t SlotOf(int ix, int iy) const {
    return static_cast<size_t>((iy & mask_) * (mask_ + 1) + (ix & mask_));
  }
  void Mark(int ix, int iy, uint64_t bits);

  int mask_ = 0;
  std::vector<Column> columns_;
};

}  // namespace atlas::mapping::terrain
