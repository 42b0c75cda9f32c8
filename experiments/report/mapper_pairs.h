// Two mappers under the same seeds: what one covers more than the other.
#pragma once

#include <array>
#include <vector>

#include "experiments/report/run_groups.h"
#include "experiments/report/text_table.h"

namespace atlas::experiments {

/// A time whose ratio over pairs is a column.
struct PairRatio {
  const char* heading;
  const char* number;  ///< of summary.json
};
inline constexpr std::array<PairRatio, 2> kPairRatios = {
    {{"integration", "integration_ms_mean"}, {"t_nbv", "nbv_time_s_mean"}}};

/// One row for each two groups that differ in the mapper only (parameters that just one of the mappers has
/// aside): over the pairs of runs with the same seed the mean difference, se_atlas less the other, at the
/// missions' ends and after as many scans as both took, and the ratios of times over the pairs that have
/// both. No rows where nothing pairs.
TextTable MapperPairsTable(const std::vector<RunGroup>& groups);

}  // namespace atlas::experiments
