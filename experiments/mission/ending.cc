#include "experiments/mission/ending.h"

#include <variant>

namespace atlas::experiments {

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

namespace {

Ending EndingOf(planner::Done::Reason reason) {
  using Reason = planner::Done::Reason;
  switch (reason) {
    case Reason::kExplored:
      return {RunStatus::kCompleted, StopReason::kExplored};
    case Reason::kSurfaceFlat:
      return {RunStatus::kCompleted, StopReason::kSurfaceFlat};
    case Reason::kRouteDone:
      return {RunStatus::kCompleted, StopReason::kRouteDone};
    case Reason::kBlockedNarrow:
      return {RunStatus::kBudget, StopReason::kBlockedNarrow};
    case Reason::kGainExhausted:
      break;
  }
  return {RunStatus::kCompleted, StopReason::kGainExhausted};
}

}  // namespace

std::optional<Ending> EndingOf(const planner::Decision& decision) {
  if (const auto* done = std::get_if<planner::Done>(&decision)) return EndingOf(done->reason);
  const auto* stuck = std::get_if<planner::Stuck>(&decision);
  if (stuck == nullptr) return std::nullopt;
  return Ending{RunStatus::kStuck, stuck->reason == planner::Stuck::Reason::kOutOfReach
                                       ? StopReason::kOutOfReach
                                       : StopReason::kNoCandidates};
}

}  // namespace atlas::experiments
