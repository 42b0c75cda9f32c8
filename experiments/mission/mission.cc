#include "experiments/mission/mission.h"

#include "experiments/mission/map_pictures.h"
#include "experiments/mission/run_localiser.h"
#include "mapping/backends/catalog.h"
#include "planner/planners/catalog.h"

namespace atlas::experiments {
namespace {

sim::SimParams SimParamsOf(const ExperimentConfig& config, const RunOptions& options) {
  sim::SimParams params = config.sim;
  params.sensors.threads = options.threads;
  return params;
}

mapping::MapSetup MapSetupOf(const ExperimentConfig& config, const robots::RobotSpec& robot,
                             const core::Box3& region) {
  return {.lidar = robots::LidarOf(robot, config.sim.sensors.lidar),
          .keep_map = region,
          .behind_surface = config.planner.own->reads().behind_surface};
}

/// The simulation's own profile of the roll, period and speed.
planner::RobotModel RobotModelOf(const ExperimentConfig& config, const robots::RobotSpec& robot) {
  const sim::LocomotionParams& motion = config.sim.locomotion;
  return {.sensor = {.lidar = robots::LidarOf(robot, config.sim.sensors.lidar),
                     .T_base_lidar = robot.T_base_lidar,
                     .base_height_m = robot.stance_height_m,
                     .roll = {core::Radians(motion.sweep_roll_deg), motion.sweep_period_s}},
          .speed_mps = motion.speed_mps,
          .half_width_m = robot.half_width_m,
          .turning_radius_m = robot.footprint_radius_m};
}

std::unique_ptr<sim::Simulator> SimulatorOf(const ExperimentConfig& config, const RunOptions& options,
                                            const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                            const core::Rng& rng) {
  auto simulator = sim::MakeSimulator(scene, robot, SimParamsOf(config, options), rng);
  return options.interpose ? options.interpose(std::move(simulator)) : std::move(simulator);
}

planner::Goal GoalOf(const scenes::SceneSpec& scene) {
  if (scene.is_space) return planner::WholeSpace{scene.object_box};
  return planner::ObjectInBox{scene.object_box};
}

}  // namespace

Mission::Mission(const ExperimentConfig& given, const RunOptions& run_options)
    : config(given),
      options(run_options),
      rng(static_cast<uint64_t>(config.seed)),
      scene(scenes::LoadScene(config.scene.name)),
      robot(robots::LoadRobot(config.robot.name)),
      film(config, options),
      metrics(config, options, scene, robot),
      simulator(SimulatorOf(config, options, scene, robot, rng.Split("sim"))),
      region(mapping::RegionOf(config.mapper, scene.object_box)),
      map(mapping::MakeMap(config.mapper, MapSetupOf(config, robot, region))),
      localiser(
          MakeLocaliserFor(config, scene, *simulator, options.threads, rng.Split("sim").Split("odometry"))),
      cloud(region, config.mapper.integrator.max_range_m, config.mapper.downsample_m),
      terrain(config.planner.terrain, robot),
      feed({}, Listeners(), &lanes),
      planner(planner::MakePlanner(config.planner, {.robot = RobotModelOf(config, robot),
                                                    .goal = GoalOf(scene),
                                                    .kept_map = region,
                                                    .terrain = config.planner.terrain,
                                                    .threads = options.threads,
                                                    .rng = rng.Split("planner")})),
      surface(scene.object_box, config.mapper.resolution_m),
      lanes(kTaskLanes, options.threads > 1) {
  PlanAfterOf(config.mission);  // refuses what it cannot read before hours are spent
  terrain.InitialiseUnderRobot(simulator->T_odom_base());
  simulator->SetLocalisation(localiser->T_map_odom());
  simulator->SetSink(&feed);
  simulator->SetStop(options.should_stop);
  metrics.Attach(simulator.get());
  film.Attach(simulator.get());
}

SensorFeed::Listeners Mission::Listeners() {
  return {.localiser = localiser.get(),
          .terrain = &terrain,
          .map = map.get(),
          .cloud = &cloud,
          .on_localised = [this](const core::Pose& T_map_odom) { simulator->SetLocalisation(T_map_odom); },
          .on_placed =
              [this](const core::AnchoredSpin& placed) {
                metrics.ObservePlace({placed.keyframe, placed.T_keyframe_odom * simulator->T_odom_base()},
                                     T_map_base(), localiser->poses());
                metrics.ObserveOdometry(localiser->odometry_health());
              },
          .on_cloud =
              [this](const mapping::ReturnCloud& returns, core::KeyframeId keyframe,
                     const core::PoseSource& poses) {
                metrics.TakeCloud(returns, keyframe, poses);
                metrics.ObserveMapped(*map, keyframe);
                returns_map.insert(returns_map.end(), returns.points.begin(), returns.points.end());
              }};
}

}  // namespace atlas::experiments
