// Who listens to the sensors while the robot moves: the localiser and the elevation map always, the mapper
// while it is asked to.
//
// The maps work beside the simulation (core::TaskLanes). What the gait reads is the elevation map as it was
// `terrain_latency_s` of simulated time before, whatever the machine and the number of threads: a refresh is
// launched at a fixed rate and adopted that much later, and the simulation waits for one that is late.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "core/sensor_events.h"
#include "core/task_lanes.h"
#include "mapping/cloud/scan_cloud.h"
#include "mapping/map.h"
#include "mapping/slam/localiser.h"
#include "mapping/terrain/elevation_map.h"

namespace atlas::experiments {

/// The terrain does not queue behind the map.
enum TaskLane : int { kTerrainLane, kMapLane, kTaskLanes };

struct SensorFeedParams {
  double refresh_period_s = 1.0;  ///< of the elevation map; longer than the latency
  double terrain_latency_s = 0.4;
};

class SensorFeed : public core::SensorSink {
 public:
  /// What the mapper hears.
  enum class Mapping {
    kNothing,
    kScanning,    ///< the revolutions of a scanning action
    kEverything,  ///< walking too
  };
  /// Who hears the sensors, and what comes of it. All outlive the feed.
  struct Listeners {
    mapping::Localiser* localiser;
    mapping::ElevationMap* terrain;
    mapping::Map* map;
    mapping::ScanCloud* cloud;  ///< of all revolutions between two drains; touched by tasks of kMapLane
    std::function<void(const core::Pose& T_map_odom)> on_localised;
    std::function<void(const core::AnchoredSpin&)> on_placed;
    /// From tasks of kMapLane: the returns of a revolution in the map frame, and what they move with.
    std::function<void(const mapping::ReturnCloud& cloud_map, core::KeyframeId, const core::PoseSource&)>
        on_cloud;
  };

  /// `lanes` ends before the listeners.
  SensorFeed(const SensorFeedParams& params, const Listeners& listeners, core::TaskLanes* lanes);
  ~SensorFeed() override;

  void SetMapping(Mapping mapping) { mapping_ = mapping; }

  /// Starts a refresh that holds all events so far; it is adopted by AdoptTerrain(), not by time.
  void RefreshTerrain();
  /// Waits for the latest refresh and lets queries see it.
  void AdoptTerrain();

  struct Mapped {
    size_t cloud_points = 0;
    double integration_s = 0.0;  ///< wall-clock time of the map alone
  };
  /// Waits until the map holds every revolution so far. Tells what that was since the last call.
  Mapped DrainMap();

  void OnState(const core::StateEvent& event) override;
  void OnSpin(const std::shared_ptr<const core::SpinEvent>& spin) override;
  void OnDepth(const core::DepthEvent& event) override;

 private:
  core::TaskLanes::Ticket Ingest(std::function<void(mapping::ElevationMap*)> event);
  void LaunchRefresh(double adopt_s);
  void LaunchWhenDue();
  void Map(const core::AnchoredSpin& spin, const core::PoseSource& poses);

  SensorFeedParams params_;
  Listeners to_;
  core::TaskLanes* lanes_;
  Mapping mapping_ = Mapping::kNothing;
  Mapped mapped_;                         ///< touched by tasks of kMapLane, and when that lane is drained
  std::vector<core::StateEvent> states_;  ///< not handed on yet
  double now_s_ = 0.0;                    ///< of the latest state
  double last_refresh_s_ = 0.0;
  double adopt_s_ = 0.0;  ///< meaningful while a refresh is under way
  bool refreshing_ = false;
  core::TaskLanes::Ticket refresh_ = 0;
};

}  // namespace atlas::experiments
