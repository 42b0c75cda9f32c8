// Hands a sweep to a Slurm cluster as one job array.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "experiments/sweep/sweep.h"

namespace atlas::experiments {

/// Writes `folder`/runs.txt (a command a line) and `folder`/sweep.sbatch, then submits it where sbatch is
/// installed, else says how. Returns 0, or 1 when sbatch refused.
int SubmitToSlurm(const SweepSpec& spec, const std::vector<SweepRun>& runs, const SweepOptions& options,
                  const std::filesystem::path& folder, std::ostream& out);

}  // namespace atlas::experiments
