// How a mission ends, in the words of summary.json.
#pragma once

#include <optional>

#include "experiments/results/run_summary.h"
#include "planner/decision.h"
#include "sim/simulator.h"

namespace atlas::experiments {

struct Ending {
  RunStatus status;
  StopReason reason;
};

/// How a motion ends the mission; nothing if the mission goes on, as it does where the robot is stuck once.
std::optional<Ending> EndingOf(sim::MotionStatus status);

/// Walks that got stuck, one after another: three of them end a mission.
class FailedWalks {
 public:
  std::optional<Ending> Observe(sim::MotionStatus walk);

 private:
  int count_ = 0;
};

/// How a plan ends the mission: by what the robot knows, never by the truth. Nothing if there is a view to go
/// to.
std::optional<Ending> EndingOf(const planner::Decision& decision);

}  // namespace atlas::experiments
