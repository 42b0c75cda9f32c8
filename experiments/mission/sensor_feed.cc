#include "experiments/mission/sensor_feed.h"

#include <cassert>
#include <limits>
#include <utility>

#include "core/stopwatch.h"

namespace atlas::experiments {

SensorFeed::SensorFeed(const SensorFeedParams& params, const Listeners& listeners, core::TaskLanes* lanes)
    : params_(params), to_(listeners), lanes_(lanes) {
  assert(params.terrain_latency_s < params.refresh_period_s);
}

SensorFeed::~SensorFeed() = default;

/// States (50 Hz) are batched with the next spin or image: one task instead of ten.
core::TaskLanes::Ticket SensorFeed::Ingest(std::function<void(mapping::ElevationMap*)> event) {
  return lanes_->Post(kTerrainLane,
                      [terrain = to_.terrain, states = std::exchange(states_, {}), event = std::move(event)] {
                        for (const core::StateEvent& state : states) terrain->OnState(state);
                        event(terrain);
                      });
}

void SensorFeed::LaunchRefresh(double adopt_s) {
  refresh_ = Ingest([](mapping::ElevationMap* terrain) { terrain->Refresh(); });
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
  to_.terrain->Publish();
}

void SensorFeed::OnState(const core::StateEvent& event) {
  now_s_ = event.time_s;
  if (refreshing_ && event.time_s >= adopt_s_) AdoptTerrain();
  to_.localiser->OnState(event);
  to_.on_localised(to_.localiser->T_map_odom());
  states_.push_back(event);
}

void SensorFeed::OnSpin(const std::shared_ptr<const core::SpinEvent>& spin) {
  Ingest([spin](mapping::ElevationMap* terrain) { terrain->OnSpin(spin); });
  const core::AnchoredSpin placed = to_.localiser->Place(spin);
  to_.on_placed(placed);
  const bool wanted =
      mapping_ == Mapping::kEverything || (mapping_ == Mapping::kScanning && placed.spin->scanning);
  if (wanted) {
    lanes_->Post(kMapLane, [this, placed, poses = to_.localiser->poses()] { Map(placed, *poses); });
  }
  LaunchWhenDue();
}

void SensorFeed::OnDepth(const core::DepthEvent& event) {
  Ingest([event](mapping::ElevationMap* terrain) { terrain->OnDepth(event); });
  LaunchWhenDue();
}

void SensorFeed::Map(const core::AnchoredSpin& spin, const core::PoseSource& poses) {
  const core::Stopwatch integrating;
  to_.map->Integrate(spin, poses);
  mapped_.integration_s += integrating.seconds();
  const mapping::ReturnCloud cloud = to_.cloud->Add(*spin.spin, spin.T_map_odom(poses));
  mapped_.cloud_points += cloud.points.size();
  to_.on_cloud(cloud, spin.keyframe, poses);
}

SensorFeed::Mapped SensorFeed::DrainMap() {
  lanes_->Drain(kMapLane);
  to_.cloud->Begin();
  return std::exchange(mapped_, {});
}

}  // namespace atlas::experiments
