#include "experiments/results/run_summary.h"

#include <gtest/gtest.h>

namespace atlas::experiments {
namespace {

TEST(RunSummaryTest, OnlyCompletedAndBudgetExitWithZero) {
  EXPECT_EQ(ExitCodeOf(RunStatus::kCompleted), 0);
  EXPECT_EQ(ExitCodeOf(RunStatus::kBudget), 0);
  EXPECT_EQ(ExitCodeOf(RunStatus::kRobotFell), 1);
  EXPECT_EQ(ExitCodeOf(RunStatus::kStuck), 1);
  EXPECT_EQ(ExitCodeOf(RunStatus::kFailed), 1);
  EXPECT_EQ(ExitCodeOf(RunStatus::kInterrupted), 130);
}

TEST(RunSummaryTest, WhatWasInterruptedOrFailedIsRunAgain) {
  for (const RunStatus status :
       {RunStatus::kCompleted, RunStatus::kBudget, RunStatus::kRobotFell, RunStatus::kStuck}) {
    EXPECT_TRUE(IsFinal(status)) << NameOf(status);
  }
  EXPECT_FALSE(IsFinal(RunStatus::kInterrupted));
  EXPECT_FALSE(IsFinal(RunStatus::kFailed));
}

}  // namespace
}  // namespace atlas::experiments
