// How missions end, as docs/runs.md says.
#include "experiments/mission/ending.h"

#include <gtest/gtest.h>

#include "experiments/results/run_recorder.h"

namespace atlas::experiments {
namespace {

using planner::NbvOutcome;
using sim::MotionStatus;

/// "completed (gain_exhausted)"; "" where the mission goes on.
std::string TextOf(const std::optional<Ending>& ending) {
  if (!ending) return "";
  return std::string(NameOf(ending->status)) + " (" + std::string(NameOf(ending->reason)) + ")";
}

TEST(Ending, OfEveryPlanIsStatusAndReason) {
  const std::vector<std::pair<NbvOutcome, std::string>> of_objects = {
      {NbvOutcome::kView, ""},
      {NbvOutcome::kGainExhausted, "completed (gain_exhausted)"},
      {NbvOutcome::kSurfaceFlat, "completed (surface_flat)"},
      {NbvOutcome::kRouteDone, "completed (route_done)"},
      {NbvOutcome::kBlockedNarrow, "budget (blocked_narrow)"},
      {NbvOutcome::kOutOfReach, "stuck (out_of_reach)"},
      {NbvOutcome::kNoCandidates, "stuck (no_candidates)"}};
  for (const auto& [outcome, text] : of_objects) {
    EXPECT_EQ(TextOf(EndingOf(outcome, false)), text);
    const std::string of_space = outcome == NbvOutcome::kGainExhausted ? "completed (explored)" : text;
    EXPECT_EQ(TextOf(EndingOf(outcome, true)), of_space) << "of scenes to explore";
  }
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
