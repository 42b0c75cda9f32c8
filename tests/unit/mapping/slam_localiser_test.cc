// A robot that walks around a block in a hall, with odometry that turns: what closing the loop makes of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mapping/slam/localiser.h"

namespace atlas::tests {
namespace {

using namespace mapping;
using core::Box3;
using core::Pose;
using core::Vec3;

const Box3 kHall{Vec3(-8.0, -5.0, 0.0), Vec3(8.0, 5.0, 3.0)};
const Box3 kBlocks[] = {{Vec3(-5.0, -2.0, -1.0), Vec3(5.0, 2.0, 4.0)},
                        {Vec3(-8.0, 3.6, -1.0), Vec3(-7.0, 5.0, 4.0)},
                        {Vec3(6.5, -5.0, -1.0), Vec3(8.0, -4.2, 4.0)},
                        {Vec3(1.0, 4.3, -1.0), Vec3(2.5, 5.0, 4.0)}};

double RangeTo(const Vec3& origin, const Vec3& direction) {
  double range = kHall.Clip(origin, direction)->second;
  for (const Box3& block : kBlocks) {
    if (const auto hit = block.Clip(origin, direction)) range = std::min(range, hit->first);
  }
  return range;
}

/// A revolution of a LiDAR that stands at a true pose, which odometry takes for another one.
std::shared_ptr<const core::SpinEvent> SpinAt(const Pose& T_map_lidar, const Pose& T_odom_lidar,
                                              double time_s) {
  auto spin = std::make_shared<core::SpinEvent>();
  core::LidarScan& scan = spin->scan;
  scan.rows = 24;
  scan.columns = 360;
  scan.stamp_s = time_s;
  for (int row = 0; row < scan.rows; ++row) {
    for (int column = 0; column < scan.columns; ++column) {
      const double azimuth = core::Radians(-column), elevation = core::Radians(-40.0 + 3.3 * row);
      const Vec3 direction(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                           std::sin(elevation));
      scan.direction_lidar.push_back(direction.cast<float>());
      scan.range_m.push_back(
          static_cast<float>(RangeTo(T_map_lidar.translation(), T_map_lidar.linear() * direction)));
      scan.time_s.push_back(0.0f);
      scan.kind.push_back(core::ReturnKind::kHit);
    }
  }
  spin->T_odom_lidar.Add(time_s, T_odom_lidar);
  return spin;
}

/// The true way: around the block, along the middle of the aisles, once and a bit; heading along it.
Pose WayAt(double s_m) {
  const Vec3 corners[] = {{-6.5, -3.5, 0.8}, {6.5, -3.5, 0.8}, {6.5, 3.5, 0.8}, {-6.5, 3.5, 0.8}};
  double left = s_m;
  for (int k = 0;; ++k) {
    const Vec3 &from = corners[k % 4], &to = corners[(k + 1) % 4];
    const double length = (to - from).norm();
    if (left <= length) {
      const Vec3 along = (to - from) / length;
      return core::PoseFromXyzYaw(from + left * along, std::atan2(along.y(), along.x()));
    }
    left -= length;
  }
}

struct WalkOptions {
  int threads = 1;
  double begin_m = 0.0, end_m = 50.0;  ///< along the way
  double error = 1.0;                  ///< of odometry, in 0.35 degrees a metre and 1 % of the way
  std::shared_ptr<const SlamMemory> earlier = {};  ///< where there is one, the start is not known
};

struct Walk {
  explicit Walk(const LocalisationParams& params, const WalkOptions& options = {}) {
    Pose T_odom_base = Pose::Identity(), T_map_base = WayAt(options.begin_m);
    const Pose T_map_odom = options.earlier ? Pose::Identity() : T_map_base;
    localiser = MakeLocaliser(params,
                              {.T_map_odom = T_map_odom,
                               .T_odom_base = T_odom_base,
                               .T_map_base_true = {},
                               .threads = options.threads,
                               .edge_covariance = {},
                               .earlier = options.earlier},
                              core::Rng(1));
    first_keyframe = localiser->poses()->latest();
    for (double s = options.begin_m; s <= options.end_m; s += 0.25) {
      const Pose T_map_next = WayAt(s);
      Pose step = T_map_base.inverse() * T_map_next;
      step.translation() *= 1.0 + 0.01 * options.error;
      const double turned_deg = s > options.begin_m ? options.error * 0.35 * 0.25 : 0.0;
      step.linear() = step.linear() * core::RotationFromYawPitchRoll(core::Radians(turned_deg), 0.0, 0.0);
      T_odom_base = T_odom_base * step;
      T_map_base = T_map_next;
      core::StateEvent state;
      state.time_s = s;
      state.T_odom_base = T_odom_base;
      const uint64_t version = localiser->poses()->version();
      localiser->OnState(state);
      if (localiser->poses()->version() != version) corrected_s.push_back(s);
      believed.push_back(localiser->T_map_odom() * T_odom_base);
      const core::AnchoredSpin placed = localiser->Place(SpinAt(T_map_base, T_odom_base, s));
      EXPECT_LT((placed.T_map_odom(*localiser->poses()).matrix() - localiser->T_map_odom().matrix()).norm(),
                1e-9);
      if (!localiser->located()) located_m = s;
      if (first_keyframe + true_poses.size() <= placed.keyframe) {
        true_poses.push_back(T_map_base);
        T_odom_keyframe.push_back(T_map_odom * T_odom_base);
      }
    }
    localiser->Settle();
    final_error_m = ((localiser->T_map_odom() * T_odom_base).translation() - T_map_base.translation()).norm();
    odometry_error_m = ((T_map_odom * T_odom_base).translation() - T_map_base.translation()).norm();
  }
  /// Root mean square over keyframes, as they lie at the end.
  double KeyframeError() const {
    double squared = 0.0;
    for (size_t k = 0; k < true_poses.size(); ++k) {
      const auto keyframe = static_cast<core::KeyframeId>(first_keyframe + k);
      squared += (localiser->poses()->T_map_keyframe(keyframe).translation() - true_poses[k].translation())
                     .squaredNorm();
    }
    return std::sqrt(squared / static_cast<double>(true_poses.size()));
  }

