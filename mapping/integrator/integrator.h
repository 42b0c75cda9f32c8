// From a revolution of a LiDAR to updates of the octree (thesis 4.5).
//
// Two ways in: organised scans whose beams follow a table go through a spherical projection, where free space
// is decided cone by cone at the scale that the beams support (4.5.1) and surfaces by Eq. 4.2; unorganised
// clouds are cast ray by ray with bit masks. Both undistort by per-ray poses (4.5.3), take void rays as free
// evidence and give the same map whatever the number of threads and the SIMD width of the machine.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/lidar_model.h"
#include "core/params.h"
#include "core/sensor_events.h"
#include "mapping/octree/octree.h"

namespace atlas::mapping {

struct IntegratorParams {
  double max_range_m = 60.0;        ///< longer returns are misses up to here
  std::string void_rays = "clear";  ///< clear (free to void_range_m) | ignore
  double void_range_m = 20.0;       ///< a void ray is trusted this far
  // Eq. 4.2: sigma(d) = max(sigma_min, lambda_sigma d); L_min in front of -3 sigma, a ramp through the
  // surface up to near_nats, nothing behind lambda_r d. The voxel that holds a return gains hit_nats instead.
  double sigma_min_m = 0.006;
  double lambda_sigma = 0.0005;
  double lambda_r = 0.02;
  double behind_min_voxels = 2.0;  ///< lambda_r d is at least this
  double behind_max_m = 0.25;  ///< and at most this: far returns must not thicken walls into the next room
  // Evidence a scan, rounded to steps of 0.2 nats (OccupancyField::kPlaces):
  double miss_nats = 0.4;    ///< -L_min
  double hit_nats = 0.8;     ///< of the voxel that holds a return
  double near_nats = 0.4;    ///< at most, of others that the surface reaches; less than hit_nats
  double skim_cosine = 0.0;  ///< grazing beams (cosine of incidence below this) update only the voxel of
                             ///< their return: no band of Eq. 4.2
  double edge_nats = 0.2;    ///< an occupied voxel that is free only at a surface's edge loses this
  double pierce_voxels =
      0.5;  ///< a beam clears voxels whose middle it passes this near, whatever ends around
  double truncation_voxels = 3.0;  ///< TSDF: at scale 1; grows with the scale of integration
  int max_scale = 4;               ///< largest cell side inside a block, voxels: 1, 2 or 4
  bool lossless = false;  ///< collapse only what is equal; else all-free leaves keep their least free value
  bool motion_aware = true;              ///< per-ray poses; off: one pose a scan (thesis Fig. 4.8)
  double remap_stop_rad = 0.001;         ///< the search for the nearest ray ends here (4.5.3)
  std::optional<core::Box3> region_map;  ///< nothing is kept outside, where given
  int threads = 1;                       ///< workers that fill chunks; not a parameter of the map
  /// The measurement model of a ray, whatever the map: max_range_m, void_rays, void_range_m.
  void VisitRays(core::ParamVisitor& v);
  /// How scans fill the octree: of occupancy and of signed distances, of one of them alone.
  void VisitFilling(core::ParamVisitor& v);
  void VisitOccupancy(core::ParamVisitor& v);
  void VisitTsdf(core::ParamVisitor& v);
};

/// Declares the edge of the smallest voxel, `resolution_m`.
void VisitResolution(double* resolution_m, core::ParamVisitor& v);

/// What one call did, for benches and progress.
struct IntegrationStats {
  double image_ms = 0.0, hit_ms = 0.0, fill_ms = 0.0;  ///< CPU of the calling thread
  size_t rays = 0, hits = 0, blocks_free = 0, blocks_mixed = 0;
};

template <typename Field>
class ScanIntegrator {
 public:
  virtual ~ScanIntegrator() = default;
  /// Integrates one revolution. Poses are T_map_odom * scan.T_odom_lidar at each ray's own time. Summaries
  /// of the octree are current afterwards and written blocks are marked dirty.
  virtual void Integrate(const core::SpinEvent& spin, const core::Pose& T_map_odom, Octree<Field>* map) = 0;
  virtual const IntegrationStats& stats() const = 0;
};

/// For organised scans of this LiDAR. @throws InputError where a parameter or the beam table is out of range
/// (fewer than 2 rows or 16 columns, elevations that coincide).
template <typename Field>
std::unique_ptr<ScanIntegrator<Field>> MakeConeIntegrator(const IntegratorParams& params,
                                                          const core::LidarModel& lidar);
/// For any cloud: each ray by itself, free space exactly along it.
template <typename Field>
std::unique_ptr<ScanIntegrator<Field>> MakeRayIntegrator(const IntegratorParams& params);
/// Cone by cone where the LiDAR is known, else ray by ray.
template <typename Field>
std::unique_ptr<ScanIntegrator<Field>> MakeIntegrator(const IntegratorParams& params,
                                                      const std::optional<core::LidarModel>& lidar) {
  return lidar ? MakeConeIntegrator<Field>(params, *lidar) : MakeRayIntegrator<Field>(params);
}

}  // namespace atlas::mapping
