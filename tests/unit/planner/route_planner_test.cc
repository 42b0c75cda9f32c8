#include <gtest/gtest.h>

#include "core/errors.h"
#include "tests/support/flat_ground.h"
#include "tests/support/planner_stand.h"
#include "tests/support/voxel_world.h"

namespace atlas::planner {
namespace {

using core::Vec2;

tests::PlannerStand Route(const std::vector<std::string>& stops) {
  std::string list;
  for (const std::string& stop : stops) list += (list.empty() ? "[\"" : ", \"") + stop + "\"";
  return {{.name = "route", .values = {{"route", list + "]"}}}, {}};
}

std::string ErrorOf(const std::vector<std::string>& stops) {
  try {
    Route(stops);
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(RoutePlanner, BadStopsAreNamed) {
  EXPECT_EQ(ErrorOf({"0 0", "1 2 90"}), "");
  for (const char* bad : {"1", "1 x 90", "1 2 90 4", "", "1 2 nan", "inf 0 0"}) {
    EXPECT_NE(ErrorOf({"0 0 0", bad}).find("planner.route: '" + std::string(bad) + "'"), std::string::npos)
        << bad << ": " << ErrorOf({"0 0 0", bad});
  }
  EXPECT_NE(ErrorOf({"0 0 0"}).find("at least two"), std::string::npos);
  EXPECT_NE(ErrorOf({"0 0", "1 1"}).find("no stop is a view"), std::string::npos);
}

TEST(RoutePlanner, VisitsItsViewsOnceInOrderFromWhereverItBelievesToBe) {
  tests::PlannerStand planner = Route({"0 0 0", "2 0", "2 3 90", "-1 3 -180", "5 5"});
  const tests::FlatGround ground;
  const tests::VoxelWorld map(core::Box3{core::Vec3(-1, -1, -1), core::Vec3(1, 1, 1)}, 0.5);
  const core::Pose lost = core::PoseFromXyzYaw(core::Vec3(0.4, -0.3, 0.44), 1.0);
  const std::vector<std::vector<Vec2>> ways = {{{0, 0}, {2, 0}, {2, 3}}, {{2, 3}, {-1, 3}}};
  const double yaw_deg[] = {90.0, -180.0}, length_m[] = {5.0, 3.0};
  for (size_t k = 0; k < ways.size(); ++k) {
    const tests::PlanResult decision = planner.Plan(lost, map, ground);
    ASSERT_EQ(decision.outcome, "view");
    EXPECT_EQ(decision.path_map, ways[k]);
    EXPECT_NEAR(decision.path_length_m, length_m[k], 1e-12);
    EXPECT_NEAR(decision.candidates.at(0).yaw_rad, core::Radians(yaw_deg[k]), 1e-12);
  }
  EXPECT_EQ(planner.Plan(lost, map, ground).outcome, "route_done");
}

}  // namespace
}  // namespace atlas::planner
