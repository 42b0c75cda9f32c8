#include "sim/locomotion/gait_schedule.h"

#include <cmath>

namespace atlas::sim {

void GaitSchedule::Advance(double dt_s) {
  phase_ += dt_s / kPeriodS;
  phase_ -= std::floor(phase_);
}

double GaitSchedule::LegPhase(int i) const {
  const double phase = phase_ + kOffset[static_cast<size_t>(i)];
  return phase - std::floor(phase);
}

}  // namespace atlas::sim
