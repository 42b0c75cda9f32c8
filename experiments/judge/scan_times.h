// Wall-clock times of one scan: what depends on the machine.
#pragma once

#include <cstddef>

namespace atlas::experiments {

struct ScanTimes {
  double nbv_time_s = 0.0;      ///< candidates, gains, costs, path
  double integration_ms = 0.0;  ///< the map alone, all revolutions since the scan before
  double terrain_ms = 0.0;
  double metrics_ms = 0.0;
  double sweep_wall_s = 0.0;  ///< simulating the sweep
  double walk_wall_s = 0.0;   ///< simulating the walk that led here
  double wall_time_s = 0.0;   ///< since the run began
  size_t map_bytes = 0;
};

}  // namespace atlas::experiments
