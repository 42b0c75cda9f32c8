// The gains that a planner is asked for.
#pragma once

#include <string>
#include <vector>

#include "core/params.h"

namespace atlas::planner {

struct GainParams {
  std::string gain;                      ///< the one that decides
  std::vector<std::string> extra_gains;  ///< also computed and logged for every candidate, from the same rays
  void Visit(core::ParamVisitor& v);
};

}  // namespace atlas::planner
