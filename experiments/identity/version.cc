#include "experiments/identity/version.h"

#include "experiments/identity/run_identity.h"

namespace atlas::experiments {

std::string Version() {
  return ATLAS_VERSION;
}

std::string VersionText() {
  const std::string commit = BuildCommit();
  return "atlas " + Version() + (commit.empty() ? "" : " (" + commit + ")");
}

}  // namespace atlas::experiments
