// The thesis's planner (3.4, 3.5): RRT views, utility of Eq. 3.1, threshold of Eq. 3.8.
#pragma once

#include "planner/planners/gain_params.h"
#include "planner/planners/nbv_parts.h"

namespace atlas::planner {

class ThesisParams final : public PlannerParamsOf<ThesisParams> {
 public:
  ThesisParams();
  void Visit(core::ParamVisitor& v) override;
  std::unique_ptr<Planner> Build(const PlannerSetup& setup) const override;
  double window_m() const override { return nbv.views.window_m; }
  std::string gain() const override { return gains.gain; }
  std::vector<std::string> extra_gains() const override { return gains.extra_gains; }
  GainReads reads() const override { return Roles().reads(); }
  GainRoles Roles() const { return {.deciding = gains.gain, .extra = gains.extra_gains}; }

  GainParams gains{.gain = "occlusion_aware", .extra_gains = {}};
  NbvParams nbv;
  double rrt_step_m = 0.6;
  /// u_thres of Eq. 3.8, nats over all rays of a sweep. The thesis gives no value; this is a fortieth of the
  /// most that rear side entropy promised on the car (docs/thesis_rows.md). Occlusion aware never comes near
  /// it: void rays keep their unknown voxels, and known free space is worth more than unknown.
  double stop_utility = 5000.0;
};

}  // namespace atlas::planner
