// Two mappers under the same seeds: what one covers more than the other.
#pragma once

#include <vector>

#include "experiments/metrics/run_recorder.h"
#include "experiments/report/tables.h"

namespace atlas::experiments {

struct RunWithCurve {
  RunSummary summary;
  CoverageCurve curve;
};

/// One row for each experiment, gain and planner whose runs come in pairs that differ in the mapper only
/// (same seed, robot and locomotion): the mean of the pairs' differences, se_atlas less octomap, at the
/// missions' ends and after as many scans as both took. No rows where nothing pairs.
TextTable MapperPairsTable(const std::vector<RunWithCurve>& runs);

}  // namespace atlas::experiments
