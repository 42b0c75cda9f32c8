// From a loop accepted to the corrected snapshot on which planning may start: `./atlas bench correction`.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace atlas::experiments {

struct CorrectionBench {
  uint32_t nodes = 1000;
  uint32_t submaps = 50;
  int corrections = 10;  ///< timed; each by one more loop
  int threads = 1;
};

/// Wall-clock milliseconds of one correction, by what is done one after the other.
struct CorrectionTimes {
  double solve_ms = 0.0;     ///< all nodes, warm, with dynamic covariance scaling
  double apply_ms = 0.0;     ///< poses to keyframes and to roots of submaps
  double snapshot_ms = 0.0;  ///< the map as planners ask it
  double moved_m = 0.0;      ///< the node that moved most
  double full_ms = 0.0;      ///< the full robust pass that follows in the background

  double until_planning_ms() const { return solve_ms + apply_ms + snapshot_ms; }
};

struct CorrectionResult {
  uint32_t nodes = 0;
  size_t loops = 0, submaps = 0, map_bytes = 0;
  std::vector<CorrectionTimes> corrections;
};

/// A graph of laps through rooms, some of whose loops come one by one, and an atlas of scans of rooms_small,
/// each a submap, spread over the nodes.
CorrectionResult RunCorrectionBench(const CorrectionBench& bench,
                                    const std::function<void(double)>& progress);

std::string CorrectionTable(const CorrectionResult& result);
/// correction.md and correction.csv.
void WriteCorrectionBench(const std::filesystem::path& folder, const CorrectionResult& result);

}  // namespace atlas::experiments
