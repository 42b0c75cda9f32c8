// The scenes made to be recorded, measured with rays along their own routes.
#include <gtest/gtest.h>

#include "core/rng.h"
#include "experiments/record/recorder.h"
#include "mapping/terrain/elevation_map.h"
#include "robots/robot_spec.h"
#include "scenes/catalog.h"
#include "sim/sensors/raycaster.h"

namespace atlas::experiments {
namespace {

using core::Vec2;
using core::Vec3;

class Measured {
 public:
  explicit Measured(const std::string& name) : scene(scenes::LoadScene(name)), raycaster_(scene) {
    raycaster_.CommitPoses();
  }
  /// Range of a ray, or 1000.
  double Range(const Vec3& origin, const Vec3& direction) const {
    const core::Ray ray{origin.cast<float>(), direction.normalized().cast<float>()};
    sim::RayHit hit;
    raycaster_.CastStatic({&ray, 1}, 1000.0f, 1, {&hit, 1});
    return hit.range_m < 0.0f ? 1000.0 : hit.range_m;
  }
  double Clear(const Vec3& p, const Vec3& axis) const { return Range(p, axis) + Range(p, -axis); }

  scenes::SceneSpec scene;

 private:
  sim::Raycaster raycaster_;
};

RecordOptions OptionsFor(const std::string& scene) {
  RecordOptions options;
  options.scene = scene;
  return options;
}

TEST(RoomsSmall, DoorwaysAre90CentimetresWideAndTheCeiling270High) {
  const Measured rooms("rooms_small");
  const std::pair<Vec2, bool> doorways[] = {
      // the middle, and whether its wall runs along y
      {{-1.25, -15.8}, true}, {{1.25, -14.6}, true}, {{-6.8, -14.8}, true}, {{-6.0, -12.6}, false},
      {{-1.25, -9.4}, true},  {{1.25, -7.8}, true},  {{6.6, -7.4}, true},   {{9.05, -3.4}, false},
      {{1.25, -0.6}, true},   {{-1.25, -3.4}, true}, {{-3.8, -1.0}, false}, {{-9.6, 3.0}, false},
      {{-8.6, 5.4}, false},   {{-5.6, 8.4}, true},   {{-5.6, 16.0}, true},  {{5.6, 16.8}, true},
      {{7.8, 11.0}, false},   {{8.0, 5.4}, false}};
  for (const auto& [p, along_y] : doorways) {
    const Vec3 axis = along_y ? Vec3::UnitY() : Vec3::UnitX();
    for (double z : {0.1, 0.8, 1.9}) {
      EXPECT_NEAR(rooms.Clear(Vec3(p.x(), p.y(), z), axis), 0.9, 1e-4) << p.transpose() << " " << z;
    }
    EXPECT_NEAR(rooms.Clear(Vec3(p.x(), p.y(), 1.0), Vec3::UnitZ()), 2.1, 1e-4);
    const Vec3 beside = axis.cross(Vec3::UnitZ());
    for (double side : {-0.6, 0.6}) {
      EXPECT_NEAR(rooms.Clear(Vec3(p.x(), p.y(), 1.0) + side * beside, Vec3::UnitZ()), 2.7, 1e-4);
    }
  }
}

TEST(RoomsSmall, DoorwaysAreFreeToTheRobotOnGroundPerceivedOnTheWay) {
  RecordOptions options = OptionsFor("rooms_small");
  options.lidar = "os0_64";
  options.rate_hz = 1.0;
  DatasetRecorder recorder(options);
  const robots::RobotSpec robot = robots::LoadRobot("quadruped");
  mapping::ElevationMap terrain(mapping::TerrainParams(), robot);
  const core::Pose start = recorder.trajectory().poses().front().T;
  const double below_m = start.translation().z() - robot.stance_height_m;
  terrain.InitialiseUnderRobot(core::MakePose(start.linear(), start.translation() - Vec3(0, 0, below_m)));
  const std::pair<Vec2, double> doorways[] = {{{-1.25, -15.8}, 0.0}, {{-6.8, -14.8}, 0.0}};
  size_t next = 0;
  core::SpinEvent spin;
  while (next < std::size(doorways) && recorder.Next(&spin)) {
    core::StateEvent state;
    state.time_s = spin.scan.stamp_s;
    state.T_odom_base = spin.T_odom_lidar.At(state.time_s);
    state.T_odom_base.translation().z() -= below_m;
    terrain.OnState(state);
    terrain.OnSpin(std::make_shared<const core::SpinEvent>(spin));
    const auto& [middle, yaw_rad] = doorways[next];
    const Vec2 along(std::cos(yaw_rad), std::sin(yaw_rad));
    if ((state.T_odom_base.translation().head<2>() - middle).norm() > 1.2) continue;
    terrain.Update();
    for (double s = -0.9; s < 0.95; s += 0.1) {
      EXPECT_TRUE(terrain.FootprintFree(terrain.OnRobotsLevel(middle + s * along, 0.0), yaw_rad))
          << middle.transpose() << " " << s;
    }
    EXPECT_FALSE(terrain.FootprintFree(terrain.OnRobotsLevel(middle, 0.0),
                                       yaw_rad + 0.5 * core::kPi));  // not sideways
    ++next;
  }
  EXPECT_EQ(next, std::size(doorways));
}

TEST(RoomsSmall, IsClosedAllAround) {
  const Measured rooms("rooms_small");
  core::Rng rng(5);
  for (int k = 0; k < 5000; ++k) {
    const Vec3 direction(rng.Normal(), rng.Normal(), rng.Normal());
    ASSERT_LT(rooms.Range(Vec3(0, rng.Uniform(-18, 4), rng.Uniform(0.2, 2.5)), direction), 45.0);
  }
}

TEST(RoomsSmall, ItsRouteVisitsEveryRoom) {
  const DatasetRecorder recorder(OptionsFor("rooms_small"));
  const core::Box3 rooms[] = {
      {Vec3(-12, -19, 0), Vec3(-6.8, -12.6, 3)},   {Vec3(-6.8, -19, 0), Vec3(-1.25, -12.6, 3)},
      {Vec3(-12, -12.6, 0), Vec3(-1.25, -6.4, 3)}, {Vec3(-12, -6.4, 0), Vec3(-1.25, -1, 3)},
      {Vec3(-12, -1, 0), Vec3(-1.25, 3, 3)},       {Vec3(1.25, -19, 0), Vec3(12, -11, 3)},
      {Vec3(1.25, -11, 0), Vec3(6.6, -3.4, 3)},    {Vec3(6.6, -11, 0), Vec3(12, -3.4, 3)},
      {Vec3(1.25, -3.4, 0), Vec3(12, 3, 3)},       {Vec3(-12, 5.4, 0), Vec3(-5.6, 12, 3)},
      {Vec3(-12, 12, 0), Vec3(-5.6, 19, 3)},       {Vec3(-5.6, 5.4, 0), Vec3(5.6, 19, 3)},
      {Vec3(5.6, 5.4, 0), Vec3(12, 11, 3)},        {Vec3(5.6, 11, 0), Vec3(12, 19, 3)}};
  for (const core::Box3& room : rooms) {
    const bool visited = std::any_of(recorder.stamps_s().begin(), recorder.stamps_s().end(), [&](double t) {
      return room.Contains(recorder.trajectory().At(t).translation());
    });
    EXPECT_TRUE(visited) << room.Center().transpose();
  }
  EXPECT_EQ(recorder.stamps_s().size(), 97u);
}

TEST(Campus, PassageIsNarrowVaultedAndOpenFromTheQuadToThePark) {
  const Measured campus("campus");
  for (double y = -27.9; y < -15.1; y += 0.25) {
    const double width = campus.Clear(Vec3(10, y, 1.0), Vec3::UnitX());
    EXPECT_GT(width, 2.35) << y;
    EXPECT_LT(width, 2.65) << y;
    const double crown = campus.Clear(Vec3(10, y, 1.0), Vec3::UnitZ()),
                 flank = campus.Clear(Vec3(10.9, y, 1.0), Vec3::UnitZ());
    EXPECT_GT(crown, 3.2);
    EXPECT_LT(crown, 3.45);
    EXPECT_LT(flank, crown - 0.2);  // lower to the sides: a vault
  }
  EXPECT_GT(campus.Range(Vec3(10, -30, 1.2), Vec3::UnitY()), 20.0);
}

TEST(Campus, GroundOfTheParkRisesAndFallsByAMetreOrTwo) {
  const Measured campus("campus");
  double low = 1e9, high = -1e9;
  const DatasetRecorder recorder(OptionsFor("campus"));
  for (double t_s : recorder.stamps_s()) {
    const Vec3 p = recorder.trajectory().At(t_s).translation();
    const double ground = p.z() - campus.Range(p, -Vec3::UnitZ());
    EXPECT_NEAR(p.z() - ground, 0.9, 0.1) << p.transpose();
    low = std::min(low, ground);
    high = std::max(high, ground);
  }
  EXPECT_GT(high - low, 1.0);
  EXPECT_LT(high - low, 3.5);
  EXPECT_LT(recorder.scene().bounds.Size().x(), 140.0);
  EXPECT_GT(recorder.scene().bounds.Size().y(), 220.0);
}

TEST(Campus, CrownsLetPartOfTheBeamsThrough) {
  const scenes::SceneSpec scene = scenes::LoadScene("campus");
  scenes::SceneSpec leaves;
  for (const scenes::ScenePart& part : scene.parts) {
    if (part.name == "leaves") leaves.parts.push_back(part);
  }
  sim::Raycaster raycaster(leaves);
  raycaster.CommitPoses();
  // The four trees of the quad stand alone: beams at their crowns from 15 m.
  size_t met = 0, all = 0;
  for (double z = 3.5; z < 6.5; z += 0.05) {
    for (double y = -46.0; y < -42.5; y += 0.05) {
      const core::Ray ray{Vec3(0, y, z).cast<float>(), core::Vec3f::UnitX()};
      sim::RayHit hit;
      raycaster.CastStatic({&ray, 1}, 28.0f, 1, {&hit, 1});
      met += hit.range_m > 0.0f;
      ++all;
    }
  }
  EXPECT_GT(static_cast<double>(met), 0.4 * static_cast<double>(all));
  EXPECT_LT(static_cast<double>(met), 0.97 * static_cast<double>(all));
}

TEST(RecordedScenes, StayLightEnoughToLoadInASecond) {
  for (const char* name : {"campus", "campus_flight", "rooms_small"}) {
    size_t triangles = 0;
    for (const scenes::ScenePart& part : scenes::LoadScene(name).parts)
      triangles += part.mesh.triangles.size();
    EXPECT_LE(triangles, 300000u) << name;
  }
}

}  // namespace
}  // namespace atlas::experiments
