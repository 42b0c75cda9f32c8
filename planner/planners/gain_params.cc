#include "planner/planners/gain_params.h"

#include "planner/gain/gain.h"

namespace atlas::planner {

void GainParams::Visit(core::ParamVisitor& v) {
  v.Field("gain", &gain,
          {.choices = GainNames(),
           .doc = "information gain that decides; greedy, explore: that modulates what decides, the surface "
                  "that a view uncovers (gain_share)"});
  v.Field("extra_gains", &extra_gains,
          {.choices = GainNames(), .doc = "also computed from the same rays and logged for every candidate"});
}

}  // namespace atlas::planner
