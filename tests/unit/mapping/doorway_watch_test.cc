// Doorways on the way of a sensor, in clouds of walls made by hand.
#include "mapping/atlas/doorway_watch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "mapping/atlas/atlas.h"
#include "tests/support/placed_spins.h"

namespace atlas::tests {
namespace {

using namespace mapping;
using core::Pose;
using core::Vec2;
using core::Vec3;
using core::Vec3f;

constexpr double kSensorM = 0.75, kWidestM = 2.0;

/// Returns of an upright wall from a to b.
void AddWall(const Vec2& a, const Vec2& b, double low_m, double high_m, std::vector<Vec3f>* cloud) {
  const int along = static_cast<int>((b - a).norm() / 0.05);
  for (int i = 0; i <= along; ++i) {
    const Vec2 p = a + (b - a) * i / std::max(1, along);
    for (double z = low_m; z <= high_m; z += 0.1) cloud->push_back(Vec3(p.x(), p.y(), z).cast<float>());
  }
}

/// Two rooms of 6 x 6 m on either side of a wall along x = 0, 0.12 m thick, with an opening about y = 0.
std::vector<Vec3f> TwoRooms(double opening_m) {
  std::vector<Vec3f> cloud;
  for (const double side : {-1.0, 1.0}) {
    AddWall({6 * side, -3}, {6 * side, 3}, 0, 2.5, &cloud);
    AddWall({-6, 3 * side}, {6, 3 * side}, 0, 2.5, &cloud);
    for (const double x : {-0.06, 0.06})
      AddWall({x, side * 0.5 * opening_m}, {x, side * 3.0}, 0, 2.5, &cloud);
  }
  AddWall({0, -0.5 * opening_m}, {0, 0.5 * opening_m}, 2.1, 2.5, &cloud);  // the lintel
  return cloud;
}

/// Where on a way through corners, seen in steps of `step_m`, doorways are passed.
std::vector<Vec2> Passed(const std::vector<Vec3f>& cloud, const std::vector<Vec2>& corners,
                         double step_m = 0.2) {
  DoorwayWatch watch(kWidestM);
  std::vector<Vec2> passed;
  watch.See(cloud, Vec3(corners[0].x(), corners[0].y(), kSensorM));
  for (size_t i = 0; i + 1 < corners.size(); ++i) {
    const Vec2 leg = corners[i + 1] - corners[i];
    const int steps = static_cast<int>(leg.norm() / step_m);
    for (int k = 0; k <= steps; ++k) {
      const Vec2 p = corners[i] + leg * k / steps;
      if (watch.Move({p.x(), p.y(), kSensorM})) passed.push_back(p);
    }
  }
  return passed;
}

TEST(DoorwayWatch, ADoorwayIsPassedOnceBehindItsWall) {
  for (const double opening : {0.9, 1.2, 1.8}) {
    for (const double aside : {0.0, 0.5, -1.0}) {  // straight and askew
      const auto passed = Passed(TwoRooms(opening), {{-3, aside}, {0, 0}, {3, -aside}});
      ASSERT_EQ(passed.size(), 1u) << opening << " " << aside;
      EXPECT_GT(passed[0].x(), -0.07);
      EXPECT_LT(passed[0].x(), 0.4);
    }
  }
}

TEST(DoorwayWatch, ThereAndBackArePassedTwice) {
  const auto passed = Passed(TwoRooms(0.9), {{-3, 0}, {1, 0}, {-3, 0}});
  ASSERT_EQ(passed.size(), 2u);
  EXPECT_GT(passed[1].x(), -0.4);
  EXPECT_LT(passed[1].x(), 0.07);
}

TEST(DoorwayWatch, WhoTurnsBeforeTheWallPassesNothing) {
  EXPECT_TRUE(Passed(TwoRooms(0.9), {{-3, 0}, {-0.15, 0}, {-3, 0}}).empty());
}

TEST(DoorwayWatch, AWideOpeningIsNone) {
  EXPECT_TRUE(Passed(TwoRooms(2.6), {{-3, 0}, {3, 0}}).empty());
}

TEST(DoorwayWatch, TablesAndLintelsAreNoUprights) {
  std::vector<Vec3f> cloud = TwoRooms(5.0);
  for (const double side : {-1.0, 1.0}) AddWall({2, 0.4 * side}, {2.6, 0.4 * side}, 0, 0.5, &cloud);
  AddWall({-2, -3}, {-2, 3}, 2.0, 2.5, &cloud);
  EXPECT_TRUE(Passed(cloud, {{-4, 0}, {4, 0}}).empty());
}

TEST(DoorwayWatch, AlongANarrowCorridorThereIsNone) {
  std::vector<Vec3f> cloud;
  for (const double side : {-1.0, 1.0}) AddWall({-10, 0.8 * side}, {10, 0.8 * side}, 0, 2.5, &cloud);
  EXPECT_TRUE(Passed(cloud, {{-6, 0}, {6, 0}}).empty());
}

TEST(DoorwayWatch, FurnitureBesideADoorwayIsNoOther) {
  std::vector<Vec3f> cloud = TwoRooms(0.9);
  for (const double side : {-1.0, 1.0}) AddWall({1.2, 0.7 * side}, {1.5, 0.7 * side}, 0, 2.0, &cloud);
  EXPECT_EQ(Passed(cloud, {{-3, 0}, {3, 0}}).size(), 1u);
}

TEST(DoorwayWatch, ZeroSwitchesItOff) {
  DoorwayWatch watch(0.0);
  watch.See(TwoRooms(0.9), {-3, 0, kSensorM});
  for (double x = -3; x < 3; x += 0.2) EXPECT_FALSE(watch.Move({x, 0, kSensorM}));
}

/// Two rooms of 6 x 6 x 2.5 m with a doorway of 0.9 m between them, as a robot sees them on its way.
class TwoRoomsSeen {
 public:
  TwoRoomsSeen() {
    const auto add = [&](double x0, double y0, double z0, double x1, double y1, double z1) {
      boxes_.push_back({Vec3(x0, y0, z0), Vec3(x1, y1, z1)});
    };
    for (const double side : {-1.0, 1.0}) {
      add(6 * side - 0.1, -3, 0, 6 * side + 0.1, 3, 2.5);
      add(-6, 3 * side - 0.1, 0, 6, 3 * side + 0.1, 2.5);
      add(-0.06, side > 0 ? 0.45 : -3, 0, 0.06, side > 0 ? 3 : -0.45, 2.5);
    }
    add(-0.06, -0.45, 2.1, 0.06, 0.45, 2.5);
    add(-6, -3, -0.1, 6, 3, 0);
    add(-6, -3, 2.5, 6, 3, 2.6);
  }

