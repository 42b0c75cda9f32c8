#include "experiments/mission/closed_loop.h"

#include <fmt/format.h>

#include <optional>

#include "core/files.h"
#include "core/lidar_model.h"
#include "core/stopwatch.h"
#include "core/task_lanes.h"
#include "experiments/judge/mission_metrics.h"
#include "experiments/mission/ending.h"
#include "experiments/mission/run_film.h"
#include "experiments/mission/run_localiser.h"
#include "experiments/mission/sensor_feed.h"
#include "experiments/results/run_folder.h"
#include "mapping/terrain/posed_ground.h"
#include "planner/stopping/surface_tally.h"
#include "robots/robot_spec.h"
#include "scenes/catalog.h"

namespace atlas::experiments {
namespace {

using core::Pose;

/// Everything that takes part in a mission, built from its configuration.
struct Mission {
  Mission(const ExperimentConfig& config, const RunOptions& options)
      : config(config),
        options(options),
        rng(static_cast<uint64_t>(config.seed)),
        scene(scenes::LoadScene(config.scene.name)),
        robot(robots::LoadRobot(config.robot.name)),
        film(config, options),
        metrics(config, options, scene, robot),
        simulator(sim::MakeSimulator(scene, robot, SimParamsFor(config, options), rng.Split("sim"))),
        region(mapping::RegionOf(config.mapper, scene.object_box)),
        map(mapping::MakeMap(config.mapper, MapSetup())),
        localiser(MakeLocaliserFor(config, scene, *simulator, rng.Split("sim").Split("odometry"))),
        cloud(region, config.mapper.integrator.max_range_m, config.mapper.downsample_m),
        terrain(config.planner.terrain, robot),
        feed({}, Listeners(), &lanes),
        planner(planner::MakeNbvPlanner(config.planner, RobotModel(), {scene.object_box, region},
                                        options.threads, rng.Split("planner"))),
        surface(scene.object_box, config.mapper.resolution_m),
        lanes(kTaskLanes, options.threads > 1) {
    terrain.InitialiseUnderRobot(simulator->T_odom_base());
    simulator->SetLocalisation(localiser->T_map_odom());
    simulator->SetSink(&feed);
    simulator->SetStop(options.should_stop);
    metrics.Attach(simulator.get());
    film.Attach(simulator.get());
  }

  static sim::SimParams SimParamsFor(const ExperimentConfig& config, const RunOptions& options) {
    sim::SimParams params = config.sim;
    params.sensors.threads = options.threads;
    return params;
  }

  SensorFeed::Listeners Listeners() {
    return {.localiser = localiser.get(),
            .terrain = &terrain,
            .map = map.get(),
            .cloud = &cloud,
            .on_localised = [this](const Pose& T_map_odom) { simulator->SetLocalisation(T_map_odom); },
            .on_cloud =
                [this](const mapping::ReturnCloud& returns) {
                  metrics.TakeCloud(returns);
                  returns_map.insert(returns_map.end(), returns.points.begin(), returns.points.end());
                }};
  }

  mapping::MapSetup MapSetup() const {
    return {.lidar = Lidar(),
            .keep_map = region,
            .behind_surface = planner::ReadsOf(config.planner).behind_surface};
  }

  core::LidarModel Lidar() const {
    const std::string& name = config.sim.sensors.lidar;
    return core::FindLidarModel(name == "robot" ? robot.lidar_model : name);
  }

  /// The simulation's own profile of the roll, period and speed.
  planner::RobotModel RobotModel() const {
    const sim::LocomotionParams& motion = config.sim.locomotion;
    return {.sensor = {.lidar = Lidar(),
                       .T_base_lidar = robot.T_base_lidar,
                       .base_height_m = robot.stance_height_m,
                       .roll = {core::Radians(motion.sweep_roll_deg), motion.sweep_period_s}},
            .speed_mps = motion.speed_mps,
            .half_width_m = robot.half_width_m,
            .turning_radius_m = robot.footprint_radius_m};
  }

