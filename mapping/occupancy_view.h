// What planners may ask of a map, whatever its backend.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry.h"

namespace atlas::mapping {

enum class CellState : uint8_t { kUnknown, kFree, kOccupied };

/// OctoMap's classes as the gains of Isler et al. (2016) take them: occupied where p > 0.8, free where
/// p < 0.2, unknown between. A map whose evidence counts otherwise has bounds of its own (SE-Atlas: a scan's
/// miss is free, thesis 4.5.2); what a voxel counts as is its state, how sure that is its probability.
constexpr double kOccupiedProbability = 0.8;
constexpr double kFreeProbability = 0.2;
constexpr CellState StateOf(float p) {
  return p > static_cast<float>(kOccupiedProbability) ? CellState::kOccupied
         : p < static_cast<float>(kFreeProbability)   ? CellState::kFree
                                                      : CellState::kUnknown;
}

/// One voxel on a ray, or a run of free voxels of one occupancy, which stands for as many samples.
struct RaySample {
  float occupancy = 0.5f;       ///< probability, from the log-odds that the map holds; 0.5: never measured
  float length_m = 0.0f;        ///< of the ray inside the voxel, or all along the run
  uint64_t key = 0;             ///< the same for the same voxel on any ray; of a run, its first voxel's
  float behind_surface = 0.0f;  ///< D - delta of the proximity count gain, in voxels; 0 where not stored
  uint32_t voxels = 1;          ///< more than one only where free
  CellState state = StateOf(occupancy);
};

enum class RayEnd : uint8_t {
  kOccupied,  ///< the last sample is an occupied voxel
  kVoid,      ///< left the region or reached the range without meeting a surface
};

class OccupancyView {
 public:
  virtual ~OccupancyView() = default;

  virtual double resolution_m() const = 0;
  /// Where the map is kept (the object box with a margin); all is unknown outside.
  virtual const core::Box3& region() const = 0;
  virtual CellState StateAt(const core::Vec3& p_map) const = 0;

  /// Appends the voxels that the ray crosses inside region() and within `max_range_m`, nearest first, up to
  /// and including the first occupied one. `samples` is cleared first. Thread-safe. @pre direction is unit.
  virtual RayEnd Trace(const core::Vec3& origin_map, const core::Vec3& direction_map, double max_range_m,
                       std::vector<RaySample>* samples) const = 0;

  /// Centres of all occupied voxels, in a fixed order.
  virtual std::vector<core::Vec3f> OccupiedCenters() const = 0;
  /// Distance to the nearest occupied voxel's centre, at most `limit_m`.
  virtual double DistanceToOccupied(const core::Vec3& p_map, double limit_m) const = 0;
};

}  // namespace atlas::mapping
