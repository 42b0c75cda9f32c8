#include "planner/planners/surface_planner.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "planner/graph/roadmap.h"
#include "planner/stopping/unpromising_views.h"

namespace atlas::planner {
namespace {

/// Longest passage in which the robot cannot turn.
constexpr double kPassage_m = 1.6;
/// A view counts as the committed one within this distance and turn.
constexpr double kSameView_m = 0.5;
constexpr double kSameView_rad = core::Radians(50.0);

class SurfacePlanner final : public Planner {
 public:
  SurfacePlanner(const SurfaceParams& params, const PlannerSetup& setup)
      : params_(params),
        parts_(params.nbv, params.Roles(), setup),
        rng_(setup.rng.Split("nbv_planner")),
        termination_(params.stopping) {}

  void OnScan(const ScanOutcome& scan, const core::PoseSource& poses) override {
    parts_.memory.RecordSweep(scan.T_map_base, scan.new_surface, poses);
  }
  Decision Plan(const Belief& belief, DecisionLog* log) override;

 private:
  CandidateTree PickPlaces(const Belief& belief, const Walkable& walkable, const core::Rng& rng);
  void ModulateBySurface(DecisionLog* log) const;
  std::vector<int> RankViews(DecisionLog* log) const;
  std::optional<Done::Reason> WhyDone(double best_utility) const;

