// Feeds sensor events to the elevation map and refreshes it at a bounded rate while the robot walks.
#pragma once

#include "planner/terrain/elevation_map.h"

namespace atlas::experiments {

class TerrainFeed : public core::SensorSink {
 public:
  TerrainFeed(planner::ElevationMap* terrain, double refresh_period_s)
      : terrain_(terrain), refresh_period_s_(refresh_period_s) {}

  void OnState(const core::StateEvent& event) override { terrain_->OnState(event); }
  void OnSpin(const core::SpinEvent& event) override {
    terrain_->OnSpin(event);
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
  planner::ElevationMap* terrain_;
  double refresh_period_s_;
  double last_refresh_s_ = 0.0;
};

}  // namespace atlas::experiments
