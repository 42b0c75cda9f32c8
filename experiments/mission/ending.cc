#include "experiments/mission/ending.h"

namespace atlas::experiments {

using planner::NbvOutcome;

std::optional<Ending> EndingOf(sim::MotionStatus status) {
  switch (status) {
    case sim::MotionStatus::kFell:
      return Ending{RunStatus::kRobotFell, StopReason::kFell};
    case sim::MotionStatus::kStopped:
      return Ending{RunStatus::kInterrupted, StopReason::kSignal};
    case sim::MotionStatus::kReached:
    case sim::MotionStatus::kStuck:
      break;
  }
  return std::nullopt;
}

std::optional<Ending> FailedWalks::Observe(sim::MotionStatus walk) {
  constexpr int kMost = 3;
  count_ = walk == sim::MotionStatus::kStuck ? count_ + 1 : 0;
  if (count_ < kMost) return std::nullopt;
  return Ending{RunStatus::kStuck, StopReason::kStuck};
}

std::optional<Ending> EndingOf(NbvOutcome outcome, bool is_space) {
  switch (outcome) {
    case NbvOutcome::kView:
      return std::nullopt;
    case NbvOutcome::kGainExhausted:
      return Ending{RunStatus::kCompleted, is_space ? StopReason::kExplored : StopReason::kGainExhausted};
    case NbvOutcome::kSurfaceFlat:
      return Ending{RunStatus::kCompleted, StopReason::kSurfaceFlat};
    case NbvOutcome::kRouteDone:
      return Ending{RunStatus::kCompleted, StopReason::kRouteDone};
    case NbvOutcome::kBlockedNarrow:
      return Ending{RunStatus::kBudget, StopReason::kBlockedNarrow};
    case NbvOutcome::kOutOfReach:
      return Ending{RunStatus::kStuck, StopReason::kOutOfReach};
    case NbvOutcome::kNoCandidates:
      break;
  }
  return Ending{RunStatus::kStuck, StopReason::kNoCandidates};
}

}  // namespace atlas::experiments
