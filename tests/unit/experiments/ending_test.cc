// How missions end, as docs/runs.md says.
#include "experiments/mission/ending.h"

#include <gtest/gtest.h>

#include "experiments/results/run_recorder.h"

namespace atlas::experiments {
namespace {

using planner::Done;
using planner::Stuck;
using sim::MotionStatus;

/// "completed (gain_exhausted)"; "" where the mission goes on.
std::string TextOf(const std::optional<Ending>& ending) {
  if (!ending) return "";
  return std::string(NameOf(ending->status)) + " (" + std::string(NameOf(ending->reason)) + ")";
}

TEST(Ending, OfEveryPlanIsStatusAndReason) {
  const std::vector<std::pair<planner::Decision, std::string>> endings = {
      {planner::GoScan{}, ""},
      {Done{Done::Reason::kGainExhausted}, "completed (gain_exhausted)"},
      {Done{Done::Reason::kExplored}, "completed (explored)"},
      {Done{Done::Reason::kSurfaceFlat}, "completed (surface_flat)"},
      {Done{Done::Reason::kRouteDone}, "completed (route_done)"},
      {Done{Done::Reason::kBlockedNarrow}, "budget (blocked_narrow)"},
      {Stuck{Stuck::Reason::kOutOfReach}, "stuck (out_of_reach)"},
      {Stuck{Stuck::Reason::kNoCandidates}, "stuck (no_candidates)"}};
  for (const auto& [decision, text] : endings) EXPECT_EQ(TextOf(EndingOf(decision)), text);
}

TEST(Ending, ComesWithTheThirdFailedWalkInARow) {
  FailedWalks walks;
  for (int round = 0; round < 3; ++round) {
    EXPECT_EQ(TextOf(walks.Observe(MotionStatus::kStuck)), "");
    EXPECT_EQ(TextOf(walks.Observe(MotionStatus::kStuck)), "");
    EXPECT_EQ(TextOf(walks.Observe(MotionStatus::kReached)), "") << "and those before are forgotten";
  }
  EXPECT_EQ(TextOf(walks.Observe(MotionStatus::kStuck)), "");
  EXPECT_EQ(TextOf(walks.Observe(MotionStatus::kStuck)), "");
  EXPECT_EQ(TextOf(walks.Observe(MotionStatus::kStuck)), "stuck (stuck)");
}

TEST(Ending, OfMotionsIsAFallOrASignal) {
  EXPECT_EQ(TextOf(EndingOf(MotionStatus::kReached)), "");
  EXPECT_EQ(TextOf(EndingOf(MotionStatus::kStuck)), "") << "one failed walk is none";
  EXPECT_EQ(TextOf(EndingOf(MotionStatus::kFell)), "robot_fell (fell)");
  EXPECT_EQ(TextOf(EndingOf(MotionStatus::kStopped)), "interrupted (signal)");
}

}  // namespace
}  // namespace atlas::experiments
