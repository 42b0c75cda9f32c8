#include <fmt/format.h>

#include "core/files.h"
#include "experiments/closed_loop.h"
#include "experiments/metrics/attainable.h"
#include "experiments/metrics/explored_volume.h"

namespace atlas::experiments {

namespace {

core::LidarModel LidarOf(const ExperimentConfig& config, const robots::RobotSpec& robot) {
  const std::string& named = config.sim.sensors.lidar;
  return core::FindLidarModel(named == "robot" ? robot.lidar_model : named);
}

}  // namespace

std::vector<uint8_t> AttainableFor(const ExperimentConfig& config, const RunOptions& options,
                                   const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                   const scenes::GroundTruth& truth) {
  const core::LidarModel lidar = LidarOf(config, robot);
  AttainableOptions attainable;
  attainable.radius_m = config.mission.coverage_radius_m;
  attainable.max_range_m = config.mapper.integrator.max_range_m;
  attainable.sweep_roll_deg = config.sim.locomotion.sweep_roll_deg;
  attainable.sweep_period_s = config.sim.locomotion.sweep_period_s;
  attainable.threads = options.threads;
  return LoadOrComputeAttainable(
             scene, truth, robot, lidar, attainable, core::CacheDirectory(),
             [&options](double share) {
               options.progress(fmt::format("finding what is attainable: {:3.0f} %", 100.0 * share), false);
             })
      .attainable;
}

std::unique_ptr<ExploredVolume> ExploredVolumeFor(const ExperimentConfig& config, const RunOptions& options,
                                                  const scenes::SceneSpec& scene,
                                                  const robots::RobotSpec& robot) {
  if (!scene.is_space) return nullptr;
  VolumeOptions volume;
  volume.max_range_m = config.mapper.integrator.max_range_m;
  volume.sweep_roll_deg = config.sim.locomotion.sweep_roll_deg;
  volume.threads = options.threads;
  return std::make_unique<ExploredVolume>(
      scene, robot, LidarOf(config, robot), volume, SceneRays(scene, options.threads),
      [&options](double share) {
        options.progress(fmt::format("finding what volume is attainable: {:3.0f} %", 100.0 * share), false);
      });
}

}  // namespace atlas::experiments
