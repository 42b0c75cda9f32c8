// The closed loop: sweep, integrate, update terrain, plan, observe metrics, stop or walk (thesis Fig. 3.6).
#pragma once

#include "experiments/identity/experiment_config.h"
#include "experiments/identity/run_options.h"
#include "experiments/results/run_summary.h"

namespace atlas::experiments {

/// Copies scene and robot to the run folder, runs one mission with the copies to its end and writes the
/// folder, the final status after all else. @throws InputError for bad input, before anything moves, and
/// where the folder cannot be written or the video not be made; the summary then says `failed`, or
/// `interrupted` where not even that can be written.
RunSummary RunClosedLoop(const ExperimentConfig& given, const RunOptions& options);

}  // namespace atlas::experiments
