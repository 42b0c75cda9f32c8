// A LiDAR carried along a route through a static scene: recorded scans without a robot.
//
// No physics: the sensor is where the route says, at every ray's own time. Rays, noise, dropouts and void
// returns are those of the closed loop (sim/sensors/lidar.h).
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/lidar_model.h"
#include "core/sensor_events.h"
#include "scenes/route.h"
#include "scenes/scene_spec.h"

namespace atlas::experiments {

struct RecordOptions {
  std::string scene;            ///< a name, or path/scene.yaml
  std::filesystem::path route;  ///< empty: the scene's own
  std::string lidar = "os1_64";
  std::optional<int> scans;  ///< at most; without a rate spread evenly over the way (default: the route's)
  std::optional<double> rate_hz;    ///< recorded revolutions a second
  std::optional<double> speed_m_s;  ///< instead of the route's
  uint64_t seed = 1;
  bool noise = true;  ///< range noise and dropouts
  int threads = 1;    ///< results do not depend on it
};

class DatasetRecorder {
 public:
  /// @throws InputError for an unknown scene or LiDAR, a bad route file, a waypoint outside the scene or a
  /// route that passes through a surface.
  explicit DatasetRecorder(const RecordOptions& options);
  ~DatasetRecorder();

  const RecordOptions& options() const;
  const scenes::SceneSpec& scene() const;
  const core::LidarModel& lidar() const;
  const scenes::Route& route() const;

  /// T_map_lidar every 5 ms of the whole way.
  const core::PoseTrajectory& trajectory() const;
  double length_m() const;
  /// Start of each revolution that Next() gives, ascending.
  const std::vector<double>& stamps_s() const;

  /// The next revolution and the sensor's poses while it lasted (odometry without drift: odom is map).
  /// @returns false after the last.
  bool Next(core::SpinEvent* spin);
  /// 1 for each surface point that some of the revolutions could have met (truth_seen.h).
  std::vector<uint8_t> SeenPoints(std::span<const core::Vec3f> points,
                                  std::span<const core::Vec3f> normals) const;
  /// Starts again; the same revolutions follow.
  void Rewind();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atlas::experiments
