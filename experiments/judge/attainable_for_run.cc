#include <fmt/format.h>

#include "core/files.h"
#include "experiments/identity/experiment_config.h"
#include "experiments/identity/run_options.h"
#include "experiments/judge/attainable.h"
#include "experiments/judge/explored_volume.h"

namespace atlas::experiments {

AttainableOptions AttainableOptionsFor(const ExperimentConfig& config, int threads) {
  AttainableOptions options;
  options.radius_m = config.mission.coverage_radius_m;
  options.max_range_m = config.mapper.integrator.max_range_m;
  options.sweep_roll_deg = config.sim.locomotion.sweep_roll_deg;
  options.sweep_period_s = config.sim.locomotion.sweep_period_s;
  options.threads = threads;
  return options;
}

std::vector<uint8_t> AttainableFor(const ExperimentConfig& config, const RunOptions& options,
                                   const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                   const scenes::GroundTruth& truth) {
  return LoadOrComputeAttainable(
             scene, truth, robot, robots::LidarOf(robot, config.sim.sensors.lidar),
             AttainableOptionsFor(config, options.threads), core::CacheDirectory(),
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
      scene, robot, robots::LidarOf(robot, config.sim.sensors.lidar), volume,
      SceneRays(scene, options.threads), [&options](double share) {
        options.progress(fmt::format("finding what volume is attainable: {:3.0f} %", 100.0 * share), false);
      });
}

}  // namespace atlas::experiments
