// Sensors to terrain and map: adopted after a fixed simulated latency, in batches, with any number of
// threads.
#include "experiments/mission/sensor_feed.h"

#include <gtest/gtest.h>

#include <thread>

#include "core/stopwatch.h"
#include "mapping/slam/fixed_poses.h"
#include "mapping/terrain/elevation_map.h"
#include "robots/robot_spec.h"

namespace atlas::experiments {
namespace {

/// Keeps what it was given.
class CountingMap : public mapping::Map {
 public:
  void Integrate(const core::AnchoredSpin& spin, const core::PoseSource& poses) override {
    stamps.push_back(spin.spin->scan.stamp_s);
    shifts_x.push_back(spin.T_map_odom(poses).translation().x());
  }
  std::shared_ptr<const mapping::MapView> Snapshot() const override { return nullptr; }
  size_t Bytes() const override { return 0; }
  std::string Save(const std::filesystem::path&) const override { return {}; }

  std::vector<double> stamps, shifts_x;
};

/// A keyframe a state: the odometry's frame lies as far along x as the state was late, in seconds.
class ShiftingLocaliser : public mapping::Localiser {
 public:
  void OnState(const core::StateEvent& state) override {
    keyframes_.push_back(core::PoseFromXyzYaw({state.time_s, 0.0, 0.0}, 0.0));
  }
  core::AnchoredSpin Place(std::shared_ptr<const core::SpinEvent> spin) override {
    return {.spin = std::move(spin), .keyframe = static_cast<core::KeyframeId>(keyframes_.size() - 1)};
  }
  core::Pose T_map_odom() const override { return keyframes_.back(); }
  std::shared_ptr<const core::PoseSource> poses() const override {
    return std::make_shared<mapping::FixedPoses>(keyframes_);
  }

 private:
  std::vector<core::Pose> keyframes_ = {core::Pose::Identity()};
};

core::StateEvent StateAt(double time_s) {
  core::StateEvent event;
  event.time_s = time_s;
  event.T_odom_base = core::PoseFromXyzYaw({0.0, 0.0, 0.44}, 0.0);
  return event;
}

/// One ray straight down, whose return and those beside it lie in one cell of the odometry's frame.
std::shared_ptr<const core::SpinEvent> SpinAt(double stamp_s, bool scanning) {
  core::SpinEvent event;
  core::LidarScan& scan = event.scan;
  scan.stamp_s = stamp_s;
  scan.rows = 1;
  scan.columns = 3;
  scan.direction_lidar.assign(3, -core::Vec3f::UnitZ());
  scan.range_m.assign(3, 1.0f);
  scan.time_s.assign(3, 0.0f);
  scan.kind.assign(3, core::ReturnKind::kHit);
  event.T_odom_lidar.Add(stamp_s, core::PoseFromXyzYaw({0.001, 0.001, 1.001}, 0.0));
  event.scanning = scanning;
  return std::make_shared<const core::SpinEvent>(event);
}

class SensorFeedTest : public ::testing::TestWithParam<bool> {
 protected:
  SensorFeedTest()
      : terrain(mapping::TerrainParams{}, robots::RobotSpec{}),
        cloud({core::Vec3(-9.0, -9.0, -9.0), core::Vec3(9.0, 9.0, 9.0)}, 20.0, 0.05),
        feed({.refresh_period_s = 1.0, .terrain_latency_s = 0.4},
             {.localiser = &localiser,
              .terrain = &terrain,
              .map = &map,
              .cloud = &cloud,
              .on_localised = [this](const core::Pose& T) { told_x.push_back(T.translation().x()); },
              .on_placed = [](const core::AnchoredSpin&) {},
              .on_cloud = [this](const mapping::ReturnCloud& returns, core::KeyframeId,
                                 const core::PoseSource&) { heard += returns.points.size(); }},
             &lanes),
        lanes(kTaskLanes, GetParam()) {
    terrain.InitialiseUnderRobot(core::PoseFromXyzYaw({0.0, 0.0, 0.44}, 0.0));
  }

