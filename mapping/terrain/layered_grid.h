// The rolling store: a square of cells that moves with the robot in fixed memory, each with a few layers of
// returns. Cell (ix, iy) covers [ix, ix + 1) x [iy, iy + 1) times cell_m in the odometry frame, wherever the
// window is.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry.h"

namespace atlas::mapping::terrain {

/// Returns close to each other in height. A tall one (a wall) has only lo and hi worth reading.
struct Layer {
  float mean_m = 0.0f;
  float lo_m = 0.0f, hi_m = 0.0f;
  uint16_t count = 0;  ///< 0: unused
  uint16_t info = 0;   ///< 1 / variance of the mean, per square metre
};

constexpr float kLayerGate_m = 0.07f;  ///< a return joins a layer whose mean is this near
constexpr float kTall_m = 0.20f;       ///< layers that span more are vertical structure

/// Layers in use come first.
struct alignas(64) LayeredCell {
  std::array<Layer, 4> layer;
};

class LayeredGrid {
 public:
  /// @pre side_cells > 0.
  LayeredGrid(double cell_m, int side_cells);

  double cell_m() const { return cell_m_; }
  int side() const { return side_; }
  int min_x() const { return min_x_; }
  int min_y() const { return min_y_; }
  int IndexOf(double coordinate_m) const {
    const double cells = coordinate_m * inverse_cell_;
    const int toward_zero = static_cast<int>(cells);  // std::floor is a call on plain x86-64
    return toward_zero - (cells < static_cast<double>(toward_zero) ? 1 : 0);
  }
  bool Contains(int ix, int iy) const {
    return static_cast<unsigned>(ix - min_x_) < static_cast<unsigned>(side_) &&
           static_cast<unsigned>(iy - min_y_) < static_cast<unsigned>(side_);
  }
  /// Where the cell is stored. @pre Contains(ix, iy).
  size_t Slot(int ix, int iy) const {
    const int c = Wrap(ix - min_x_ + shift_x_), r = Wrap(iy - min_y_ + shift_y_);
    return static_cast<size_t>(r) * static_cast<size_t>(side_) + static_cast<size_t>(c);
  }

  /// Centres the window on this cell; cells that leave it are forgotten, cells that enter it are empty.
  void CenterOn(int ix, int iy);
  void Clear();

  /// Fuses a height of this variance (thesis 3.5 reads a cell's height from many returns).
  void AddHeight(size_t slot, float z_m, float variance_m2, int count = 1);
  void AddCrossing(size_t slot) {
    if (crossings_[slot] < 60000) ++crossings_[slot];
  }
  void ForgetCrossings(size_t slot) { crossings_[slot] = 0; }
  void Assume(size_t slot, float z_m) { assumed_m_[slot] = z_m; }
  void SetReference(size_t slot, float z_m) { reference_m_[slot] = z_m; }

  const LayeredCell& cell(size_t slot) const { return cells_[slot]; }
  /// Rays that crossed the ground's expected height here and went on down.
  uint16_t crossings(size_t slot) const { return crossings_[slot]; }
  /// Ground that was declared, not seen; NaN where none.
  float assumed_m(size_t slot) const { return assumed_m_[slot]; }
  /// Height at which ground is expected, from the last update; NaN where none.
  float reference_m(size_t slot) const { return reference_m_[slot]; }

 private:
  int Wrap(int i) const { return i >= side_ ? i - side_ : i; }
  void ClearSlot(size_t slot);

  double cell_m_, inverse_cell_;
  int side_;
  int min_x_ = 0, min_y_ = 0;
  int shift_x_ = 0, shift_y_ = 0;  ///< storage column and row of the cell (min_x_, min_y_)
  std::vector<LayeredCell> cells_;
  std::vector<uint16_t> crossings_;
  std::vector<float> assumed_m_, reference_m_;
};

}  // namespace atlas::mapping::terrain
