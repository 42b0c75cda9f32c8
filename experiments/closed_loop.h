// The closed loop: sweep, integrate, update terrain, plan, observe metrics, stop or walk (thesis Fig. 3.6).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "experiments/experiment_config.h"
#include "experiments/metrics/run_summary.h"

namespace atlas::experiments {

struct RunOptions {
  uint64_t seed = 1;
  int threads = 1;
  std::filesystem::path folder;  ///< the run folder, written as the run goes
  /// Polled while the robot moves; true ends the run as `interrupted`, its folder valid.
  std::function<bool()> should_stop = [] { return false; };
  /// One line on what is going on, after every stage; `final` lines end a scan.
  std::function<void(const std::string& line, bool final)> progress = [](const std::string&, bool) {};
};

/// Copies scene and robot to the run folder, runs one mission with the copies to its end and writes the
/// folder. @throws InputError for bad input, before anything moves.
RunSummary RunClosedLoop(const ExperimentConfig& given, const RunOptions& options);

}  // namespace atlas::experiments
