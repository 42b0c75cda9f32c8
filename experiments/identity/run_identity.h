// Which run this is, seed aside: a hash over all that can change its result.
#pragma once

#include <string>

#include "experiments/identity/experiment_config.h"
#include "experiments/identity/run_settings.h"

namespace atlas::experiments {

struct RunIdentity {
  RunSettings settings;     ///< resolved; scene.name and robot.name by their digests, the contents in them
  std::string config_hash;  ///< 16 hexadecimal digits over `settings`
  std::string commit;       ///< of the program
};

/// @throws InputError where the scene's or the robot's files cannot be read.
RunIdentity IdentityOf(const ExperimentConfig& config);

/// The commit that was built: "1a2b3c4"; with changes "1a2b3c4+5d6e7f80", a hash over the sources; without a
/// repository "+5d6e7f80".
std::string BuildCommit();

}  // namespace atlas::experiments
