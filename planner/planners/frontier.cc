// The nearest frontier (Yamauchi 1997), of surfaces: the robot goes to the nearest view that uncovers
// something, whatever lies farther away, and is done where there is none.
#include <algorithm>

#include "planner/graph/roadmap.h"
#include "planner/planners/entries.h"
#include "planner/planners/nbv_parts.h"

namespace atlas::planner {
namespace {

class FrontierParams final : public PlannerParamsOf<FrontierParams> {
 public:
  void Visit(core::ParamVisitor& v) override {
    v.Field("frontier_m2", &frontier_m2,
            {.unit = "m^2", .min = 0.0, .max = 1000.0, .doc = "a view of a frontier uncovers this much"});
    v.Field("dropped_after", &dropped_after,
            {.min = 1,
             .max = 100,
             .doc = "views here that brought nothing, before what they promise is no frontier"});
    v.Field("lattice_m", &lattice_m,
            {.unit = "m", .min = 0.1, .max = 5.0, .doc = "spacing of the places considered"});
    nbv.views.Visit(v);
    nbv.blocked.Visit(v);
    nbv.travel.Visit(v);
  }
  std::unique_ptr<Planner> Build(const PlannerSetup& setup) const override;
  double window_m() const override { return nbv.views.window_m; }
  std::string gain() const override { return "surface_frontier"; }
  GainReads reads() const override { return Roles().reads(); }
  static GainRoles Roles() { return {.deciding = "surface_frontier", .extra = {}}; }

  double frontier_m2 = 0.5;
  int dropped_after = 1;
  double lattice_m = 0.5;
  NbvParams nbv;
};

class Frontier final : public Planner {
 public:
  Frontier(const FrontierParams& params, const PlannerSetup& setup)
      : params_(params),
        parts_(params.nbv, FrontierParams::Roles(), setup),
        rng_(setup.rng.Split("frontier")) {}

  void OnScan(const ScanOutcome& scan, const core::PoseSource& poses) override {
    parts_.memory.RecordSweep(scan.T_map_base, scan.new_surface, poses);
  }

  Decision Plan(const Belief& belief, DecisionLog* log) override {
    const core::Rng rng = rng_.Split("plan" + std::to_string(plans_++));
    const Walkable walkable = parts_.Begin(belief);
    CandidateTree tree = LatticeCandidates(walkable, params_.lattice_m);
    roadmap_.Learn(tree, belief.poses);
    roadmap_.Extend(&tree);
    const Ways ways{walkable, tree};
    parts_.Places(belief, ways, log);
    if (tree.nodes.empty()) return parts_.WithoutPlaces(belief, log);
    parts_.PredictViews(belief, ways, log);  // what they cost decides nothing
    promised_ = promised_ || parts_.greatest_value > 0.0;
    int view = Nearest(log);
    if (view < 0 && !promised_) view = parts_.NearerToObject(*log);
    if (view < 0) return parts_.End(Done::Reason::kGainExhausted, belief, log);
    return parts_.GoTo(view, belief, ways, rng, log);
  }

 private:
  /// By its way, then by what it uncovers; -1 where there is none.
  int Nearest(DecisionLog* log) const {
    int nearest = -1;
    for (size_t i = 0; i < log->candidates.size(); ++i) {
      Candidate& c = log->candidates[i];
      if (*c.gain <= 0.0 || *c.gain < params_.frontier_m2) {
        c.reason = LossReason::kNoGain;
      } else if (parts_.memory.BrokenPromisesNear(c.p_map) >= params_.dropped_after) {
        c.reason = LossReason::kBlacklisted;
      } else if (nearest < 0 || IsBefore(c, log->candidates[static_cast<size_t>(nearest)])) {
        nearest = static_cast<int>(i);
      }
    }
    return nearest;
  }
  static bool IsBefore(const Candidate& a, const Candidate& b) {
    if (a.path_length_m != b.path_length_m) return a.path_length_m < b.path_length_m;
    return *a.gain > *b.gain;
  }

  FrontierParams params_;
  NbvParts parts_;
  core::Rng rng_;
  Roadmap roadmap_;
  bool promised_ = false;
  int plans_ = 0;
};

std::unique_ptr<Planner> FrontierParams::Build(const PlannerSetup& setup) const {
  return std::make_unique<Frontier>(*this, setup);
}

}  // namespace

PlannerEntry FrontierPlanner() {
  return {"frontier", "the nearest view that uncovers surface, until none does (Yamauchi 1997)",
          [] { return std::unique_ptr<PlannerParams>(std::make_unique<FrontierParams>()); }};
}

}  // namespace atlas::planner