  std::unique_ptr<Localiser> localiser;
  std::vector<Pose> true_poses, T_odom_keyframe, believed;
  size_t first_keyframe = 0;
  double located_m = 0.0;           ///< along the way, until when it was not known where it lies
  std::vector<double> corrected_s;  ///< when keyframes moved; a metre is a second
  double final_error_m = 0.0, odometry_error_m = 0.0;
};

LocalisationParams Slam() {
  LocalisationParams params;
  params.name = "slam";
  params.slam.odometry_sigma_m = 0.03;
  params.slam.odometry_sigma_deg = 1.0;
  return params;
}

TEST(SlamLocaliser, ClosesTheLoopAroundABlock) {
  const Walk walk(Slam());
  EXPECT_EQ(walk.true_poses.size(), 24u) << "every 2 m of 50, less what corners cut";
  ASSERT_GT(walk.odometry_error_m, 1.0);
  EXPECT_LT(walk.final_error_m, 0.2);
  EXPECT_LT(walk.KeyframeError(), 0.25);
  EXPECT_GT(walk.localiser->poses()->version(), 0u);
}

TEST(SlamLocaliser, IsTheSameWithAThreadOfItsOwn) {
  const Walk alone(Slam()), beside(Slam(), {.threads = 2});
  ASSERT_EQ(alone.believed.size(), beside.believed.size());
  for (size_t k = 0; k < alone.believed.size(); ++k)
    ASSERT_EQ(alone.believed[k].matrix(), beside.believed[k].matrix()) << k;
  ASSERT_EQ(alone.corrected_s, beside.corrected_s);
}

TEST(SlamLocaliser, LoopsTakeEffectAfterTheirLatency) {
  LocalisationParams params = Slam();
  params.slam.latency_s = 0.0;
  params.slam.full_latency_s = 1000.0;  // none before the end
  const Walk at_once(params);
  ASSERT_FALSE(at_once.corrected_s.empty());
  params.slam.latency_s = 1.25;
  const Walk later(params);
  ASSERT_FALSE(later.corrected_s.empty());
  EXPECT_DOUBLE_EQ(later.corrected_s.front(), at_once.corrected_s.front() + 1.0)
      << "in steps of 0.25 s, the first of which an immediate result needs too";
}

TEST(SlamLocaliser, WithoutLoopsIsOdometry) {
  LocalisationParams params = Slam();
  params.slam.loop_tries = 0;
  const Walk walk(params);
  EXPECT_NEAR(walk.final_error_m, walk.odometry_error_m, 1e-9);
  for (size_t k = 0; k < walk.true_poses.size(); ++k) {
    const Pose T_map_keyframe = walk.localiser->poses()->T_map_keyframe(static_cast<core::KeyframeId>(k));
    EXPECT_LT((T_map_keyframe.matrix() - walk.T_odom_keyframe[k].matrix()).norm(), 1e-9) << k;
  }
  EXPECT_EQ(walk.localiser->poses()->version(), 0u);
}

TEST(SlamLocaliser, ASecondSessionFromAnotherStartIsLocatedInTheFirst) {
  const Walk first(Slam(), {.error = 0.1});
  const auto memory = first.localiser->Memory();
  ASSERT_EQ(memory->graph.size(), first.true_poses.size());
  ASSERT_EQ(memory->nodes.size(), memory->graph.size());
  for (const int threads : {1, 2}) {
    const Walk second(Slam(),
                      {.threads = threads, .begin_m = 17.0, .end_m = 60.0, .error = 0.1, .earlier = memory});
    EXPECT_EQ(second.first_keyframe, memory->graph.size());
    EXPECT_TRUE(second.localiser->located());
    EXPECT_GE(second.located_m, 17.0) << "not before it saw anything";
    EXPECT_LT(second.located_m, 30.0);
    EXPECT_LT(second.KeyframeError(), 0.1);
    EXPECT_LT(second.final_error_m, 0.1);
    const auto poses = second.localiser->poses();
    EXPECT_LT(poses->RelativeSigmaM(2, poses->latest()).value(), 0.1) << "to a keyframe of the first";
  }
}

TEST(SlamLocaliser, ASecondSessionElsewhereIsNotLocated) {
  const Walk first(Slam(), {.end_m = 9.0, .error = 0.1});
  // Along the other aisle.
  const Walk second(Slam(),
                    {.begin_m = 21.0, .end_m = 30.0, .error = 0.1, .earlier = first.localiser->Memory()});
  EXPECT_FALSE(second.localiser->located());
}

TEST(SlamLocaliser, APoseSourceStaysAsItWasTaken) {
  LocalisationParams params = Slam();
  const auto localiser = MakeLocaliser(
      params,
      {.T_map_odom = WayAt(0.0), .T_odom_base = Pose::Identity(), .T_map_base_true = {}, .threads = 1},
      core::Rng(1));
  const auto poses = localiser->poses();
  EXPECT_EQ(poses->latest(), 0u);
  core::StateEvent state;
  state.T_odom_base = core::PoseFromXyzYaw({2.5, 0.0, 0.0}, 0.0);
  localiser->OnState(state);
  localiser->Place(SpinAt(WayAt(2.5), state.T_odom_base, 1.0));
  EXPECT_EQ(poses->latest(), 0u);
  EXPECT_EQ(localiser->poses()->latest(), 1u);
}

}  // namespace
}  // namespace atlas::tests
