// How many false loops the back end survives: `./atlas sweep false_loops`.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "mapping/slam/false_loops.h"

namespace atlas::experiments {

/// Not of missions, and so not a file of experiments/configs/sweeps.
inline constexpr const char* kFalseLoopSweep = "false_loops";
inline constexpr const char* kFalseLoopSweepDoc =
    "robust back ends on a graph of 1,100 nodes through rooms with 10, 30 and 50 % false loops of four kinds";

struct FalseLoopSetting {
  mapping::FalseLoopKind kind = mapping::FalseLoopKind::kRandom;
  double share = 0.1;  ///< of all loops, the false ones
  int seed = 11;
};

/// One graph, with and without its false loops. Trajectory errors (root mean squares, aligned) in metres.
struct FalseLoopOutcome {
  FalseLoopSetting setting;
  size_t loops = 0, false_loops = 0;
  double ate_odometry_m = 0.0;
  double ate_clean_m = 0.0;                      ///< least squares over the true loops
  double ate_m = 0.0;                            ///< GNC
  double ate_dcs_m = 0.0, ate_squared_m = 0.0;   ///< dynamic covariance scaling; least squares
  size_t rejected_false = 0, rejected_true = 0;  ///< by GNC
  double time_s = 0.0;                           ///< of GNC

  double recall() const;     ///< of false loops that are rejected
  double precision() const;  ///< of rejected loops that are false
  /// Within 5 % and 1 cm of the graph without false loops.
  bool survived() const { return ate_m <= 1.05 * ate_clean_m + 0.01; }
};

struct FalseLoopSweep {
  uint32_t nodes = 1100;
  std::vector<double> shares = {0.1, 0.3, 0.5};
  int first_seed = 11, seeds = 10;
  int threads = 1;  ///< graphs at a time
};

/// Four kinds of false loops, each share and seed. Repeats exactly but for its times.
std::vector<FalseLoopOutcome> RunFalseLoops(const FalseLoopSweep& sweep,
                                            const std::function<void(double share_done)>& progress,
                                            const std::function<bool()>& should_stop);

/// A row a kind and share.
std::string FalseLoopTable(const std::vector<FalseLoopOutcome>& outcomes);
/// false_loops.md, and false_loops.csv with a row a graph.
void WriteFalseLoops(const std::filesystem::path& folder, const std::vector<FalseLoopOutcome>& outcomes);

}  // namespace atlas::experiments
