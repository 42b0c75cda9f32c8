// The text of a run folder's tables, with fixed formatting: the same rows give the same bytes.
#pragma once

#include <string>
#include <vector>

#include "planner/decision.h"

namespace atlas::experiments {

/// Header of candidates.csv; extra gains become columns `gain_NAME`.
std::string CandidatesCsvHeader(const std::vector<std::string>& extra_gains);

/// A line a candidate; what its planner did not compute is an empty cell. `extra_count` columns follow the
/// fixed ones.
void AppendCandidateRows(int scan, const planner::DecisionLog& log, size_t extra_count, std::string* csv);

}  // namespace atlas::experiments
