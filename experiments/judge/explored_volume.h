// How much of the space to explore a map knows, against what could have been known.
//
// Cells of a grid over the object box. A cell is attainable when a noise-free sweep from some point of a
// lattice over the truly reachable set (reachable.h) sends a ray through its centre; it is explored once the
// map holds its centre free or occupied.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "core/lidar_model.h"
#include "experiments/judge/attainable.h"
#include "mapping/map_view.h"

namespace atlas::experiments {

struct VolumeOptions {
  double cell_m = 0.2;
  double lattice_m = 1.0;  ///< of the positions
  double max_range_m = 20.0;
  double sweep_roll_deg = 40.0;
  int headings = 8;
  ReachOptions reach;
  int threads = 1;
};

class ExploredVolume {
 public:
  /// Finds the attainable cells. `cast` as in attainable.h; results do not depend on `threads`.
  ExploredVolume(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                 const core::LidarModel& lidar, const VolumeOptions& options, const CastRays& cast,
                 const AttainableProgress& progress);

  /// Known attainable volume, cubic metres.
  double ExploredM3(const mapping::MapView& map) const;
  double attainable_m3() const { return cell_m3_ * static_cast<double>(centers_.size()); }

 private:
  double cell_m3_;
  std::vector<core::Vec3f> centers_;  ///< of attainable cells
};

/// For a run in a scene that the robot moves inside of; nothing elsewhere. Reports through options.progress.
std::unique_ptr<ExploredVolume> ExploredVolumeFor(const ExperimentConfig& config, const RunOptions& options,
                                                  const scenes::SceneSpec& scene,
                                                  const robots::RobotSpec& robot);

}  // namespace atlas::experiments
