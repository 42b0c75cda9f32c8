// Where a run that bears the thesis's name does otherwise than the thesis.
#pragma once

#include <string>
#include <vector>

#include "experiments/identity/experiment_config.h"

namespace atlas::experiments {

/// Of a run with planner `thesis`: one entry a choice that differs from thesis 3.3 to 3.6, or that the thesis
/// leaves open and a number depends on, in words for under a table; the thesis's own in brackets. Empty for
/// planners that are not the thesis's.
std::vector<std::string> DeviationsFromThesis(const ExperimentConfig& config);

}  // namespace atlas::experiments
