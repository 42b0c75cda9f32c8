// What a sweep's folder already holds of it: which runs need not be run again, and why the others must.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/results/run_summary.h"
#include "experiments/sweep/sweep_spec.h"

namespace atlas::experiments {

/// kDone: final, of this very configuration and program. kStale: final, but of another. kBroken: interrupted,
/// failed or damaged. kNew: nothing there.
enum class RunState { kDone, kStale, kBroken, kNew };

struct RunStanding {
  RunState state = RunState::kNew;
  std::string why = "";  ///< stale: "planner.nodes changed"; broken: "interrupted"
  std::optional<RunSummary> summary = std::nullopt;  ///< of done and stale runs
};
/// @pre run.identity
RunStanding StandingOf(const SweepRun& run);

/// "12 done, 3 stale (planner.nodes changed), 1 broken (interrupted), 8 new", counts of nothing left out.
std::string CountsText(const std::vector<RunStanding>& standings);

}  // namespace atlas::experiments
