// Gains of many views from one ray trace: the headings of a node share its rays, and all gains share each
// trace.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "mapping/map_view.h"
#include "planner/gain/gain.h"
#include "planner/gain/ray_directions.h"
#include "planner/gain/sweep_view.h"

namespace atlas::planner {

/// Where a ray ends, for the log of gains.
enum class EndClass : uint8_t { kVoid, kGround, kObject };
constexpr size_t kEndClasses = 3;

/// What one view (a heading of a node) is worth.
struct ViewGain {
  std::vector<double> gain;                     ///< one a gain asked for
  std::array<double, kEndClasses> by_end = {};  ///< the first gain over the rays of one end class only
  int rays = 0;                                 ///< that this view sees inside the object box
};

/// A node's ground point, and its headings.
struct ViewNode {
  core::Vec3 ground_map = core::Vec3::Zero();
  std::vector<double> yaw_rad;
};

struct EvaluatorOptions {
  std::vector<std::string> gains;  ///< the deciding one first
  int rays = 6000;                 ///< a view inside the object box, at least
  double max_range_m = 20.0;
};

/// What views are predicted of.
struct ViewTarget {
  core::Box3 object_box;  ///< rays go into it
  core::Box3 seen_box;    ///< about it: what rays are followed in
};

/// Predicts views with the true field of view of the sweep. Immutable after construction.
class ViewEvaluator {
 public:
  /// @throws InputError for an unknown gain.
  ViewEvaluator(const SweepSensorModel& sensor, const ViewTarget& target, EvaluatorOptions options);

  /// One entry a heading of each node; nodes are split over threads, and results do not depend on how.
  /// `rays_traced`, where given, receives the number of traces.
  std::vector<std::vector<ViewGain>> Evaluate(const mapping::MapView& map, const std::vector<ViewNode>& nodes,
                                              int threads, size_t* rays_traced = nullptr) const;
  const SweepView& view() const { return view_; }

 private:
  struct Scratch;
  std::vector<ViewGain> EvaluateNode(const mapping::MapView& map, const ViewNode& node,
                                     Scratch* scratch) const;

  SweepView view_;
  ViewTarget target_;
  EvaluatorOptions options_;
  mapping::TraceLimits limits_;
  std::vector<const GainEntry*> entries_;
};

}  // namespace atlas::planner
