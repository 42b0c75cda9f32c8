// Which submaps may have measured something near a point: a grid in the map frame over the blocks of all
// submaps, so that a point or a ray asks the few that matter, however many there are.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "mapping/atlas/submap_outline.h"

namespace atlas::mapping {

class SubmapIndex {
 public:
  /// Adds a submap's blocks that hold anything, where it lies. Submaps are added in order of precedence.
  void Add(const SubmapOutline& outline, const core::Pose& T_map_submap);
  /// Call once, after the last Add and before the first At.
  void Build();

  /// The submaps, by the order in which they were added, with a block within reach of the cell of `p`.
  std::span<const uint16_t> At(const core::Vec3& p_map) const;
  /// Side of a cell; cells lie at whole multiples of it.
  double cell_m() const { return cell_m_; }
  /// All that the submaps hold; empty where they hold nothing.
  const core::Box3& bounds_map() const { return bounds_map_; }

 private:
  struct Block {
    core::Vec3f low, high;  ///< of its box in the map
    uint16_t submap;
  };
  /// Calls `visit(cell)` on each cell that a block's box meets.
  template <typename Visit>
  void ForCells(const Block& block, const Visit& visit) const;

  std::vector<Block> blocks_;
  uint16_t submaps_ = 0;
  core::Box3 bounds_map_;
  double cell_m_ = 0.0;
  int first_[3] = {0, 0, 0}, count_[3] = {0, 0, 0};  ///< cells
  std::vector<uint32_t> begin_;                      ///< of each cell in members_, one more at the end
  std::vector<uint16_t> members_;
};

}  // namespace atlas::mapping
