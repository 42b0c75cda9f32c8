#include "experiments/bench/false_loops_sweep.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/files.h"

namespace atlas::experiments {
namespace {

FalseLoopSweep SmallSweep(int threads) {
  FalseLoopSweep sweep;
  sweep.nodes = 300;
  sweep.shares = {0.3};
  sweep.seeds = 2;
  sweep.threads = threads;
  return sweep;
}

std::vector<FalseLoopOutcome> RunSmall(int threads) {
  return RunFalseLoops(
      SmallSweep(threads), [](double) {}, [] { return false; });
}

TEST(FalseLoopSweep, FourKindsAndEverySeedAndLeastSquaresIsMisled) {
  const std::vector<FalseLoopOutcome> outcomes = RunSmall(2);
  ASSERT_EQ(outcomes.size(), 8u);
  for (const FalseLoopOutcome& o : outcomes) {
    EXPECT_NEAR(static_cast<double>(o.false_loops) / static_cast<double>(o.loops), 0.3, 0.06);
    EXPECT_TRUE(o.survived()) << o.ate_m << " " << o.ate_clean_m;
    EXPECT_GT(o.recall(), 0.95);
    EXPECT_LT(o.ate_clean_m, o.ate_odometry_m);
  }
  double misled = 0.0;
  for (const FalseLoopOutcome& o : outcomes) misled = std::max(misled, o.ate_squared_m);
  EXPECT_GT(misled, 1.0) << "else the false loops are harmless, and nothing was survived";
}

TEST(FalseLoopSweep, DoesNotDependOnThreads) {
  const std::vector<FalseLoopOutcome> one = RunSmall(1), three = RunSmall(3);
  ASSERT_EQ(one.size(), three.size());
  for (size_t k = 0; k < one.size(); ++k) {
    EXPECT_EQ(one[k].ate_m, three[k].ate_m);
    EXPECT_EQ(one[k].setting.seed, three[k].setting.seed);
  }
}

TEST(FalseLoopSweep, SurvivalIsFivePercentAndACentimetre) {
  FalseLoopOutcome outcome;
  outcome.ate_clean_m = 0.2;
  outcome.ate_m = 0.2199;
  EXPECT_TRUE(outcome.survived());
  outcome.ate_m = 0.2201;
  EXPECT_FALSE(outcome.survived());
}

TEST(FalseLoopSweep, TableGathersSeeds) {
  std::vector<FalseLoopOutcome> outcomes(3);
  outcomes[1].setting.seed = 12;
  outcomes[1].ate_m = 1.0;
  outcomes[2].setting.share = 0.3;
  const std::string table = FalseLoopTable(outcomes);
  EXPECT_NE(table.find("1 of 2"), std::string::npos) << table;
  EXPECT_NE(table.find("1 of 1"), std::string::npos) << table;
}

}  // namespace
}  // namespace atlas::experiments
