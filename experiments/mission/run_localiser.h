// The one place that hands the truth to a localiser: to `truth`, which every table names.
#pragma once

#include <filesystem>
#include <memory>

#include "experiments/identity/experiment_config.h"
#include "scenes/scene_spec.h"
#include "sim/simulator.h"

namespace atlas::experiments {

/// What a run's localiser starts from; the truth is there for `truth` alone. `simulator` outlives it.
mapping::LocaliserStart LocaliserStartFor(const ExperimentConfig& config, const scenes::SceneSpec& scene,
                                          const sim::Simulator& simulator, int threads);

/// The localiser of a run, at its start. `simulator` outlives it.
std::unique_ptr<mapping::Localiser> MakeLocaliserFor(const ExperimentConfig& config,
                                                     const scenes::SceneSpec& scene,
                                                     const sim::Simulator& simulator, int threads,
                                                     const core::Rng& rng);

/// Settles the localiser and writes, beside the run's atlas, what a later session can go on from; nothing
/// where there is no atlas, or the localiser remembers nothing.
void SaveSession(const std::filesystem::path& folder, mapping::Localiser* localiser);

}  // namespace atlas::experiments
