// Many submaps, asked as one map (thesis 6.1.1).
//
// Where submaps overlap, one rule holds for every question: of the submaps that have measured a point, the
// one that took a revolution last is right. What the robot has just seen is so consistent with where it
// believes to be, even where an older submap still awaits its correction:
//
//     submap 0 (older)   |  free  . occupied . unmeasured   .............
//     submap 1 (newer)     ......... free .... occupied ....  unmeasured
//     the map            |  free  .  free   .  occupied  .... unmeasured
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "mapping/atlas/paged_contents.h"
#include "mapping/atlas/submap_index.h"
#include "mapping/map_view.h"
#include "mapping/octree/octree_view.h"

namespace atlas::mapping {

/// A submap at one moment.
struct PosedSubmap {
  uint32_t id = 0;
  std::shared_ptr<const StoredContents> contents;
  StateLogOdds states;
  core::Pose T_map_submap = core::Pose::Identity();
  std::shared_ptr<const SubmapOutline> outline;  ///< of the contents
};

class AtlasView final : public MapView {
 public:
  /// @param submaps  in order of precedence, the first is right
  /// @param keep_map  nothing is known outside
  AtlasView(double resolution_m, std::vector<PosedSubmap> submaps, const core::Box3& keep_map);

  double resolution_m() const override { return resolution_m_; }
  CellState StateAt(const core::Vec3& p_map) const override;
  uint32_t SubmapAt(const core::Vec3& p_map) const override;
  /// Unmeasured voxels are those of a grid in the map frame; measured ones are their submap's own.
  RayEnd Trace(const core::Vec3& origin_map, const core::Vec3& direction_map, const TraceLimits& limits,
               std::vector<RaySample>* samples) const override;
  void ForEachOccupied(const core::Box3& box_map, const VisitCenter& visit) const override;

  const std::vector<PosedSubmap>& submaps() const { return submaps_; }
  /// The place of the submap that is right about a point among submaps(); their number where none has
  /// measured it.
  size_t RightAbout(const core::Vec3& p_map) const;

 private:
  class RayThrough;
  class Throughs;
  class PieceSink;
  /// Returns false where the ray ends.
  static bool CrossCell(std::span<const uint16_t> submaps, std::pair<double, double> span_m,
                        Throughs* throughs, PieceSink* met);
  /// RightAbout, and as what it measured the point; `view_of(i)` is the i-th submap's own view.
  template <typename Views>
  size_t FirstThatMeasured(const core::Vec3& p_map, const Views& view_of, CellState* state) const;
  const OctreeView& ViewOf(size_t submap) const;

  /// Submaps that a ray or a point has asked for, in memory for as long as this view.
  struct Pin {
    std::once_flag once;
    std::optional<OctreeView> view;
  };

  double resolution_m_;
  std::vector<PosedSubmap> submaps_;
  std::unique_ptr<Pin[]> pins_;
  std::vector<core::Pose> T_submap_map_;
  core::Box3 keep_map_;
  SubmapIndex index_;
  OctreeView nothing_;  ///< an empty grid in the map frame
};

}  // namespace atlas::mapping
