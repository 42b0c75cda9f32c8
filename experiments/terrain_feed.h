// Who listens to the sensors while the robot moves: the elevation map always, the mapper's walk where asked.
#pragma once

#include <utility>

#include "core/sensor_events.h"
#include "planner/terrain/elevation_map.h"

namespace atlas::experiments {

/// Feeds sensor events to the elevation map, refreshes it at a bounded rate, and keeps the revolutions of a
/// walk.
class TerrainFeed : public core::SensorSink {
 public:
  TerrainFeed(planner::ElevationMap* terrain, double refresh_period_s)
      : terrain_(terrain), refresh_period_s_(refresh_period_s) {}

  /// From now on revolutions are kept, in the map frame by the localisation of their time.
  void StartWalk() { walking_ = true; }
  void EndWalk() { walking_ = false; }
  /// What was kept, as a sweep whose odometry frame is the map.
  core::Sweep TakeWalk() { return std::exchange(walk_, core::Sweep{}); }

  void OnState(const core::StateEvent& event) override {
    T_map_odom_ = event.T_map_odom;
    terrain_->OnState(event);
  }
  void OnSpin(const core::SpinEvent& event) override {
    terrain_->OnSpin(event);
    if (walking_) Keep(event);
    Refresh(event.scan.stamp_s);
  }
  void OnDepth(const core::DepthEvent& event) override {
    terrain_->OnDepth(event);
    Refresh(event.time_s);
  }

 private:
  void Refresh(double time_s) {
    if (time_s - last_refresh_s_ < refresh_period_s_) return;
    last_refresh_s_ = time_s;
    terrain_->Update();
  }
  void Keep(const core::SpinEvent& event) {
    core::SpinEvent kept;
    kept.scan = event.scan;
    for (const core::StampedPose& pose : event.T_odom_lidar.poses()) {
      kept.T_odom_lidar.Add(pose.time_s, T_map_odom_ * pose.T);
    }
    walk_.spins.push_back(std::move(kept));
  }

  planner::ElevationMap* terrain_;
  double refresh_period_s_;
  double last_refresh_s_ = 0.0;
  bool walking_ = false;
  core::Sweep walk_;
  core::Pose T_map_odom_ = core::Pose::Identity();
};

}  // namespace atlas::experiments
