// The scene's collision shapes inside a compiled model: which are near, and where the ground is.
#pragma once

#include <optional>
#include <vector>

#include "core/geometry.h"

struct mjModel_;
struct mjData_;

namespace atlas::sim {

/// Holds no ownership; the model and the data outlive it.
class StaticGeometry {
 public:
  StaticGeometry(mjModel_* model, const mjData_* data);

  /// Lets only shapes whose box meets `near` collide. Exact as long as the robot stays within `near`.
  void Activate(const core::Box3& near);
  /// See World::GroundBelow.
  std::optional<double> Below(const core::Vec3& p) const;

 private:
  struct Shape {
    int geom;
    core::Box3 box;
  };
  double RayTo(const Shape& shape, const core::Vec3& p, double direction_z) const;
  const std::vector<int>* Cell(double x, double y) const;

  mjModel_* model_;
  const mjData_* data_;
  std::vector<Shape> shapes_;
  core::Vec2 origin_ = core::Vec2::Zero();  ///< of the index over x, y
  double cell_m_ = 1.0;
  int cols_ = 0, rows_ = 0;
  std::vector<std::vector<int>> cells_;
};

}  // namespace atlas::sim
