// The simulated robot in its world: it walks under physics, sweeps its LiDAR, and emits sensor events.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/params.h"
#include "core/rng.h"
#include "core/sensor_events.h"
#include "core/terrain_view.h"
#include "robots/robot_spec.h"
#include "scenes/scene_spec.h"

namespace atlas::sim {

struct LocomotionParams {
  /// trot (physics) | kinematic (no physics, for cheap sweeps) | rail (kinematic, on its path by its true
  /// pose) | carried (a LiDAR alone, along a route of scenes/routes)
  std::string name = "trot";
  std::string route;                  ///< carried: its name; empty: the scene's
  std::string terrain = "perceived";  ///< perceived | truth
  double speed_mps = 0.5;             ///< along paths
  double sweep_roll_deg = 40.0;
  double sweep_period_s = 6.0;  ///< one roll to + , to - and back
  void Visit(core::ParamVisitor& v);
};

struct OdometryParams {
  std::string name = "legs";      ///< truth | legs | drift | lidar (scan matching; here its prior)
  double drift_xy_per_m = 0.003;  ///< legs: random walk, standard deviation a metre walked
  double drift_yaw_deg_per_m = 0.02;
  double drift_scale = 1.0;  ///< drift: times 2 cm and 0.1 degrees an axis every 2 m, 1 m after 100 m
  double drift_bias = 0.0;   ///< drift: mean error in one direction, as a share of those
  double prior_bias = 0.01;  ///< lidar: legs tell each way as longer by this share
  double prior_bias_deg_per_m = 0.1;  ///< lidar: and turn by so much
  double prior_xy_per_m = 0.02;       ///< lidar: random walk beside, standard deviation a metre walked
  double prior_yaw_deg_per_m = 0.2;
  double velocity_sigma_mps = 0.02;  ///< noise on the base velocity that the gait balances on
  double attitude_sigma_deg = 0.2;
  void Visit(core::ParamVisitor& v);
};

struct SensorParams {
  std::string lidar = "robot";  ///< the robot's own, or a LiDAR model's name
  double range_sigma_m = -1.0;  ///< of the range noise; below 0: the LiDAR model's own
  int walking_spin_stride = 2;  ///< while walking every n-th revolution is cast; all are while sweeping
  bool depth_camera = true;
  int depth_width = 212;
  int depth_height = 120;
  double depth_rate_hz = 2.5;
  double depth_max_m = 3.0;
  int threads = 1;  ///< set by the runner from --threads
  void Visit(core::ParamVisitor& v);
};

struct SimParams {
  LocomotionParams locomotion;
  OdometryParams odometry;
  SensorParams sensors;
};

enum class MotionStatus { kReached, kFell, kStuck, kStopped };

struct WalkResult {
  MotionStatus status = MotionStatus::kReached;
  double distance_m = 0.0;           ///< walked by the true base
  double odometry_distance_m = 0.0;  ///< the same as odometry tells it: what the robot knows
  double duration_s = 0.0;
};

/// Waypoints in the map frame; the last one's yaw is reached standing.
struct WalkPath {
  std::vector<core::Vec2> waypoints_map;
  double final_yaw_rad = 0.0;
};

/// Counts since the start, footholds aside only where physics runs; a collision is a base, hip or thigh
/// contact above 5 N (an episode, not a step).
struct SafetyCounts {
  bool measured = true;  ///< false without physics: nothing can fall or collide
  int falls = 0;
  int collisions = 0;
  int shank_brushes = 0;
  int footholds = 0;
  int footholds_off_solid = 0;     ///< planned where the true ground is absent, beyond an edge or a hole
  double worst_foot_drop_m = 0.0;  ///< greatest touch-down depth below its planned target
};

/// The whole mechanical state at one time, for video and logs.
struct Snapshot {
  double time_s = 0.0;
  std::vector<double> qpos;
};

class Simulator {
 public:
  virtual ~Simulator() = default;

  /// Events go to `sink` from now on; null for none. The sink outlives its use.
  virtual void SetSink(core::SensorSink* sink) = 0;
  /// Polled at least every 50 ms of simulated time; true makes Walk and RollSweep return kStopped.
  virtual void SetStop(std::function<bool()> should_stop) = 0;

  /// Where the odometry's frame lies in the map from now on, for whoever walks: the simulator does not know
  /// it. Until it is told: at the spawn pose, where the odometry begins.
  virtual void SetLocalisation(const core::Pose& T_map_odom) = 0;

  /// Stands still for `duration_s`, sensing.
  virtual MotionStatus Stand(double duration_s) = 0;
  /// Follows `path`. `terrain` (odometry frame) is what footholds are chosen on; null reads the true ground.
  virtual WalkResult Walk(const WalkPath& path, const core::TerrainView* terrain) = 0;
  /// The scanning action: rolls the base +roll to -roll and back while standing (thesis 3.6.1).
  virtual MotionStatus RollSweep() = 0;

  virtual double time_s() const = 0;
  /// The odometry's latest estimate; never the truth.
  virtual core::Pose T_odom_base() const = 0;

  virtual const SafetyCounts& safety() const = 0;
  virtual std::string render_backend() const = 0;  ///< "egl", "osmesa", "none", or "off": no depth camera
  /// Why the depth camera that was asked for does not work, one line; empty where it does.
  virtual std::string render_problem() const { return ""; }

  // Ground truth: for what judges a run (experiments/judge), for what films it (experiments/video) and for
  // the localiser `truth` only.
  virtual core::Pose TrueBasePose() const = 0;
  virtual Snapshot TrueState() const = 0;
  /// `observer` hears the state at `rate_hz` from now on, beside those added before.
  virtual void AddStateObserver(std::function<void(const Snapshot&)> observer, double rate_hz) = 0;
};

/// Builds the world and puts the robot on its spawn pose, standing. @throws InputError for bad input.
std::unique_ptr<Simulator> MakeSimulator(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                         const SimParams& params, const core::Rng& rng);

}  // namespace atlas::sim
