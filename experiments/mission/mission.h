// Who takes part in a mission, built from its configuration.
#pragma once

#include <memory>
#include <vector>

#include "core/rng.h"
#include "core/task_lanes.h"
#include "experiments/identity/experiment_config.h"
#include "experiments/identity/run_options.h"
#include "experiments/judge/mission_metrics.h"
#include "experiments/mission/run_film.h"
#include "experiments/mission/sensor_feed.h"
#include "mapping/cloud/scan_cloud.h"
#include "mapping/map.h"
#include "mapping/slam/localiser.h"
#include "mapping/terrain/elevation_map.h"
#include "mapping/terrain/posed_ground.h"
#include "planner/planner.h"
#include "planner/stopping/surface_tally.h"
#include "robots/robot_spec.h"
#include "scenes/catalog.h"
#include "sim/simulator.h"

namespace atlas::experiments {

/// Built in the order of its members; the robot stands at its spawn pose, every listener attached.
struct Mission {
  /// Keeps references to both. @throws InputError for bad input.
  Mission(const ExperimentConfig& config, const RunOptions& options);
  Mission(const Mission&) = delete;
  Mission& operator=(const Mission&) = delete;

  /// Where the robot believes to be.
  core::Pose T_map_base() const { return localiser->T_map_odom() * simulator->T_odom_base(); }
  /// The ground as it is localised now. Holds on to `terrain`.
  mapping::PosedGround Ground() const { return {terrain, T_map_base(), simulator->T_odom_base()}; }

  const ExperimentConfig& config;
  const RunOptions& options;
  core::Rng rng;
  scenes::SceneSpec scene;
  robots::RobotSpec robot;
  RunFilm film;
  MissionMetrics metrics;
  std::unique_ptr<sim::Simulator> simulator;
  core::Box3 region;  ///< about the object: what the map keeps
  std::unique_ptr<mapping::Map> map;
  std::unique_ptr<mapping::Localiser> localiser;
  mapping::ScanCloud cloud;
  mapping::ElevationMap terrain;
  SensorFeed feed;
  std::unique_ptr<planner::Planner> planner;
  planner::SurfaceTally surface;
  double odometry_distance_m = 0.0;      ///< walked so far, as the robot knows it
  std::vector<core::Vec3f> returns_map;  ///< since the last sweep was tallied; of tasks on kMapLane
  core::TaskLanes lanes;                 ///< ends before what its tasks work on

 private:
  SensorFeed::Listeners Listeners();
};

}  // namespace atlas::experiments
