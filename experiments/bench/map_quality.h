// How true a map is, against the geometry that its scans were cast from.
//
// Probes are drawn once a scan from noise-free rays of an independent ray caster, both along the scan's own
// beams and in random directions between them, and are asked of any map after those scans.
#pragma once

#include <functional>
#include <vector>

#include "core/rng.h"
#include "experiments/bench/bench_dataset.h"
#include "mapping/map_view.h"
#include "sim/sensors/raycaster.h"

namespace atlas::experiments {

struct QualityOptions {
  double max_range_m = 60.0;
  double resolution_m = 0.065;
  int probes_per_scan = 2000;  ///< of each kind
  uint64_t seed = 7;
};

using StateAt = std::function<mapping::CellState(const core::Vec3& p_map)>;

/// Shares in [0, 1]; -1 where no probe of the kind exists.
struct MapQuality {
  double free_on_rays = -1;        ///< of points on beams, a voxel's diagonal before the surface, held free
  double free_on_rays_empty = -1;  ///< of those, in voxels that no surface runs through
  double free_on_rays_exact = -1;  ///< what a map scores that holds all but those voxels free
  double occupied_near_hit = -1;   ///< of true hits of beams, with an occupied voxel among the 27 around
  double free_between_near = -1, free_between_mid = -1,
         free_between_far = -1;                                 ///< 0-10, 10-30, 30-60 m off the beams
  double free_between_30 = -1;                                  ///< 0-30 m
  double free_between_30_empty = -1;                            ///< of those, in voxels without surface
  double free_between_30_exact = -1;                            ///< as free_on_rays_exact
  double surface_freed = -1;                                    ///< of true surface points in view, held free
  double surface_freed_grazing = -1, surface_freed_other = -1;  ///< incidence above or below 80 degrees
  /// Of points on surface that extends 1.5 beam spacings to every side: held free, and nothing occupied
  /// within a beam's spacing. An obstacle overlooked.
  double obstacle_freed = -1;
};

class QualityProbes {
 public:
  QualityProbes(const BenchDataset& dataset, const QualityOptions& options);

  /// Draws the probes of one scan. Scans in any order, each once.
  void AddScan(size_t scan);
  MapQuality Judge(const StateAt& state) const;

 private:
  enum class Kind : uint8_t { kFreeOnRay, kHit, kFreeBetween, kSurface };
  struct Probe {
    core::Vec3f p;
    Kind kind;
    float range_m;    ///< of the probe from the sensor
    float spacing_m;  ///< of the beams there
    bool grazing, large;
    bool empty = true;  ///< no surface runs through its voxel
  };
  void AddBeamProbes(size_t scan, core::Rng* rng);
  void AddViewProbes(size_t scan, core::Rng* rng);
  /// Marks which of the free probes from `first` on share their voxel with a surface: one of its four
  /// diagonals meets it, as any plane through the voxel does.
  void MarkEmpty(size_t first);
  bool OccupiedWithin(const StateAt& state, const core::Vec3& p, double radius_m) const;

  const BenchDataset& dataset_;
  QualityOptions options_;
  sim::Raycaster oracle_;
  double elevation_min_, elevation_max_, pitch_rad_;
  std::vector<Probe> probes_;
};

}  // namespace atlas::experiments
