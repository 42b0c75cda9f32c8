// Trajectory errors of keyframes whose truth, belief and correction are set by hand.
#include "experiments/judge/place_errors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mapping/slam/fixed_poses.h"

namespace atlas::tests {
namespace {

using namespace experiments;
using core::Pose;
using core::Vec3;

Pose At(double x, double y = 0.0) {
  return core::PoseFromXyzYaw({x, y, 0.0}, 0.0);
}

TEST(PlaceErrors, AreOfOdometryOfWhatWasBelievedAndOfWhatIsBelievedNow) {
  PlaceErrors places;
  EXPECT_FALSE(places.Errors(mapping::FixedPoses({At(0)})));
  // The odometry's frame begins 5 m from the map's; the second keyframe is 3 m off by odometry.
  places.Observe({.base = {0, At(0)}, .T_map_base = At(5), .T_odom_base = At(0), .T_map_base_true = At(5)});
  places.Observe(
      {.base = {1, At(0)}, .T_map_base = At(7, 2), .T_odom_base = At(2, 3), .T_map_base_true = At(7)});
  places.Observe({.base = {1, At(9)}, .T_map_base = At(99), .T_odom_base = At(99), .T_map_base_true = At(7)});
  const auto errors = places.Errors(mapping::FixedPoses({At(5), At(7, 1)}));
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->keyframes, 2u);
  EXPECT_NEAR(errors->odometry_m, 3.0 / std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(errors->believed_m, 2.0 / std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(errors->corrected_m, 1.0 / std::sqrt(2.0), 1e-12);
}

}  // namespace
}  // namespace atlas::tests
