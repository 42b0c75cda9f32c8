#include "experiments/mission/run_localiser.h"

namespace atlas::experiments {

mapping::LocaliserStart LocaliserStartFor(const ExperimentConfig& config, const scenes::SceneSpec& scene,
                                          const sim::Simulator& simulator, int threads) {
  mapping::LocaliserStart start{.T_map_odom = scene.T_map_spawn,
                                .T_odom_base = simulator.T_odom_base(),
                                .T_map_base_true = {},
                                .threads = threads};
  // An empty function throws when it is called: a leak does not go unnoticed.
  if (config.localisation.name == "truth") {
    start.T_map_base_true = [&simulator] { return simulator.TrueBasePose(); };
  }
  return start;
}

std::unique_ptr<mapping::Localiser> MakeLocaliserFor(const ExperimentConfig& config,
                                                     const scenes::SceneSpec& scene,
                                                     const sim::Simulator& simulator, int threads,
                                                     const core::Rng& rng) {
  return mapping::MakeLocaliser(config.localisation, LocaliserStartFor(config, scene, simulator, threads),
                                rng);
}

}  // namespace atlas::experiments
