// What the clouds of a run come to, scored against the truth.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry.h"
#include "experiments/judge/coverage.h"
#include "mapping/map.h"

namespace atlas::experiments {

struct CloudScore {
  double coverage = 0.0, coverage_raw = 0.0, coverage_outer = 0.0;
  std::optional<double> of_attainable = {};     ///< where that was asked for
  std::vector<uint8_t> covered, covered_outer;  ///< a truth point each
  CloudError error;
  size_t returns = 0;  ///< of the accumulated cloud that this score counts
  core::Pose T_truth_cloud = core::Pose::Identity();
  double seconds = 0.0;  ///< wall-clock time since the last score
  size_t map_bytes = 0;
  size_t submaps = 1;
  std::vector<mapping::SubmapMembers> submap_members = {};  ///< of a map that has many
  std::optional<double> explored_m3 = {};
};

}  // namespace atlas::experiments