  SurfaceParams params_;
  NbvParts parts_;
  core::Rng rng_;
  Roadmap roadmap_;
  Termination termination_;
  int plans_ = 0;
};

Decision SurfacePlanner::Plan(const Belief& belief, DecisionLog* log) {
  const core::Rng rng = rng_.Split("plan" + std::to_string(plans_++));
  const Walkable walkable = parts_.Begin(belief);
  const CandidateTree tree = PickPlaces(belief, walkable, rng);
  const Ways ways{walkable, tree};
  parts_.Places(belief, ways, log);
  if (tree.nodes.empty()) return parts_.WithoutPlaces(belief, log);

  parts_.ValueViews(
      belief, ways, [this](DecisionLog* views) { ModulateBySurface(views); }, log);
  const std::vector<int> ranked = RankViews(log);
  const double best = ranked.empty() ? 0.0 : log->candidates[static_cast<size_t>(ranked[0])].utility.value();
  termination_.Observe(best, parts_.memory.latest_surface_share());
  log->utility_ratio = termination_.ratio();
  const bool too_far = best <= 0.0 && termination_.NothingWasPromised();
  int view = too_far ? parts_.NearerToObject(*log) : -1;
  if (view < 0) {
    if (const auto reason = WhyDone(best)) return parts_.End(*reason, belief, log);
    view = best > 0.0 ? ranked[0] : FarthestFromScans(log->candidates, parts_.memory.visited());
  }
  return parts_.GoTo(view, belief, ways, rng, log);
}

CandidateTree SurfacePlanner::PickPlaces(const Belief& belief, const Walkable& walkable,
                                         const core::Rng& rng) {
  // A lattice misses no corner that an RRT happens not to fill.
  const PlaceParams& places = params_.places;
  CandidateTree lattice =
      places.passages == "centred"
          ? LatticeCandidates(walkable, places.lattice_m, 0.0, FindPassages(walkable, kPassage_m))
          : LatticeCandidates(walkable, places.lattice_m, places.roadmap ? kPassage_m : 0.0);
  if (places.roadmap) {
    roadmap_.Learn(lattice, belief.poses);
    roadmap_.Extend(&lattice);
  }
  if (!lattice.nodes.empty()) return lattice;
  return RrtCandidates(walkable, params_.nbv.views.nodes, places.rrt_step_m, rng.Split("rrt"));
}

/// What Eq. 3.1 takes for g_x.
void SurfacePlanner::ModulateBySurface(DecisionLog* log) const {
  double most = 0.0;
  for (const Candidate& c : log->candidates) most = std::max(most, *c.gain);
  const ViewMemory& memory = parts_.memory;
  for (Candidate& c : log->candidates) {
    const double relative = most > 0.0 ? *c.gain / most : 0.0;
    double worth =
        params_.DecidesBySurface() ? *c.surface_m2 * (1.0 - params_.gain_share * (1.0 - relative)) : *c.gain;
    if (params_.unvisited_m2 > 0.0) {
      const double distance = DistanceToVisited(c.p_map, memory.visited());
      worth += params_.unvisited_m2 * std::max(0.0, 1.0 - params_.unvisited_beyond_m / distance);
    }
    if (params_.distrust_m > 0.0) worth *= memory.TrustAt(c.p_map, params_.distrust_m);
    c.worth = worth;
  }
}

/// Candidates that may be chosen, best first; the rest get the reason why not. A commitment comes first
/// unless another view beats it by the margin.
std::vector<int> SurfacePlanner::RankViews(DecisionLog* log) const {
  const ViewMemory& memory = parts_.memory;
  std::vector<int> ranked;
  for (size_t i = 0; i < log->candidates.size(); ++i) {
    Candidate& c = log->candidates[i];
    if (c.utility <= 0.0) {
      c.reason = LossReason::kNoGain;
    } else if (params_.blacklist_after > 0 && memory.BrokenPromisesNear(c.p_map) >= params_.blacklist_after) {
      c.reason = LossReason::kBlacklisted;
    } else {
      ranked.push_back(static_cast<int>(i));
    }
  }
  const auto utility = [&](int i) { return *log->candidates[static_cast<size_t>(i)].utility; };
  std::stable_sort(ranked.begin(), ranked.end(), [&](int a, int b) { return utility(a) > utility(b); });
  if (!memory.commitment()) return ranked;
  const auto kept = std::find_if(ranked.begin(), ranked.end(), [&](int i) {
    const Candidate& c = log->candidates[static_cast<size_t>(i)];
    return (c.p_map - memory.commitment()->p_map).norm() < kSameView_m &&
           std::abs(core::WrapAngle(c.yaw_rad - memory.commitment()->yaw_rad)) < kSameView_rad;
  });
  if (kept != ranked.end() && utility(*kept) * (1.0 + params_.commit_margin) >= utility(ranked.front())) {
    std::rotate(ranked.begin(), kept, kept + 1);
  }
  return ranked;
}

std::optional<Done::Reason> SurfacePlanner::WhyDone(double best_utility) const {
  const bool nothing_left =
      best_utility <= 0.0 && (!params_.DecidesBySurface() || termination_.NothingLeft());
  if (termination_.GainExhausted() || nothing_left) return Done::Reason::kGainExhausted;
  if (termination_.SurfaceFlat()) return Done::Reason::kSurfaceFlat;
  return std::nullopt;
}

}  // namespace

void SurfaceParams::VisitShared(core::ParamVisitor& v) {
  gains.Visit(v);
  v.Field("gain_share", &gain_share,
          {.min = 0.0,
           .max = 1.0,
           .doc = "how far the gain modulates the surface that a view uncovers; 1: gain alone"});
  nbv.Visit(v);
  v.Field("lattice_m", &places.lattice_m,
          {.unit = "m", .min = 0.1, .max = 5.0, .doc = "spacing of the places considered"});
  v.Field("rrt_step_m", &places.rrt_step_m,
          {.unit = "m", .min = 0.1, .max = 5.0, .doc = "longest edge of the RRT"});
  v.Field("commit_margin", &commit_margin,
          {.min = 0.0, .max = 10.0, .doc = "a commitment stays unless another view is this much better"});
  v.Field("blacklist_after", &blacklist_after,
          {.min = 0,
           .max = 100,
           .doc = "views here that brought nothing, before the place is dropped; 0: never"});
  stopping.Visit(v);
}

std::unique_ptr<Planner> MakeSurfacePlanner(const SurfaceParams& params, const PlannerSetup& setup) {
  return std::make_unique<SurfacePlanner>(params, setup);
}

}  // namespace atlas::planner
