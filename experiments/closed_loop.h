// The closed loop: sweep, integrate, update terrain, plan, observe metrics, stop or walk (thesis Fig. 3.6).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "experiments/experiment_config.h"
#include "experiments/metrics/run_summary.h"

namespace atlas::experiments {

struct RunOptions {
  int threads = 1;
  std::filesystem::path folder;  ///< the run folder, written as the run goes
  /// Called once all is built, before the robot moves. Until then the run folder says `interrupted`, and
  /// ending the process loses nothing.
  std::function<void()> prepared = [] {};
  /// Polled while the robot moves and while the video is made; true ends the run as `interrupted`, its folder
  /// valid.
  std::function<bool()> should_stop = [] { return false; };
  /// One line on what is going on, after every stage; `final` lines end a scan.
  std::function<void(const std::string& line, bool final)> progress = [](const std::string&, bool) {};
};

/// Copies scene and robot to the run folder, runs one mission with the copies to its end and writes the
/// folder, the final status after all else. @throws InputError for bad input, before anything moves, and
/// where the folder cannot be written or the video not be made; the summary then says `failed`, or
/// `interrupted` where not even that can be written.
RunSummary RunClosedLoop(const ExperimentConfig& given, const RunOptions& options);

}  // namespace atlas::experiments
