// Two mappers under the same seeds: what one covers more than the other.
#pragma once

#include <string>
#include <vector>

#include "experiments/metrics/run_recorder.h"
#include "experiments/report/tables.h"

namespace atlas::experiments {

struct RunWithCurve {
  RunSummary summary;
  std::string variant;  ///< further settings that a sweep varied, without the mapper
  CoverageCurve curve;
};

/// One row for each experiment, gain, planner and variant whose runs come in pairs that differ in the mapper
/// only: the mean of the pairs' differences, se_atlas less octomap, at the missions' ends and after as many
/// scans as both took, and of the ratios of times over the pairs that have both. No rows where nothing pairs.
TextTable MapperPairsTable(const std::vector<RunWithCurve>& runs);

}  // namespace atlas::experiments
