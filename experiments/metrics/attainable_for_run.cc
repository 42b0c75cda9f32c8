#include <fmt/format.h>

#include "core/files.h"
#include "experiments/closed_loop.h"
#include "experiments/metrics/attainable.h"

namespace atlas::experiments {

std::vector<uint8_t> AttainableFor(const ExperimentConfig& config, const RunOptions& options,
                                   const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                   const scenes::GroundTruth& truth) {
  const std::string& named = config.sim.sensors.lidar;
  const core::LidarModel lidar = core::FindLidarModel(named == "robot" ? robot.lidar_model : named);
  AttainableOptions attainable;
  attainable.radius_m = config.mission.coverage_radius_m;
  attainable.max_range_m = config.mapper.max_range_m;
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

}  // namespace atlas::experiments