  ShiftingLocaliser localiser;
  CountingMap map;
  mapping::ElevationMap terrain;
  mapping::ScanCloud cloud;
  std::vector<double> told_x;
  size_t heard = 0;
  SensorFeed feed;
  core::TaskLanes lanes;
};

TEST_P(SensorFeedTest, TerrainIsAdoptedAFixedSimulatedTimeAfterItsRefresh) {
  const auto known = [this] { return terrain.At(0.0, 0.0).known; };
  double adopted_s = -1.0;
  for (int tick = 0; tick <= 100 && adopted_s < 0.0; ++tick) {
    const double now_s = 0.02 * tick;
    feed.OnState(StateAt(now_s));
    if (known()) adopted_s = now_s;
    // A late refresh would show here, an early one too: whatever the thread did in between does not matter.
    if (tick == 55) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (tick % 10 == 0) feed.OnSpin(SpinAt(now_s, false));
  }
  EXPECT_NEAR(adopted_s, 1.4, 1e-9);
}

TEST_P(SensorFeedTest, ARequestedRefreshIsAdoptedOnRequestOnly) {
  feed.OnState(StateAt(0.02));
  feed.RefreshTerrain();
  for (double now_s = 0.04; now_s < 0.9; now_s += 0.02) feed.OnState(StateAt(now_s));
  EXPECT_FALSE(terrain.At(0.0, 0.0).known);
  feed.AdoptTerrain();
  EXPECT_TRUE(terrain.At(0.0, 0.0).known);
  feed.AdoptTerrain();  // nothing new: what is up stays up
  EXPECT_TRUE(terrain.At(0.0, 0.0).known);
}

TEST_P(SensorFeedTest, TheMapperHearsWhatItIsAskedToInOrderWhereItWasPlaced) {
  using Mapping = SensorFeed::Mapping;
  feed.OnState(StateAt(1.0));
  feed.OnSpin(SpinAt(1.0, false));
  feed.SetMapping(Mapping::kScanning);
  feed.OnSpin(SpinAt(1.1, false));
  feed.OnSpin(SpinAt(1.2, true));
  feed.OnState(StateAt(2.0));
  feed.OnSpin(SpinAt(2.1, true));
  feed.SetMapping(Mapping::kEverything);
  feed.OnSpin(SpinAt(2.2, false));
  const SensorFeed::Mapped mapped = feed.DrainMap();
  EXPECT_EQ(map.stamps, (std::vector<double>{1.2, 2.1, 2.2}));
  EXPECT_EQ(map.shifts_x, (std::vector<double>{1.0, 2.0, 2.0}));
  EXPECT_EQ(mapped.cloud_points, 2u) << "one point a cell, whatever the batches";
  EXPECT_EQ(heard, 2u);
  feed.OnSpin(SpinAt(2.3, false));
  EXPECT_EQ(feed.DrainMap().cloud_points, 1u) << "the next scan starts afresh";
}

TEST_P(SensorFeedTest, WhoeverWalksIsToldAtEveryStateWhereTheOdometryLies) {
  for (const double time_s : {1.0, 1.5, 3.0}) feed.OnState(StateAt(time_s));
  EXPECT_EQ(told_x, (std::vector<double>{1.0, 1.5, 3.0}));
}

/// The map keeps a number of it; the cloud takes a million returns.
TEST_P(SensorFeedTest, TheTimeOfIntegrationIsThatOfTheMapAlone) {
  core::SpinEvent event = *SpinAt(1.0, true);
  const size_t count = 1000000;
  event.scan.columns = static_cast<int>(count);
  event.scan.direction_lidar.assign(count, -core::Vec3f::UnitZ());
  event.scan.range_m.assign(count, 1.0f);
  event.scan.time_s.assign(count, 0.0f);
  event.scan.kind.assign(count, core::ReturnKind::kHit);
  const auto spin = std::make_shared<const core::SpinEvent>(event);
  const core::Stopwatch adding;
  mapping::ScanCloud(core::Box3{core::Vec3(-9.0, -9.0, -9.0), core::Vec3(9.0, 9.0, 9.0)}, 20.0, 0.05)
      .Add(event, core::Pose::Identity());
  const double cloud_s = adding.seconds();
  feed.OnState(StateAt(1.0));
  feed.SetMapping(SensorFeed::Mapping::kScanning);
  feed.OnSpin(spin);
  EXPECT_LT(feed.DrainMap().integration_s, 0.2 * cloud_s);
}

INSTANTIATE_TEST_SUITE_P(InlineAndThreaded, SensorFeedTest, ::testing::Bool());

}  // namespace
}  // namespace atlas::experiments
