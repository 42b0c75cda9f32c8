#include "experiments/mission/run_localiser.h"

namespace atlas::experiments {

std::unique_ptr<mapping::Localiser> MakeLocaliserFor(const ExperimentConfig& config,
                                                     const scenes::SceneSpec& scene,
                                                     const sim::Simulator& simulator, const core::Rng& rng) {
  return mapping::MakeLocaliser(config.localisation,
                                {.T_map_odom = scene.T_map_spawn,
                                 .T_odom_base = simulator.T_odom_base(),
                                 .T_map_base_true = [&simulator] { return simulator.TrueBasePose(); }},
                                rng);
}

}  // namespace atlas::experiments
