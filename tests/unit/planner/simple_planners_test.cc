#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "planner/travel/costs.h"
#include "tests/support/side_mapped_object.h"

namespace atlas::planner {
namespace {

using core::Vec2;
using namespace tests;

TEST(FrontierPlanner, GoesToTheNearestViewThatUncoversEnough) {
  const auto map = NearSideMapped();
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  PlannerSettings params{.name = "frontier", .values = {}};
  params.Set("nodes", 60);
  params.Set("rays", 300);
  params.Set("frontier_m2", 0.2);
  const auto planner = StandAtObject(params);
  planner->OnSweep(kStandAtObject, 500);
  const PlanResult decision = planner->Plan(kStandAtObject, map, ground);
  ASSERT_EQ(decision.outcome, "view");
  const Candidate& view = decision.candidates[static_cast<size_t>(decision.best)];
  EXPECT_GE(view.gain, 0.2);
  size_t nearer = 0, farther = 0;
  for (const Candidate& c : decision.candidates) {
    nearer += c.gain >= 0.2 && c.path_length_m < view.path_length_m - 1e-9;
    farther += c.gain >= 0.2 && c.path_length_m > view.path_length_m + 0.5;
  }
  EXPECT_EQ(nearer, 0u);
  EXPECT_GT(farther, 0u);
  const auto done = StandAtObject(params);
  done->OnSweep(kStandAtObject, 500);
  EXPECT_EQ(done->Plan(kStandAtObject, NearSideMapped(0.12), ground).outcome, "gain_exhausted");
}

TEST(RandomPlanner, TakesReachableViewsOfAllDirectionsAndNeverEnds) {
  const auto map = NearSideMapped(0.12);
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const auto decide = [&](uint64_t seed) {
    const auto planner = StandAtObject({.name = "random", .values = {}}, 1, seed);
    std::vector<Vec2> views;
    for (int i = 0; i < 40; ++i) {
      planner->OnSweep(kStandAtObject, 0);
      const PlanResult decision = planner->Plan(kStandAtObject, map, ground);
      EXPECT_EQ(decision.outcome, "view");
      views.push_back(decision.path_map.back());
    }
    return views;
  };
  const std::vector<Vec2> views = decide(1);
  EXPECT_EQ(views, decide(1));
  EXPECT_NE(views, decide(2));
  int left = 0, ahead = 0;
  for (const Vec2& p : views) {
    EXPECT_EQ(ground.KindAt({p.x(), p.y(), 0.0}), mapping::GroundKind::kFree);
    left += p.x() < 0.0;
    ahead += p.y() > -3.0;
  }
  EXPECT_NEAR(left, 20, 12);
  EXPECT_NEAR(ahead, 20, 12);
}

}  // namespace
}  // namespace atlas::planner
