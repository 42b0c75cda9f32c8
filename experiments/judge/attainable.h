// What a run could have covered at best: the ceiling that coverage is held against.
//
// The scorer of coverage_outer (coverage.h: returns from the outer side) is fed the hits of noise-free sweeps
// from every point of a 0.5 m lattice over the truly reachable set (reachable.h), at eight headings. Casting
// those sweeps whole would take some 10^10 rays, so rays are aimed: at each position only at those truth
// samples that are still open, where some heading's sweep sends beams (roll range, beam elevations, range
// limits). Each aimed ray leaves from where the sensor is when its roll brings a beam onto the sample. One
// that truly meets its sample adds the rays that the position's sweeps are expected to put within the scoring
// radius; once those of all positions together make `min_rays`, a return in the union is nearly certain, the
// sample's hit is scored, and it is closed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "core/lidar_model.h"
#include "experiments/judge/coverage.h"
#include "experiments/judge/reachable.h"
#include "robots/robot_spec.h"
#include "scenes/catalog.h"
#include "scenes/scene_spec.h"

namespace atlas::experiments {

struct ExperimentConfig;
struct RunOptions;

struct AttainableOptions {
  double radius_m = kObjectCoverageRadiusM;
  double lattice_m = 0.5;
  int headings = 8;           ///< evenly over the circle, from map x
  double max_range_m = 20.0;  ///< of returns that a mapper keeps; the sensor's own limit holds besides
  double sweep_roll_deg = 40.0;
  double sweep_period_s = 6.0;
  double target_spacing_m = 0.015;  ///< of the truth samples that rays are aimed at
  double min_rays = 3.0;            ///< expected within the radius of a sample, all positions and headings
  ReachOptions reach;
  int threads = 1;
};

struct Attainable {
  std::vector<uint8_t> attainable;  ///< 1 where attainable, a truth point each
  double coverage = 0.0;            ///< coverage_attainable: the share of all truth points
  size_t positions = 0;             ///< of the lattice
  double reachable_area_m2 = 0.0;
  size_t rays = 0;
  bool from_cache = false;
};

/// First hit of each ray within `max_range_m` (< 0: none), the static scene only. `seed` picks which rays a
/// partly transmissive surface stops. Results must not depend on how rays are split over calls beyond that.
using CastRays = std::function<void(std::span<const core::Ray> rays, float max_range_m, uint64_t seed,
                                    std::span<float> range_m)>;

/// Called now and then with the share done, in [0, 1].
using AttainableProgress = std::function<void(double)>;

/// Independent of `options.threads`. @pre truth has a normal a point
Attainable ComputeAttainable(const scenes::SceneSpec& scene, const scenes::GroundTruth& truth,
                             const robots::RobotSpec& robot, const core::LidarModel& lidar,
                             const AttainableOptions& options, const CastRays& cast,
                             const AttainableProgress& progress);

/// Where the robot could stand to scan this scene: the reachable set within range of the object box.
ReachableSet ReachableForScanning(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                  const core::LidarModel& lidar, const AttainableOptions& options);

/// As ComputeAttainable with the scene's own rays (sim::Raycaster), kept in `cache_folder` under a key of all
/// that it depends on. A cache file that is missing, cut short or damaged is computed anew; a folder that
/// cannot be written only means that the next run computes again.
Attainable LoadOrComputeAttainable(const scenes::SceneSpec& scene, const scenes::GroundTruth& truth,
                                   const robots::RobotSpec& robot, const core::LidarModel& lidar,
                                   const AttainableOptions& options,
                                   const std::filesystem::path& cache_folder,
                                   const AttainableProgress& progress);

/// Rays against the scene's own geometry, nothing of the robot's.
CastRays SceneRays(const scenes::SceneSpec& scene, int threads);

/// What a run's sensor, sweeps and score say of its attainable set.
AttainableOptions AttainableOptionsFor(const ExperimentConfig& config, int threads);

/// The attainable set of a run, from core::CacheDirectory() where it lies there; reports through
/// options.progress.
std::vector<uint8_t> AttainableFor(const ExperimentConfig& config, const RunOptions& options,
                                   const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                   const scenes::GroundTruth& truth);

}  // namespace atlas::experiments