  mapping::PosedGround Ground() const { return {terrain, T_map_base(), simulator->T_odom_base()}; }
  Pose T_map_base() const { return localiser->T_map_odom() * simulator->T_odom_base(); }

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
  std::unique_ptr<planner::NbvPlanner> planner;
  planner::SurfaceTally surface;
  double odometry_distance_m = 0.0;      ///< walked so far, as the robot knows it
  std::vector<core::Vec3f> returns_map;  ///< since the last sweep was tallied; of tasks on kMapLane
  core::TaskLanes lanes;                 ///< ends before what its tasks work on
};

/// Sweeps while the map takes the walk that led here and what the sweep sees; the robot stands until both are
/// integrated, and the planner learns how much surface was new.
std::optional<Ending> SweepAndIntegrate(Mission* m) {
  m->feed.SetMapping(SensorFeed::Mapping::kScanning);
  const core::Stopwatch sweeping;
  const sim::MotionStatus status = m->simulator->RollSweep();
  m->feed.SetMapping(SensorFeed::Mapping::kNothing);
  if (const auto ending = EndingOf(status)) return ending;
  m->metrics.timing().sweep_wall_s = sweeping.seconds();
  m->metrics.ObserveSweep(m->T_map_base());
  m->feed.RefreshTerrain();
  const Pose T_map_base = m->T_map_base();
  const sim::MotionStatus stood = m->simulator->Stand(m->config.mission.integration_latency_s);

  const SensorFeed::Mapped mapped = m->feed.DrainMap();
  m->film.ObserveMap(mapping::OccupiedCenters(*m->map->Snapshot(), m->region));
  const core::Stopwatch updating;
  m->feed.AdoptTerrain();
  m->metrics.timing().terrain_ms = 1e3 * updating.seconds();
  const size_t new_surface = m->surface.CountNew(m->returns_map, m->Ground());
  m->returns_map.clear();
  m->planner->OnSweep(T_map_base, new_surface);
  m->metrics.ObserveMap(mapped.cloud_points, 1e3 * mapped.integration_s, new_surface);
  m->lanes.Post(kMapLane, [m] { m->metrics.ScoreClouds(*m->map); });
  return EndingOf(stood);
}

/// Plans while the metrics are scored.
planner::NbvDecision PlanNextView(Mission* m) {
  const core::Stopwatch planning;
  const mapping::PosedGround ground = m->Ground();
  planner::NbvDecision decision = m->planner->Plan(m->T_map_base(), *m->map->Snapshot(), ground);
  m->metrics.timing().nbv_time_s = planning.seconds();
  m->metrics.ObserveGround(ground);
  m->lanes.Drain(kMapLane);
  m->metrics.AdoptScore();
  return decision;
}

/// Own criterion or a budget; nothing if the mission goes on.
std::optional<Ending> StopAfterPlanning(const Mission& m, const planner::NbvDecision& decision) {
  const MissionParams& mission = m.config.mission;
  if (const auto ending = EndingOf(decision.outcome, m.scene.is_space)) return ending;
  if (m.metrics.scans() >= mission.max_scans) return Ending{RunStatus::kBudget, StopReason::kScanBudget};
  if (m.simulator->time_s() >= mission.max_time_s) return Ending{RunStatus::kBudget, StopReason::kTimeBudget};
  if (m.odometry_distance_m >= mission.max_distance_m)
    return Ending{RunStatus::kBudget, StopReason::kDistanceBudget};
  return std::nullopt;
}

std::optional<Ending> WalkTo(Mission* m, const planner::NbvDecision& decision, FailedWalks* failed_walks) {
  const planner::Candidate& view = decision.candidates[static_cast<size_t>(decision.best)];
  using Mapping = SensorFeed::Mapping;
  m->feed.SetMapping(m->config.mission.map_while_walking ? Mapping::kEverything : Mapping::kNothing);
  const core::Stopwatch walking;
  const sim::WalkResult walk = m->simulator->Walk({decision.path_map, view.yaw_rad}, &m->terrain);
  m->feed.SetMapping(Mapping::kNothing);
  m->metrics.ObserveWalk(walk, walking.seconds());
  m->odometry_distance_m += walk.odometry_distance_m;
  if (const auto ending = EndingOf(walk.status)) return ending;
  return failed_walks->Observe(walk.status);
}

Ending RunMission(Mission* m) {
  FailedWalks failed_walks;
  while (true) {
    m->metrics.BeginScan();
    m->metrics.Report("sweeping");
    if (const auto ending = SweepAndIntegrate(m)) return *ending;
    m->metrics.Report("planning");
    const planner::NbvDecision decision = PlanNextView(m);
    const auto ending = StopAfterPlanning(*m, decision);
    m->metrics.FinishScan(decision);
    m->film.ObservePlan(decision);
    if (ending) return *ending;
    if (const auto stopped = EndingOf(m->simulator->Stand(m->config.mission.planning_latency_s)))
      return *stopped;
    m->metrics.Report("walking");
    if (const auto stopped = WalkTo(m, decision, &failed_walks)) return *stopped;
  }
}

void SaveWhatCanBe(Mission* m) {
  try {
    m->metrics.Save(*m->map);
  } catch (const std::exception&) {
    // Of two errors the first is told.
  }
}

}  // namespace

RunSummary RunClosedLoop(const ExperimentConfig& given, const RunOptions& options) {
  core::RemoveStaleTemporaries(core::CacheDirectory());
  const ExperimentConfig config = KeepInputs(given, options.folder);  // what is run is what is kept
  Mission mission(config, options);
  options.prepared();
  Ending ending{RunStatus::kFailed, StopReason::kError};
  try {
    ending = RunMission(&mission);
    mission.lanes.Drain(kTerrainLane);
    mission.lanes.Drain(kMapLane);
  } catch (...) {
    mission.lanes.Abandon();
    SaveWhatCanBe(&mission);
    throw;  // past the recorder, which says that the run failed
  }
  mission.metrics.Save(*mission.map);
  const bool interrupted = ending.status == RunStatus::kInterrupted;
  if (!mission.film.Finish(!interrupted)) ending = {RunStatus::kInterrupted, StopReason::kSignal};
  return mission.metrics.Finish(ending.status, ending.reason);
}

}  // namespace atlas::experiments
