// Points bucketed in cubic cells for radius marking and nearest-neighbour queries.
//
// Two levels: a dense table of blocks of 8 x 8 x 8 cells over the points' bounds, and cells of the blocks
// that hold points. Cells of one block lie together, so queries along a surface stay in cache.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry.h"

namespace atlas::experiments {

class PointGrid {
 public:
  /// A point and its index in the order given.
  struct Entry {
    core::Vec3f p;
    uint32_t index;
  };
  struct CellRange {
    std::array<int, 3> lo, hi;  ///< cell coordinates, inclusive, clipped to the grid
  };

  /// @pre all points finite, cell_m > 0
  PointGrid(std::span<const core::Vec3f> points, double cell_m);

  double cell_m() const { return cell_m_; }
  const std::vector<Entry>& entries() const { return entries_; }  ///< by cell
  size_t cell_count() const { return begin_.empty() ? 0 : begin_.size() - 1; }
  uint32_t CellBegin(int32_t cell) const { return begin_[static_cast<size_t>(cell)]; }
  uint32_t CellEnd(int32_t cell) const { return begin_[static_cast<size_t>(cell) + 1]; }

  /// Cells that may hold points within `radius_m` of p; false where there is none.
  bool CellsAround(const core::Vec3f& p, float radius_m, CellRange* range) const;
  /// Index of the cell at these coordinates of a CellRange, or -1 where its block holds no points.
  int32_t CellAt(int x, int y, int z) const;

  /// Input index of the nearest point within `limit_m` of p, or -1. The lower index wins a tie.
  int64_t Nearest(const core::Vec3f& p, float limit_m, float* distance_m) const;

 private:
  /// Looks at the cells of one shell of `ring` cells about the home cell.
  void SearchRing(const core::Vec3f& p, const std::array<int, 3>& home, int ring, float* best_sq,
                  int64_t* best) const;
  void SearchCell(const core::Vec3f& p, int x, int y, int z, float* best_sq, int64_t* best) const;

  double cell_m_;
  float inverse_cell_;
  core::Vec3f origin_ = core::Vec3f::Zero();
  std::array<int, 3> cells_ = {0, 0, 0};  // along each axis, a multiple of 8
  std::array<int, 3> blocks_ = {0, 0, 0};
  std::vector<int32_t> block_;   // dense; -1 = empty
  std::vector<uint32_t> begin_;  // first entry of each cell, one more at the end
  std::vector<Entry> entries_;
};

/// One point of each cell of a grid with this spacing (the first), as indices into `points`, ascending.
std::vector<uint32_t> ThinIndices(std::span<const core::Vec3f> points, double spacing_m);

}  // namespace atlas::experiments
