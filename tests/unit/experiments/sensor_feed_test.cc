// Sensors to terrain and map: adopted after a fixed simulated latency, in batches, with any number of
// threads.
#include "experiments/sensor_feed.h"

#include <gtest/gtest.h>

#include <thread>

#include "planner/terrain/elevation_map.h"
#include "robots/robot_spec.h"

namespace atlas::experiments {
namespace {

/// Keeps what it was given; one cloud point a spin, all in one cell.
class CountingMapper : public mapping::Mapper {
 public:
  mapping::ReturnCloud Integrate(const core::Sweep& sweep) override {
    for (const core::SpinEvent& spin : sweep.spins) {
      stamps.push_back(spin.scan.stamp_s);
      shifts_x.push_back(sweep.T_map_odom.translation().x());
    }
    mapping::ReturnCloud cloud;
    cloud.Add(core::Vec3f(0.001f, 0.001f, 0.001f), core::Vec3f::Zero());
    return cloud;
  }
  const mapping::OccupancyView& view() const override { throw std::logic_error("no view here"); }
  size_t MapBytes() const override { return 0; }
  std::string Save(const std::filesystem::path&) const override { return {}; }

  std::vector<double> stamps, shifts_x;
};

core::StateEvent StateAt(double time_s, double shift_x = 0.0) {
  core::StateEvent event;
  event.time_s = time_s;
  event.T_odom_base = core::PoseFromXyzYaw({0.0, 0.0, 0.44}, 0.0);
  event.T_map_odom = core::PoseFromXyzYaw({shift_x, 0.0, 0.0}, 0.0);
  return event;
}

core::SpinEvent EmptySpin(double stamp_s, bool scanning) {
  core::SpinEvent event;
  event.scan.stamp_s = stamp_s;
  event.scanning = scanning;
  return event;
}

class SensorFeedTest : public ::testing::TestWithParam<bool> {
 protected:
  SensorFeedTest()
      : terrain(planner::TerrainParams{}, robots::RobotSpec{}),
        feed(
            {.refresh_period_s = 1.0, .terrain_latency_s = 0.4}, &terrain, &mapper,
            [this](const mapping::ReturnCloud& cloud) { heard += cloud.points.size(); }, &lanes),
        lanes(kTaskLanes, GetParam()) {
    terrain.InitialiseUnderRobot(core::PoseFromXyzYaw({0.0, 0.0, 0.44}, 0.0));
  }

  CountingMapper mapper;
  planner::ElevationMap terrain;
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
    if (tick % 10 == 0) feed.OnSpin(EmptySpin(now_s, false));
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

TEST_P(SensorFeedTest, TheMapperHearsWhatItIsAskedToInOrder) {
  using Mapping = SensorFeed::Mapping;
  feed.OnState(StateAt(0.0, 1.0));
  feed.OnSpin(EmptySpin(0.0, false));
  feed.SetMapping(Mapping::kScanning);
  feed.OnSpin(EmptySpin(0.1, false));
  feed.OnSpin(EmptySpin(0.2, true));
  feed.OnState(StateAt(0.25, 2.0));
  feed.OnSpin(EmptySpin(0.3, true));
  feed.SetMapping(Mapping::kEverything);
  feed.OnSpin(EmptySpin(0.4, false));
  feed.OnState(StateAt(0.45, 3.0));
  feed.OnSpin(EmptySpin(0.5, false));
  const SensorFeed::Mapped mapped = feed.DrainMap();
  EXPECT_EQ(mapper.stamps, (std::vector<double>{0.2, 0.3, 0.4, 0.5}));
  // A scanning action under one localisation, a walk under each revolution's.
  EXPECT_EQ(mapper.shifts_x, (std::vector<double>{1.0, 1.0, 2.0, 3.0}));
  EXPECT_EQ(mapped.cloud_points, 1u) << "one point a cell, whatever the batches";
  EXPECT_EQ(heard, 1u);
  feed.OnSpin(EmptySpin(0.6, false));
  EXPECT_EQ(feed.DrainMap().cloud_points, 1u) << "the next scan starts afresh";
}

INSTANTIATE_TEST_SUITE_P(InlineAndThreaded, SensorFeedTest, ::testing::Bool());

}  // namespace
}  // namespace atlas::experiments
