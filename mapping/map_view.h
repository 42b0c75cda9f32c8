// What planners may ask of a map, whatever its backend.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
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

/// One voxel on a ray, or a run of voxels, which stands for as many samples.
struct RaySample {
  float occupancy = 0.5f;       ///< probability, from the log-odds that the map holds; 0.5: never measured
  float length_m = 0.0f;        ///< of the ray inside the voxel, or all along the run
  uint64_t key = 0;             ///< the same for the same voxel on any ray; of a run, its first voxel's
  float behind_surface = 0.0f;  ///< D - delta of the proximity count gain, in voxels; 0 where not stored
  uint32_t voxels = 1;          ///< more than one only where free or never measured
  CellState state = StateOf(occupancy);
};

enum class RayEnd : uint8_t {
  kOccupied,  ///< the last sample is an occupied voxel
  kVoid,      ///< left the box or reached the range without meeting a surface
};

/// How far a ray is traced, and what its samples keep apart: the less, the longer the steps.
struct TraceLimits {
  double max_range_m = 20.0;
  core::Box3 box_map = {core::Vec3::Constant(-std::numeric_limits<double>::infinity()),
                        core::Vec3::Constant(std::numeric_limits<double>::infinity())};
  /// Free voxels of unlike occupancy are samples of their own; else free voxels in a row are one, with the
  /// first's.
  bool each_free = true;
  /// Voxels never measured are samples of their own, each with its key; else those in a row are one.
  bool each_unmeasured = true;
  bool behind_surface = true;  ///< is read, where the map keeps it
};

/// A map at one moment. Immutable: any number of threads may ask while the map itself goes on.
class MapView {
 public:
  virtual ~MapView() = default;

  virtual double resolution_m() const = 0;
  virtual CellState StateAt(const core::Vec3& p_map) const = 0;
  /// The rigid part that StateAt asks there; 0 where none has measured it, and of a map that is one.
  virtual uint32_t SubmapAt(const core::Vec3&) const { return 0; }

  /// Appends what the ray crosses inside the limits, nearest first, up to and including the first occupied
  /// voxel. `samples` is cleared first. @pre direction is unit.
  virtual RayEnd Trace(const core::Vec3& origin_map, const core::Vec3& direction_map,
                       const TraceLimits& limits, std::vector<RaySample>* samples) const = 0;

  /// Calls `visit` with the centre of each occupied voxel in a box, in a fixed order.
  using VisitCenter = std::function<void(const core::Vec3f& center_map)>;
  virtual void ForEachOccupied(const core::Box3& box_map, const VisitCenter& visit) const = 0;
};

/// Of all occupied voxels in a box.
std::vector<core::Vec3f> OccupiedCenters(const MapView& map, const core::Box3& box_map);

/// Joins what a trace meets into samples, as its limits allow.
class RaySamples {
 public:
  RaySamples(const TraceLimits& limits, std::vector<RaySample>* samples)
      : limits_(limits), samples_(*samples) {
    samples_.clear();
  }

  /// The next voxel, or voxels of one value in a row. Returns false where the ray ends: at an occupied voxel.
  [[gnu::always_inline]] bool Add(const RaySample& sample) {
    if (!samples_.empty() && Joins(samples_.back(), sample)) {
      samples_.back().length_m += sample.length_m;
      samples_.back().voxels += sample.voxels;
      return true;
    }
    samples_.push_back(sample);
    return sample.state != CellState::kOccupied;
  }

 private:
  bool Joins(const RaySample& last, const RaySample& next) const {
    if (next.state == CellState::kFree)
      return last.state == CellState::kFree && (!limits_.each_free || last.occupancy == next.occupancy);
    return !limits_.each_unmeasured && next.occupancy == kUnmeasured && last.occupancy == kUnmeasured &&
           last.behind_surface == 0.0f && next.behind_surface == 0.0f;
  }
  static constexpr float kUnmeasured = 0.5f;

  const TraceLimits& limits_;
  std::vector<RaySample>& samples_;
};

}  // namespace atlas::mapping
