// Who listens to the sensors while the robot moves: the elevation map always, the mapper while it is asked
// to.
//
// Both work beside the simulation (core::TaskLanes). What the gait reads is the elevation map as it was
// `terrain_latency_s` of simulated time before, whatever the machine and the number of threads: a refresh is
// launched at a fixed rate and adopted that much later, and the simulation waits for one that is late.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "core/sensor_events.h"
#include "core/task_lanes.h"
#include "mapping/mapper.h"
#include "planner/terrain/elevation_map.h"

namespace atlas::experiments {

/// The terrain does not queue behind the map.
enum TaskLane : int { kTerrainLane, kMapLane, kTaskLanes };

struct SensorFeedParams {
  double refresh_period_s = 1.0;  ///< of the elevation map; longer than the latency
  double terrain_latency_s = 0.4;
  double cloud_spacing_m = 0.015;  ///< at most one cloud point a cell of this size between two drains
};

class SensorFeed : public core::SensorSink {
 public:
  /// What the mapper hears.
  enum class Mapping {
    kNothing,
    kScanning,    ///< the revolutions of a scanning action, all under the localisation of its start
    kEverything,  ///< walking too, under the localisation of each revolution's time
  };
  using OnCloud = std::function<void(const mapping::ReturnCloud& cloud_map)>;

  /// All outlive this, `lanes` ends before them. `on_cloud` is called from tasks of kMapLane.
  SensorFeed(const SensorFeedParams& params, planner::ElevationMap* terrain, mapping::Mapper* mapper,
             OnCloud on_cloud, core::TaskLanes* lanes);
  ~SensorFeed() override;

  void SetMapping(Mapping mapping) { mapping_ = mapping; }

  /// Starts a refresh that holds all events so far; it is adopted by AdoptTerrain(), not by time.
  void RefreshTerrain();
  /// Waits for the latest refresh and lets queries see it.
  void AdoptTerrain();

  struct Mapped {
    size_t cloud_points = 0;
    double integration_s = 0.0;  ///< wall-clock time of the mapper's work
  };
  /// Waits until the map holds every revolution so far. Tells what that was since the last call.
  Mapped DrainMap();

  void OnState(const core::StateEvent& event) override;
  void OnSpin(const core::SpinEvent& event) override;
  void OnDepth(const core::DepthEvent& event) override;

 private:
  struct Integration;

  core::TaskLanes::Ticket Ingest(std::function<void(planner::ElevationMap*)> event);
  void LaunchRefresh(double adopt_s);
  void LaunchWhenDue();
  void Integrate(std::shared_ptr<const core::SpinEvent> event);

  SensorFeedParams params_;
  planner::ElevationMap* terrain_;
  core::TaskLanes* lanes_;
  std::unique_ptr<Integration> integration_;  ///< touched by tasks of kMapLane, and when that lane is drained
  Mapping mapping_ = Mapping::kNothing;
  std::vector<core::StateEvent> states_;  ///< not handed on yet
  core::Pose T_map_odom_ = core::Pose::Identity();
  core::Pose T_map_odom_scan_ = core::Pose::Identity();  ///< of the scanning action that goes on
  bool scanning_ = false;
  double now_s_ = 0.0;  ///< of the latest state
  double last_refresh_s_ = 0.0;
  double adopt_s_ = 0.0;  ///< meaningful while a refresh is under way
  bool refreshing_ = false;
  core::TaskLanes::Ticket refresh_ = 0;
};

}  // namespace atlas::experiments
