#include "experiments/mission/run_localiser.h"

#include "mapping/atlas/saved_atlas.h"
#include "mapping/atlas/saved_slam.h"
#include "mapping/slam/lidar_front_end.h"

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
  const mapping::LocaliserStart start = LocaliserStartFor(config, scene, simulator, threads);
  const bool matched = config.localisation.lidar && config.localisation.name != "truth";
  return matched ? mapping::PutLidarOdometryBefore(config.localisation, start, rng)
                 : mapping::MakeLocaliser(config.localisation, start, rng);
}

void SaveSession(const std::filesystem::path& folder, mapping::Localiser* localiser) {
  const std::filesystem::path atlas = folder / "atlas";
  if (!mapping::IsAtlasFolder(atlas)) return;
  localiser->Settle();
  const auto memory = localiser->Memory();
  if (memory && !memory->graph.edges.empty()) mapping::WriteSlamMemory(mapping::SlamFolderOf(atlas), *memory);
}

}  // namespace atlas::experiments
