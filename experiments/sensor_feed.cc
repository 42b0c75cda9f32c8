#include "experiments/sensor_feed.h"

#include <cassert>
#include <limits>
#include <utility>

#include "experiments/stopwatch.h"
#include "mapping/undistort.h"

namespace atlas::experiments {

struct SensorFeed::Integration {
  mapping::Mapper* mapper;
  OnCloud on_cloud;
  double spacing_m;
  mapping::VoxelFilter filter{spacing_m};
  Mapped mapped;

  /// One cloud point a cell, of all revolutions between two drains.
  mapping::ReturnCloud Thin(const mapping::ReturnCloud& cloud) {
    mapping::ReturnCloud kept;
    for (size_t i = 0; i < cloud.points.size(); ++i) {
      if (filter.Insert(cloud.points[i])) kept.Add(cloud.points[i], cloud.origins[i]);
    }
    return kept;
  }

  void Take(const core::Sweep& sweep) {
    const Stopwatch integrating;
    const mapping::ReturnCloud cloud = Thin(mapper->Integrate(sweep));
    mapped.integration_s += integrating.seconds();
    mapped.cloud_points += cloud.points.size();
    on_cloud(cloud);
  }
};

SensorFeed::SensorFeed(const SensorFeedParams& params, planner::ElevationMap* terrain,
                       mapping::Mapper* mapper, OnCloud on_cloud, core::TaskLanes* lanes)
    : params_(params),
      terrain_(terrain),
      lanes_(lanes),
      integration_(new Integration{.mapper = mapper,
                                   .on_cloud = std::move(on_cloud),
                                   .spacing_m = params.cloud_spacing_m,
                                   .mapped = {}}) {
  assert(params.terrain_latency_s < params.refresh_period_s);
}

SensorFeed::~SensorFeed() = default;

/// States come ten times as often as anything else and wait for company.
core::TaskLanes::Ticket SensorFeed::Ingest(std::function<void(planner::ElevationMap*)> event) {
  return lanes_->Post(kTerrainLane,
                      [terrain = terrain_, states = std::exchange(states_, {}), event = std::move(event)] {
                        for (const core::StateEvent& state : states) terrain->OnState(state);
                        event(terrain);
                      });
}

void SensorFeed::LaunchRefresh(double adopt_s) {
  refresh_ = Ingest([](planner::ElevationMap* terrain) { terrain->Refresh(); });
  refreshing_ = true;
  adopt_s_ = adopt_s;
}

void SensorFeed::LaunchWhenDue() {
  if (refreshing_ || now_s_ - last_refresh_s_ < params_.refresh_period_s) return;
  last_refresh_s_ = now_s_;
  LaunchRefresh(now_s_ + params_.terrain_latency_s);
}

void SensorFeed::RefreshTerrain() {
  last_refresh_s_ = now_s_;
  LaunchRefresh(std::numeric_limits<double>::infinity());
}

void SensorFeed::AdoptTerrain() {
  if (!std::exchange(refreshing_, false)) return;
  lanes_->Wait(kTerrainLane, refresh_);
  terrain_->Publish();
}

void SensorFeed::OnState(const core::StateEvent& event) {
  now_s_ = event.time_s;
  if (refreshing_ && event.time_s >= adopt_s_) AdoptTerrain();
  T_map_odom_ = event.T_map_odom;
  states_.push_back(event);
}

void SensorFeed::OnSpin(const core::SpinEvent& event) {
  const auto kept = std::make_shared<const core::SpinEvent>(event);
  Ingest([kept](planner::ElevationMap* terrain) { terrain->OnSpin(*kept); });
  Integrate(kept);
  LaunchWhenDue();
}

void SensorFeed::OnDepth(const core::DepthEvent& event) {
  Ingest([event](planner::ElevationMap* terrain) { terrain->OnDepth(event); });
  LaunchWhenDue();
}

void SensorFeed::Integrate(std::shared_ptr<const core::SpinEvent> event) {
  if (event->scanning && !scanning_) T_map_odom_scan_ = T_map_odom_;
  scanning_ = event->scanning;
  if (mapping_ == Mapping::kNothing || (mapping_ == Mapping::kScanning && !scanning_)) return;
  const core::Pose T_map_odom = scanning_ ? T_map_odom_scan_ : T_map_odom_;
  lanes_->Post(kMapLane, [integration = integration_.get(), event = std::move(event), T_map_odom] {
    integration->Take({{*event}, T_map_odom});
  });
}

SensorFeed::Mapped SensorFeed::DrainMap() {
  lanes_->Drain(kMapLane);
  integration_->filter = mapping::VoxelFilter(params_.cloud_spacing_m);
  return std::exchange(integration_->mapped, {});
}

}  // namespace atlas::experiments
