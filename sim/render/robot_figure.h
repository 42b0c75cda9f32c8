// The robot as pictures show it: coloured bodies, posed from recorded states.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "robots/robot_spec.h"
#include "sim/render/colored_mesh.h"

namespace atlas::sim {

class RobotFigure {
 public:
  /// @throws InputError when the robot's model does not load.
  explicit RobotFigure(const robots::RobotSpec& robot);
  ~RobotFigure();
  RobotFigure(const RobotFigure&) = delete;
  RobotFigure& operator=(const RobotFigure&) = delete;

  /// All visible shapes, the LiDAR included, in their bodies' frames.
  const std::vector<ColoredMesh>& bodies() const;
  size_t qpos_size() const;
  /// T_map_body of each of bodies() for Snapshot::qpos. @pre qpos has qpos_size() entries.
  std::vector<core::Pose> PosesOf(std::span<const double> qpos);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atlas::sim
