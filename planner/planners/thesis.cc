#include "planner/planners/thesis.h"

#include <algorithm>

#include "planner/planners/entries.h"
#include "planner/stopping/termination.h"

namespace atlas::planner {
namespace {

class Thesis final : public Planner {
 public:
  Thesis(const ThesisParams& params, const PlannerSetup& setup)
      : params_(params), parts_(params.nbv, params.Roles(), setup), rng_(setup.rng.Split("nbv_planner")) {}

  void OnScan(const ScanOutcome& scan, const core::PoseSource& poses) override {
    parts_.memory.RecordSweep(scan.T_map_base, scan.new_surface, poses);
  }
  Decision Plan(const Belief& belief, DecisionLog* log) override;

 private:
  ThesisParams params_;
  NbvParts parts_;
  core::Rng rng_;
  double greatest_utility_ = 0.0;
  int plans_ = 0;
};

/// x* of Eq. 3.1; -1 where no view promises anything.
int BestView(DecisionLog* log) {
  int best = -1;
  double most = 0.0;
  for (size_t i = 0; i < log->candidates.size(); ++i) {
    Candidate& c = log->candidates[i];
    if (c.utility <= 0.0) c.reason = LossReason::kNoGain;
    if (c.utility <= most) continue;
    most = *c.utility;
    best = static_cast<int>(i);
  }
  return best;
}

Decision Thesis::Plan(const Belief& belief, DecisionLog* log) {
  const core::Rng rng = rng_.Split("plan" + std::to_string(plans_++));
  const Walkable walkable = parts_.Begin(belief);
  const CandidateTree tree =
      RrtCandidates(walkable, params_.nbv.views.nodes, params_.rrt_step_m, rng.Split("rrt"));
  const Ways ways{walkable, tree};
  parts_.Places(belief, ways, log);
  if (tree.nodes.empty()) return parts_.WithoutPlaces(belief, log);

  parts_.ValueViews(belief, ways, WorthIsGain, log);
  int best = BestView(log);
  const double utility = best < 0 ? 0.0 : log->candidates[static_cast<size_t>(best)].utility.value();
  greatest_utility_ = std::max(greatest_utility_, utility);
  log->utility_ratio = greatest_utility_ > 0.0 ? utility / greatest_utility_ : 0.0;
  if (greatest_utility_ <= 0.0) best = parts_.NearerToObject(*log);
  const bool nearer = greatest_utility_ <= 0.0 && best >= 0;
  if (!nearer && BelowThreshold(utility, params_.stop_utility)) {
    return parts_.End(Done::Reason::kGainExhausted, belief, log);
  }
  return parts_.GoTo(best, belief, ways, rng, log);
}

}  // namespace

ThesisParams::ThesisParams() {
  nbv.views.window_m = 12.0;
  nbv.costs.traversal = "discrete";
  nbv.costs.too_close_threshold_m = nbv.costs.visited_threshold_m;  // Eq. 3.7 has one d_thres
}

void ThesisParams::Visit(core::ParamVisitor& v) {
  gains.Visit(v);
  nbv.Visit(v);
  v.Field("rrt_step_m", &rrt_step_m, {.unit = "m", .min = 0.1, .max = 5.0, .doc = "longest edge of the RRT"});
  v.Field("stop_utility", &stop_utility,
          {.unit = "nats",
           .min = 0.0,
           .max = 1e9,
           .doc = "u_thres of Eq. 3.8: stop where no view's utility reaches this; occlusion aware never "
                  "falls so low"});
}

std::unique_ptr<Planner> ThesisParams::Build(const PlannerSetup& setup) const {
  return std::make_unique<Thesis>(*this, setup);
}

PlannerEntry ThesisPlanner() {
  return {"thesis",
          "as thesis 3.4, 3.5: RRT views, utility of Eq. 3.1, threshold of Eq. 3.8; on OctoMap unless told",
          [] { return std::unique_ptr<PlannerParams>(std::make_unique<ThesisParams>()); }};
}

}  // namespace atlas::planner
