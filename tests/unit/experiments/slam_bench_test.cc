#include <gtest/gtest.h>

#include "experiments/bench/odometry_bench.h"
#include "experiments/bench/places_bench.h"

namespace atlas::tests {
namespace {

using core::Pose;
using core::Vec3;
using experiments::DriftOver;
using experiments::LoopOffer;
using experiments::PrecisionRecall;
using experiments::PrecisionRecallOf;

TEST(SlamBench, DriftIsTheErrorOfWindowsOverTheirLength) {
  std::vector<Pose> truth, longer, turned;
  for (int i = 0; i <= 300; ++i) {
    truth.push_back(core::PoseFromXyzYaw(Vec3(0.1 * i, 0.0, 0.0), 0.0));
    longer.push_back(core::PoseFromXyzYaw(Vec3(0.102 * i, 5.0, 0.0), 0.0));
    turned.push_back(core::PoseFromXyzYaw(Vec3(0.1 * i, 0.0, 0.0), core::Radians(0.01 * i)));
  }
  const auto drift = DriftOver(10.0, truth, longer, 10);
  EXPECT_NEAR(drift.percent, 2.0, 0.03);  // a window ends with the first pose beyond its length
  EXPECT_NEAR(drift.deg_per_m, 0.0, 1e-6);
  EXPECT_NEAR(static_cast<double>(drift.windows), 20.0, 1.0);
  EXPECT_NEAR(DriftOver(10.0, truth, turned, 10).deg_per_m, 0.1, 0.002);
  EXPECT_EQ(DriftOver(100.0, truth, longer, 10).windows, 0u);
}

TEST(SlamBench, PrecisionAndRecallFollowTheDistance) {
  const std::vector<LoopOffer> offers = {{0.3, false}, {0.1, true}, {0.2, true}, {2.0, false}, {0.4, true}};
  const std::vector<PrecisionRecall> curve = PrecisionRecallOf(offers, 5);
  ASSERT_EQ(curve.size(), 4u);
  EXPECT_DOUBLE_EQ(curve[1].precision, 1.0);
  EXPECT_DOUBLE_EQ(curve[1].recall, 0.4);
  EXPECT_DOUBLE_EQ(curve[2].precision, 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(curve[3].precision, 0.75);
  EXPECT_DOUBLE_EQ(curve[3].recall, 0.6);
  EXPECT_TRUE(PrecisionRecallOf({{2.0, false}}, 3).empty());
}

}  // namespace
}  // namespace atlas::tests