  core::SpinEvent SpinAt(double x) const {
    core::SpinEvent spin;
    spin.scan.rows = 40;
    spin.scan.columns = 240;
    const Vec3 origin(x, 0.05, kSensorM);
    spin.T_odom_lidar.Add(0.0, core::PoseFromXyzYaw(origin, 0.0));
    spin.T_odom_lidar.Add(0.1, core::PoseFromXyzYaw(origin, 0.0));
    for (int row = 0; row < spin.scan.rows; ++row) {
      for (int column = 0; column < spin.scan.columns; ++column) {
        const double azimuth = -2.0 * core::kPi * column / spin.scan.columns,
                     elevation = core::Radians(-40 + 2 * row);
        const Vec3 direction(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                             std::sin(elevation));
        double range = 20.0;
        for (const core::Box3& box : boxes_) {
          const auto met = box.Clip(origin, direction);
          if (met && met->first > 0.0) range = std::min(range, met->first);
        }
        spin.scan.direction_lidar.push_back(direction.cast<float>());
        spin.scan.time_s.push_back(0.0f);
        spin.scan.range_m.push_back(static_cast<float>(range));
        spin.scan.kind.push_back(core::ReturnKind::kHit);
      }
    }
    return spin;
  }

  /// The keyframes of each submap, after a way along x through the places given, a keyframe every 2 m.
  std::vector<std::vector<core::KeyframeId>> SubmapsOf(const AtlasParams& params,
                                                       const std::vector<double>& places) const {
    Atlas atlas(params, AtlasSetup{.resolution_m = 0.1, .integrator = {}, .map = {}});
    std::vector<Pose> keyframes;
    double travelled_m = 2.0;
    for (size_t i = 0; i < places.size(); ++i) {
      if (i > 0) travelled_m += std::abs(places[i] - places[i - 1]);
      const core::SpinEvent spin = SpinAt(places[i]);
      if (travelled_m >= 2.0) {
        keyframes.push_back(spin.T_odom_lidar.poses().front().T);
        travelled_m = 0.0;
      }
      atlas.Integrate({.spin = Shared(spin),
                       .keyframe = static_cast<core::KeyframeId>(keyframes.size() - 1),
                       .T_keyframe_odom = keyframes.back().inverse()},
                      FixedPoses(keyframes, 0.01));
    }
    std::vector<std::vector<core::KeyframeId>> submaps;
    for (const auto& submap : atlas.submaps()) {
      submaps.emplace_back();
      for (const HeldKeyframe& held : submap->keyframes) submaps.back().push_back(held.sensor.keyframe);
    }
    return submaps;
  }

 private:
  std::vector<core::Box3> boxes_;
};

/// From x = -4 to 4 and back, twice.
std::vector<double> TwiceThereAndBack() {
  std::vector<double> places;
  for (int i = 0; i <= 64; ++i) places.push_back(4.0 - 0.5 * std::abs(16 - i % 32));
  return places;
}

TEST(AtlasDoorways, EachRoomHasASubmapHoweverOftenItIsEntered) {
  AtlasParams params;
  params.cloud_overlap = 0.3;  // which alone divides nothing here
  const std::vector<double> places = TwiceThereAndBack();
  const TwoRoomsSeen rooms;
  const auto submaps = rooms.SubmapsOf(params, places);
  ASSERT_EQ(submaps.size(), 2u);
  // A keyframe every fourth place, the first at x = -4; x = 0 is in the doorway.
  size_t held = 0;
  for (size_t s = 0; s < 2; ++s) {
    for (const core::KeyframeId keyframe : submaps[s]) {
      ++held;
      const double x = places[4 * keyframe];
      if (x == 0.0) continue;
      EXPECT_EQ(x > 0.0, s == 1) << keyframe << " at " << x;
    }
  }
  EXPECT_EQ(held, 17u);
  params.doorway_m = 0.0;
  EXPECT_EQ(rooms.SubmapsOf(params, places).size(), 1u);
}

TEST(AtlasDoorways, WhatIsNotTakenUpAgainBeginsAnew) {
  AtlasParams params;
  params.cloud_overlap = 0.3;
  params.fusion_overlap = 0.0;
  const std::vector<double> places = TwiceThereAndBack();
  const TwoRoomsSeen rooms;
  EXPECT_EQ(rooms.SubmapsOf(params, places).size(), 2u);
  params.reentry_overlap = 1.0;
  EXPECT_GT(rooms.SubmapsOf(params, places).size(), 2u);
}

}  // namespace
}  // namespace atlas::tests
