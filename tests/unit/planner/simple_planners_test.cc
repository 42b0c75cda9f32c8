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
  EXPECT_GE(*view.gain, 0.2);
  size_t nearer = 0, farther = 0;
  for (const Candidate& c : decision.candidates) {
    nearer += *c.gain >= 0.2 && c.path_length_m < view.path_length_m - 1e-9;
    farther += *c.gain >= 0.2 && c.path_length_m > view.path_length_m + 0.5;
  }
  EXPECT_EQ(nearer, 0u);
  EXPECT_GT(farther, 0u);
  const auto done = StandAtObject(params);
  done->OnSweep(kStandAtObject, 500);
  EXPECT_EQ(done->Plan(kStandAtObject, NearSideMapped(0.12), ground).outcome, "gain_exhausted");
}

TEST(FrontierPlanner, AViewThatUncoversNothingIsNoFrontierHoweverLittleIsAskedFor) {
  PlannerSettings params{.name = "frontier", .values = {}};
  params.Set("nodes", 30);
  params.Set("rays", 300);
  params.Set("frontier_m2", 0.0);
  const auto planner = StandAtObject(params);
  planner->OnSweep(kStandAtObject, 500);
  const PlanResult done =
      planner->Plan(kStandAtObject, NearSideMapped(0.12), GroundAboutObject(Vec2(0.0, -3.0)));
  EXPECT_EQ(done.outcome, "gain_exhausted");
  for (const Candidate& c : done.candidates) EXPECT_EQ(c.gain, 0.0);
}

TEST(FrontierPlanner, ComputesNeitherCostsNorUtility) {
  PlannerSettings params{.name = "frontier", .values = {}};
  params.Set("nodes", 10);
  params.Set("rays", 300);
  const auto planner = StandAtObject(params);
  planner->OnSweep(kStandAtObject, 500);
  const PlanResult plan = planner->Plan(kStandAtObject, NearSideMapped(), GroundAboutObject(Vec2(0.0, -3.0)));
  EXPECT_EQ(plan.views_predicted, plan.candidates.size());
  EXPECT_TRUE(plan.blocked.has_value());
  EXPECT_FALSE(plan.utility_ratio.has_value());
  for (const Candidate& c : plan.candidates) {
    EXPECT_TRUE(c.gain.has_value());
    EXPECT_FALSE(c.surface_m2 || c.worth || c.utility);
  }
}

TEST(RandomPlanner, TakesReachableViewsOfAllDirectionsAndNeverEnds) {
  const auto map = NearSideMapped(0.12);
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const auto decide = [&](uint64_t seed) {
    const auto planner = StandAtObject({.name = "random", .values = {}}, 1, seed);
    std::vector<core::Vec3> views;  // and their headings
    for (int i = 0; i < 40; ++i) {
      planner->OnSweep(kStandAtObject, 0);
      const PlanResult decision = planner->Plan(kStandAtObject, map, ground);
      EXPECT_EQ(decision.outcome, "view");
      const Vec2& p = decision.path_map.back();
      views.emplace_back(p.x(), p.y(), std::get<GoScan>(decision.decision).yaw_rad);
    }
    return views;
  };
  const std::vector<core::Vec3> views = decide(1);
  EXPECT_EQ(views, decide(1));
  EXPECT_NE(views, decide(2));
  int left = 0, ahead = 0, looks_left = 0, looks_ahead = 0;
  for (const core::Vec3& p : views) {
    EXPECT_EQ(ground.KindAt({p.x(), p.y(), 0.0}), mapping::GroundKind::kFree);
    left += p.x() < 0.0;
    ahead += p.y() > -3.0;
    looks_left += std::sin(p.z()) > 0.0;
    looks_ahead += std::cos(p.z()) > 0.0;
  }
  EXPECT_NEAR(left, 20, 12);
  EXPECT_NEAR(ahead, 20, 12);
  EXPECT_NEAR(looks_left, 20, 12);
  EXPECT_NEAR(looks_ahead, 20, 12);
}

TEST(RandomPlanner, ComputesNothingOfItsViews) {
  const auto planner = StandAtObject({.name = "random", .values = {}});
  planner->OnSweep(kStandAtObject, 500);
  const PlanResult plan = planner->Plan(kStandAtObject, NearSideMapped(), GroundAboutObject(Vec2(0.0, -3.0)));
  EXPECT_FALSE(plan.views_predicted || plan.utility_ratio || plan.blocked);
  const Candidate& view = plan.candidates.at(0);
  EXPECT_FALSE(view.gain || view.surface_m2 || view.worth || view.utility);
}

}  // namespace
}  // namespace atlas::planner
