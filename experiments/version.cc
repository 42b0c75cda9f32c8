#include "experiments/version.h"

#include "experiments/run_identity.h"

namespace atlas::experiments {

std::string Version() {
  return ATLAS_VERSION;
}

std::string VersionText() {
  const std::string commit = BuildCommit();
  return "atlas " + Version() + (commit.empty() ? "" : " (" + commit + ")");
}

}  // namespace atlas::experiments
