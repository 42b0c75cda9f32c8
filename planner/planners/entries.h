// The entry of every planner.
#pragma once

#include "planner/planners/planner_params.h"

namespace atlas::planner {

#define ATLAS_PLANNER(Name) PlannerEntry Name##Planner();
#include "planner/planners/catalog.inc"
#undef ATLAS_PLANNER

}  // namespace atlas::planner
