// Robot-centric elevation map from LiDAR spins and depth images, and the traversability that follows from it.
//
// Frame: odometry (z up), in which nothing jumps; PosedGround shows it in the map. The window moves with the
// robot; a cell keeps up to four layers of returns (mean, lowest, highest, support) and counts the rays that
// crossed the ground's height without meeting it, so that a grating is not read as the floor below, an
// overhang is not read as ground, and a hole is known as one. Floors above one another are levels of their
// own (ground_wave.h): returns of another floor are kept while it is at most 4 m below or 2.5 m above the
// robot, and stay when the robot goes on to it or comes back.
//
// Events and Refresh() are taken from one thread at a time; queries read what Publish() last put up, which
// Refresh() does not touch, so that they may go on beside it on any number of threads.
#pragma once

#include <memory>
#include <vector>

#include "core/mesh.h"
#include "core/params.h"
#include "core/robot_extent.h"
#include "core/sensor_events.h"
#include "core/terrain_view.h"
#include "mapping/terrain/traversable_ground.h"

namespace atlas::mapping {

struct TerrainParams {
  double cell_m = 0.04;
  double window_m = 12.0;         ///< side of the square window that planning may use
  double max_fill_m = 0.30;       ///< holes wider than this stay holes
  double critical_step_m = 0.12;  ///< higher steps are not traversable
  double critical_slope_deg = 22.0;
  double critical_roughness_m = 0.06;
  double negative_obstacle_m = 0.25;  ///< a drop deeper than this is an edge
  double edge_clearance_m = 0.10;     ///< of the footprint's rim from an edge or a hole
  double min_traversability = 0.25;
  double initial_ground_radius_m = 0.86;  ///< assumed solid about the robot at the start, until seen
  void Visit(core::ParamVisitor& v);
};

class ElevationMap : public core::SensorSink, public core::TerrainView, public TraversableGround {
 public:
  ElevationMap(const TerrainParams& params, const core::RobotExtent& robot);
  ~ElevationMap() override;

  /// The robot stands at `T_odom_base` on solid ground: the blind footprint starts as that ground.
  void InitialiseUnderRobot(const core::Pose& T_odom_base);

  void OnState(const core::StateEvent& event) override;
  void OnSpin(const std::shared_ptr<const core::SpinEvent>& spin) override;
  void OnDepth(const core::DepthEvent& event) override;

  /// Recomputes heights filled, slope, step, roughness, holes and traversability from the events so far.
  void Refresh();
  /// Lets queries see the last refresh; no effect without a new one. Call while neither Refresh() nor a query
  /// runs.
  void Publish();
  /// Both: call before querying after new events.
  void Update();

  /// Of the level that the robot stands on.
  Ground At(double x_odom, double y_odom) const override;

  using Surface = TraversableGround::Surface;
  Levels LevelsAt(const core::Vec2& p_odom) const override;
  double Traversability(const core::Vec3& p_odom) const override;
  GroundKind KindAt(const core::Vec3& p_odom) const override;
  bool FootprintFree(const core::Vec3& p_odom, double yaw_rad) const override;
  bool CircleFree(const core::Vec3& p_odom) const override;
  Surface SurfaceAt(const core::Vec3& p_odom) const override;
  core::Box3 Window() const override;

  /// For pictures and logs: the robot's level, a row-major grid over Window(), row = y, height NaN where
  /// unknown.
  struct Grid {
    int rows = 0, cols = 0;
    double cell_m = 0.0;
    core::Vec2 origin = core::Vec2::Zero();
    std::vector<float> height_m, traversability;
    std::vector<GroundKind> kind;
  };
  Grid Export() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atlas::mapping
