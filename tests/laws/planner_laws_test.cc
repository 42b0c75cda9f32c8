// What every planner of the catalogue is held to.
#include <gtest/gtest.h>

#include "planner/planners/catalog.h"
#include "tests/support/side_mapped_object.h"

namespace atlas::planner {
namespace {

using core::Vec2;
using tests::PlanResult;

class PlannerLaw : public ::testing::TestWithParam<std::string> {
 protected:
  /// Asked before the object, from whose near side it has taken one scan.
  static PlanResult Decide(int threads, uint64_t seed,
                           const tests::FlatGround& ground = tests::GroundAboutObject(Vec2(0.0, -3.0))) {
    tests::PlannerSettings settings{.name = GetParam(), .values = {}};
    if (settings.name == "route") settings.Set("route", "[0 -3, 2 -3 90]");
    const auto stand = tests::StandAtObject(settings, threads, seed);
    stand->OnSweep(tests::kStandAtObject, 500);
    return stand->Plan(tests::kStandAtObject, tests::NearSideMapped(), ground);
  }
};

TEST_P(PlannerLaw, GoesFromTheRobotToTheViewThatItsLogCallsBest) {
  const PlanResult plan = Decide(1, 1);
  ASSERT_EQ(plan.outcome, "view");
  ASSERT_GE(plan.best, 0);
  ASSERT_LT(plan.best, static_cast<int>(plan.candidates.size()));
  const auto& go = std::get<GoScan>(plan.decision);
  const Candidate& best = plan.candidates[static_cast<size_t>(plan.best)];
  EXPECT_EQ(best.reason, LossReason::kChosen);
  EXPECT_EQ(go.p_map, best.p_map);
  EXPECT_EQ(go.yaw_rad, best.yaw_rad);
  ASSERT_FALSE(go.path_map.empty());
  EXPECT_LT((go.path_map.front() - Vec2(0.0, -3.0)).norm(), 1e-9);
  EXPECT_LT((go.path_map.back() - go.p_map).norm(), 1e-9);
  double length_m = 0.0;
  for (size_t i = 1; i < go.path_map.size(); ++i) length_m += (go.path_map[i] - go.path_map[i - 1]).norm();
  EXPECT_NEAR(plan.path_length_m, length_m, 1e-9);
}

TEST_P(PlannerLaw, OneSeedIsOneDecisionOnAnyNumberOfThreads) {
  const PlanResult one = Decide(1, 5), three = Decide(3, 5);
  EXPECT_EQ(one.outcome, three.outcome);
  EXPECT_EQ(one.path_map, three.path_map);
  EXPECT_EQ(one.best, three.best);
  ASSERT_EQ(one.candidates.size(), three.candidates.size());
  for (size_t i = 0; i < one.candidates.size(); ++i) {
    EXPECT_EQ(one.candidates[i].utility, three.candidates[i].utility) << i;
  }
}

/// The base stands 0.44 m above it.
TEST_P(PlannerLaw, ViewsStandOnTheGroundWhereverTheyCameFrom) {
  tests::FlatGround walled = tests::GroundAboutObject(Vec2(0.0, -3.0));
  walled.AddObstacle(Vec2(-20.0, -20.0), Vec2(20.0, 20.0));
  for (const PlanResult& plan : {Decide(1, 1), Decide(1, 1, walled)}) {
    ASSERT_FALSE(plan.candidates.empty());
    for (const Candidate& c : plan.candidates) EXPECT_NEAR(c.ground_m, 0.0, 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, PlannerLaw, ::testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const PlannerEntry& entry : PlannerCatalog()) names.push_back(entry.name);
                           return names;
                         }()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace atlas::planner
