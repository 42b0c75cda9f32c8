#include "experiments/identity/run_identity.h"

#include "atlas_commit.h"
#include "core/fingerprint.h"
#include "robots/robot_files.h"
#include "scenes/scene_files.h"

namespace atlas::experiments {

RunIdentity IdentityOf(const ExperimentConfig& config) {
  RunIdentity identity{.settings = SettingsOf(config.rows), .config_hash = "", .commit = BuildCommit()};
  identity.settings["scene.name"] = scenes::SceneDigest(config.scene.name);
  identity.settings["robot.name"] = robots::RobotDigest(config.robot.name);
  core::Fingerprint print;
  for (const auto& [path, value] : identity.settings) {
    print.Text(path);
    print.Text(value);
  }
  identity.config_hash = print.Hex();
  return identity;
}

std::string BuildCommit() {
  return ATLAS_COMMIT;
}

}  // namespace atlas::experiments
