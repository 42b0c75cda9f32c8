// Planning on a volumetric map alone: ground is the top of occupied voxels, and the body needs free voxels
// above it (thesis 4.10.8).
#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include "core/geometry.h"
#include "mapping/map_view.h"
#include "planner/views/ompl_bridge.h"

namespace atlas::planner {

struct BodyOnMap {
  double radius_m = 0.4;            ///< of an upright cylinder that must be free
  double from_m = 0.3, to_m = 0.8;  ///< above the ground
  double climb_m = 0.25;            ///< the ground may rise or fall by this from place to place
  /// Of the voxels of a column: none may be occupied, and so many must be known to be free. Blocks on the
  /// ground that beams only graze stay unmeasured below free ones.
  double free_share = 0.4;
};

class MapGround {
 public:
  /// Holds on to `map`.
  MapGround(const mapping::MapView& map, const BodyOnMap& body);

  /// The ground next below `p_map`, at most 1.5 m down, where the body's column above it is free. Where no
  /// ground was seen (a LiDAR is blind near its foot), it is taken to go on at that height, unless what lies
  /// below is known to be free: a drop.
  std::optional<double> ColumnAt(const core::Vec3& p_map) const;
  /// Whether the cylinder about (x, y) is free, on ground like that at `p_map`.
  bool CanStand(const core::Vec3& p_map) const;
  /// Where a straight step to (x, y) ends; nothing where the body does not get through.
  std::optional<core::Vec3> Step(const core::Vec3& from_map, const core::Vec2& to_map) const;

 private:
  bool IsClear(const core::Vec2& p_map, double ground_m) const;
  struct Cell {
    int64_t x, y, z;
    bool operator==(const Cell&) const = default;
  };
  struct CellHash {
    size_t operator()(const Cell& cell) const {
      return static_cast<size_t>(cell.x * 73856093 ^ cell.y * 19349663 ^ cell.z * 83492791);
    }
  };
  Cell CellOf(const core::Vec3& p_map) const;

  const mapping::MapView& map_;
  BodyOnMap body_;
  double cell_m_;
  std::vector<core::Vec2> disc_;  ///< cells of the body's footprint, relative
  mutable std::unordered_map<Cell, std::optional<double>, CellHash> columns_;
  mutable std::unordered_map<Cell, bool, CellHash> stands_;
};

struct MapWay {
  std::vector<core::Vec3> points;  ///< on the ground, start and goal included
  double length_m = 0.0;
};

/// The shortest way found by RRT* with this many iterations inside `box_map`; nothing where there is none, or
/// where the body cannot stand at one of its ends. Results depend on the arguments only.
std::optional<MapWay> PlanOnMap(const MapGround& ground, const core::Box3& box_map, const core::Vec3& start,
                                const core::Vec3& goal, int iterations, core::Rng rng);

}  // namespace atlas::planner
