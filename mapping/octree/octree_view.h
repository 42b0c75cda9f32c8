// An occupancy octree as planners see a map.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "mapping/map_view.h"
#include "mapping/octree/behind_surface.h"
#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// What a map holds.
struct OctreeContents {
  OccupancyOctree tree;
  std::optional<BehindSurface> behind = {};
  /// Of a map of signed distances: what scans went into. `tree` then tells no more than which of its voxels
  /// are free and which occupied.
  std::optional<TsdfOctree> distances = {};

  OctreeContents Clone() const {
    return {tree.Clone(), behind, distances ? std::optional(distances->Clone()) : std::nullopt};
  }
};

/// Log-odds up to which a voxel counts as free, and from which on as occupied.
struct StateLogOdds {
  double free = std::log(kFreeProbability / (1.0 - kFreeProbability));
  double occupied = std::log(kOccupiedProbability / (1.0 - kOccupiedProbability));
};

class OctreeView final : public MapView {
 public:
  OctreeView(std::shared_ptr<const OctreeContents> contents, const StateLogOdds& states);

  double resolution_m() const override { return contents_->tree.resolution_m(); }
  CellState StateAt(const core::Vec3& p_map) const override {
    return ValueAt(contents_->tree.At(p_map)).state;
  }
  /// Nothing where the voxel was never measured.
  std::optional<CellState> MeasuredStateAt(const core::Vec3& p_map) const {
    const int8_t held = contents_->tree.At(p_map);
    return OccupancyField::Known(held) ? std::optional(ValueAt(held).state) : std::nullopt;
  }
  /// Crosses in one step what its nodes hold as one value, and, where free voxels need not be told apart, all
  /// nodes that are free throughout.
  RayEnd Trace(const core::Vec3& origin_map, const core::Vec3& direction_map, const TraceLimits& limits,
               std::vector<RaySample>* samples) const override;
  void ForEachOccupied(const core::Box3& box_map, const VisitCenter& visit) const override;
  const OctreeContents& contents() const { return *contents_; }

 private:
  using Chunk = OccupancyOctree::Chunk;
  struct Crossing;
  struct Value {
    float occupancy;
    CellState state;
  };
  const Value& ValueAt(int8_t log_odds) const { return value_[static_cast<uint8_t>(log_odds)]; }
  bool AllFree(const OccupancyField::Node& node) const {
    return !node.any_unknown && ValueAt(node.max).state == CellState::kFree;
  }
  /// The largest aligned cube about a block that one step may cross, as a level, or -1.
  int OneStepLevel(const Chunk& chunk, int block, const TraceLimits& limits) const;

  std::shared_ptr<const OctreeContents> contents_;
  std::array<Value, 256> value_;  ///< by log-odds, as unsigned
};

}  // namespace atlas::mapping
