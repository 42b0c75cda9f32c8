// Where the robot is in the map: what stands between its odometry and everything that remembers a place.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/keyframe.h"
#include "core/params.h"
#include "core/rng.h"
#include "core/se3.h"
#include "core/sensor_events.h"
#include "mapping/slam/lidar_odometry.h"
#include "mapping/slam/pose_graph.h"
#include "mapping/slam/slam_memory.h"
#include "mapping/slam/slam_params.h"

namespace atlas::mapping {

struct LocalisationParams {
  std::string name = "truth";  ///< see LocaliserCatalog()
  double sigma_m = 0.005;      ///< truth: of T_map_base, each axis (thesis 3.3: little drift at this scale)
  double sigma_deg = 0.05;
  double period_s = 1.0;  ///< truth: from fix to fix; 0: at every state
  SlamParams slam = {};
  LidarOdometryParams lidar_odometry = {};  ///< in front, where `lidar` is set
  bool lidar = false;                       ///< the odometry is only scan matching's prior
  void Visit(core::ParamVisitor& v);
};

/// How scan matching fared.
struct OdometryHealth {
  size_t revolutions = 0;
  size_t lost = 0;        ///< that met too little of the map: the prior alone
  size_t degenerate = 0;  ///< of which some direction kept the prior
};

/// Fed by one thread; what poses() returned may be read by any.
class Localiser {
 public:
  virtual ~Localiser() = default;
  /// Hears the odometry, in time order.
  virtual void OnState(const core::StateEvent& state) = 0;
  /// Anchors a revolution. Call once each, in time order, after the states up to its end.
  virtual core::AnchoredSpin Place(std::shared_ptr<const core::SpinEvent> spin) = 0;
  /// The odometry's frame in the map, as of the latest state.
  virtual core::Pose T_map_odom() const = 0;
  /// Holds every keyframe so far.
  virtual std::shared_ptr<const core::PoseSource> poses() const = 0;
  /// At the end, after which nothing is placed: waits for what is still being worked out, and takes it over.
  virtual void Settle() {}
  /// The pose graph behind the keyframes, without loops thought false; nothing where there is none.
  virtual std::optional<PoseGraph> InlierGraph() const { return std::nullopt; }
  /// Nothing without scan matching.
  virtual std::optional<OdometryHealth> odometry_health() const { return std::nullopt; }
  /// Whether it is known where this session lies in the map: where it goes on from an earlier one, not before
  /// the robot has recognised where it is. Until then poses of new keyframes tell how they lie to each other.
  virtual bool located() const { return true; }
  /// For a session that goes on from this one; call after Settle(). Null where nothing is remembered.
  virtual std::shared_ptr<const SlamMemory> Memory() const { return nullptr; }
};

/// What a localiser starts from.
struct LocaliserStart {
  core::Pose T_map_odom = core::Pose::Identity();   ///< exact
  core::Pose T_odom_base = core::Pose::Identity();  ///< where the robot stands
  /// The true T_map_base at the time of the latest state: for the localiser `truth` alone,
  /// empty for all others.
  std::function<core::Pose()> T_map_base_true;
  int threads = 1;  ///< more than one: loops are sought beside the caller; results do not depend on it
  /// Covariance of odometry's motion, `way_m` long, since this was last called, of xi in T Exp(xi); empty
  /// where odometry does not tell.
  std::function<core::Mat6(double way_m)> edge_covariance = {};
  /// `slam`: the session that this one goes on from, whose keyframes come before its own; null: there is
  /// none.
  std::shared_ptr<const SlamMemory> earlier = {};
};

struct LocaliserEntry {
  std::string name;
  std::string doc;
  std::unique_ptr<Localiser> (*build)(const LocalisationParams& params, const LocaliserStart& start,
                                      const core::Rng& rng);
};
const std::vector<LocaliserEntry>& LocaliserCatalog();

/// The one of params.name, without scan matching in front. @throws InputError for an unknown name.
std::unique_ptr<Localiser> MakeLocaliser(const LocalisationParams& params, const LocaliserStart& start,
                                         const core::Rng& rng);

}  // namespace atlas::mapping
