// A map of small planes that grows scan by scan: cells of a grid, each with up to four surfels of distinct
// normals.
//
// A surfel is the running mean of the points that met it. The two faces of a thin wall, or the walls of a
// corner, are surfels of their own in one cell.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry.h"

namespace atlas::mapping {

struct Surfel {
  core::Vec3f mean = core::Vec3f::Zero();
  core::Vec3f normal = core::Vec3f::Zero();  ///< unit, to where it was seen from
  uint32_t count = 0;                        ///< of points; 0: none
};

class SurfelMap {
 public:
  /// @pre voxel_m > 0.
  explicit SurfelMap(double voxel_m);

  double voxel_m() const { return voxel_m_; }
  size_t cells() const { return cells_.size(); }
  /// @pre normal is unit; |p| < 2^20 cells. Where a cell is full, a point of another normal is left out.
  void Insert(const core::Vec3f& p, const core::Vec3f& normal);
  /// Of the surfels in the cell of `p` and those around it whose normals are within 53 degrees of `normal`,
  /// the nearest to `p` within `max_distance_m`.
  std::optional<Surfel> Nearest(const core::Vec3f& p, const core::Vec3f& normal, float max_distance_m) const;
  /// Forgets cells farther than `radius_m` from `p`.
  void Crop(const core::Vec3f& p, float radius_m);

 private:
  static constexpr uint32_t kFree = ~uint32_t{0};
  struct Cell {
    uint64_t key = 0;
    std::array<Surfel, 4> surfels;
  };
  uint32_t Find(uint64_t key) const;
  void Rehash(size_t slots);

  double voxel_m_;
  std::vector<Cell> cells_;
  std::vector<uint32_t> slots_;  ///< open addressing, a power of two: indices of cells_
};

}  // namespace atlas::mapping
