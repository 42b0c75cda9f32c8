#include "planner/planners/nbv_planner.h"

#include <algorithm>
#include <cmath>

#include "core/errors.h"
#include "planner/gain/gain.h"
#include "planner/gain/view_evaluator.h"
#include "planner/graph/blocked_ways.h"
#include "planner/graph/roadmap.h"
#include "planner/planners/route_planner.h"
#include "planner/stopping/termination.h"
#include "planner/stopping/unpromising_views.h"
#include "planner/stopping/view_memory.h"
#include "planner/travel/costs.h"
#include "planner/travel/recovery.h"
#include "planner/travel/view_path.h"
#include "planner/views/candidates.h"

namespace atlas::planner {
namespace {

using core::Pose;
using core::Vec2;
using core::Vec3;

/// Longest passage in which the robot cannot turn.
constexpr double kPassage_m = 1.6;
/// u_thres: a fortieth of the most that rear side entropy promised on the car (docs/thesis_rows.md).
constexpr double kThesisStopUtility = 5000.0;
/// A view counts as the committed one within this distance and turn.
constexpr double kSameView_m = 0.5;
constexpr double kSameView_rad = core::Radians(50.0);

bool IsThesis(const NbvParams& params) {
  return params.name == "thesis";
}

bool DecidesBySurface(const NbvParams& params) {
  return !IsThesis(params) && params.gain_share < 1.0;
}

/// The deciding gain, the surface where that decides too, and those asked for besides.
std::vector<std::string> GainsAsked(const NbvParams& params) {
  std::vector<std::string> gains = {params.gain};
  if (DecidesBySurface(params)) gains.emplace_back("surface_frontier");
  gains.insert(gains.end(), params.extra_gains.begin(), params.extra_gains.end());
  return gains;
}

/// Headings spread evenly, one pair of them broadside to the nearest point of the object box: a roll widens
/// the view abeam.
std::vector<double> HeadingsAt(const Vec2& p_map, const core::Box3& box, int headings) {
  const Vec2 nearest = p_map.cwiseMax(box.min.head<2>()).cwiseMin(box.max.head<2>());
  const Vec2 to_box =
      (nearest - p_map).norm() > 1e-6 ? nearest - p_map : Vec2(box.Center().head<2>() - p_map);
  const double broadside = std::atan2(to_box.y(), to_box.x()) + 0.5 * core::kPi;
  std::vector<double> yaw(static_cast<size_t>(headings));
  for (int i = 0; i < headings; ++i) {
    yaw[static_cast<size_t>(i)] = core::WrapAngle(broadside + 2.0 * core::kPi * i / headings);
  }
  return yaw;
}

class Planner final : public NbvPlanner {
 public:
  Planner(const NbvParams& params, const RobotModel& robot, const ViewTarget& target, int threads,
          const core::Rng& rng)
      : params_(params),
        footprint_{robot.half_width_m, robot.turning_radius_m, params.terrain.edge_clearance_m},
        target_(target),
        evaluator_(robot.sensor, target, {GainsAsked(params), params.rays, params.max_range_m}),
        threads_(threads),
        rng_(rng.Split("nbv_planner")),
        termination_({params.stop_ratio, params.flat_share, params.stop_rounds, params.flat_rounds}) {
    traversal_.speed_mps = robot.speed_mps;
    traversal_.time_scale_s = params.time_scale_s;
    traversal_.slope_scale_rad = core::Radians(params.terrain.critical_slope_deg);
    traversal_.roughness_scale_m = params.terrain.critical_roughness_m;
  }

  void OnSweep(const Pose& T_map_base, size_t new_surface) override {
    memory_.RecordSweep(T_map_base, new_surface);
  }
  NbvDecision Plan(const Pose& T_map_base, const mapping::MapView& map,
                   const mapping::TraversableGround& terrain) override;

 private:
  CandidateTree PickPlaces(const Walkable& walkable, const core::Rng& rng);
  void EvaluateGains(const mapping::MapView& map, const Walkable& walkable, const CandidateTree& tree,
                     NbvDecision* decision) const;
  void ValueViews(NbvDecision* decision);
  void ChargeCosts(const Pose& T_map_base, const mapping::MapView& map, const Walkable& walkable,
                   const CandidateTree& tree, NbvDecision* decision) const;
  std::vector<int> RankViews(NbvDecision* decision) const;
  int NearerToObject(double best_utility, const NbvDecision& decision) const;
  NbvOutcome EndOf(double best_utility) const;
  bool JudgeBlockedWays(const mapping::MapView& map, NbvDecision* decision);
  void Recover(const Pose& T_map_base, const mapping::TraversableGround& ground, NbvDecision* decision);
  void FindWay(const Walkable& walkable, const CandidateTree& tree, int view, const core::Rng& rng,
               NbvDecision* decision) const;

  NbvParams params_;
  Footprint footprint_;
  ViewTarget target_;
  ViewEvaluator evaluator_;
  TraversalModel traversal_;
  int threads_;
  core::Rng rng_;
  ViewMemory memory_;
  Roadmap roadmap_;
  Termination termination_;
  BlockedWays blocked_ways_;
  Recovery recovery_;
  double greatest_worth_ = 0.0;  ///< of a view, before trust and costs; over all plans
  int plans_ = 0;
};

NbvDecision Planner::Plan(const Pose& T_map_base, const mapping::MapView& map,
                          const mapping::TraversableGround& terrain) {
  const core::Rng rng = rng_.Split("plan" + std::to_string(plans_++));
  const Walkable walkable(terrain, T_map_base.translation().head<2>(), params_.window_m);
  NbvDecision decision;

  const CandidateTree tree = PickPlaces(walkable, rng);
  decision.nodes_obtained = static_cast<int>(tree.nodes.size());
  decision.attempts = tree.attempts;
  blocked_ways_.Learn(walkable, tree, FindBlockedWays(walkable, tree, footprint_));
  decision.blocked = blocked_ways_.ways();
  if (tree.nodes.empty()) {
    Recover(T_map_base, terrain, &decision);
    if (decision.outcome != NbvOutcome::kView && JudgeBlockedWays(map, &decision)) {
      decision.outcome = NbvOutcome::kBlockedNarrow;
    }
    return decision;
  }

  EvaluateGains(map, walkable, tree, &decision);
  ValueViews(&decision);
  ChargeCosts(T_map_base, map, walkable, tree, &decision);
  const std::vector<int> ranked = RankViews(&decision);

  const double best_utility =
      ranked.empty() ? 0.0 : decision.candidates[static_cast<size_t>(ranked[0])].utility;
  termination_.Observe(best_utility, memory_.latest_surface_share());
  decision.utility_ratio = termination_.ratio();
  const int nearer = NearerToObject(best_utility, decision);
  decision.outcome = nearer < 0 ? EndOf(best_utility) : NbvOutcome::kView;
  if (decision.outcome != NbvOutcome::kView) {
    if (JudgeBlockedWays(map, &decision)) decision.outcome = NbvOutcome::kBlockedNarrow;
    return decision;
  }

  const bool promises = best_utility > 0.0;
  const int unseen = nearer < 0 ? FarthestFromScans(decision.candidates, memory_.visited()) : nearer;
  FindWay(walkable, tree, promises ? ranked[0] : unseen, rng, &decision);
  const Candidate& view = decision.candidates[static_cast<size_t>(decision.best)];
  memory_.Commit({view.p_map, view.yaw_rad});
  recovery_.SetOut(decision.path_map);
  return decision;
}

/// Of an object that is too far away for any plan so far to predict views of it, a view nearer to it; else
/// -1.
int Planner::NearerToObject(double best_utility, const NbvDecision& decision) const {
  if (best_utility > 0.0 || !termination_.NothingWasPromised()) return -1;
  return NearestToObject(decision.candidates, memory_.visited(), target_.object_box, params_.max_range_m);
}

/// How the mission ends with this plan; kView where it goes on.
NbvOutcome Planner::EndOf(double best_utility) const {
  const bool nothing_left = best_utility <= 0.0 && (!DecidesBySurface(params_) || termination_.NothingLeft());
  const bool exhausted = IsThesis(params_) ? BelowThreshold(best_utility, params_.stop_utility)
                                           : termination_.GainExhausted() || nothing_left;
  const bool flat = !IsThesis(params_) && termination_.SurfaceFlat();
  if (!exhausted && !flat) return NbvOutcome::kView;
  const bool seen = memory_.surface_seen() > 0.0 &&
                    DistanceToObject(memory_.visited(), target_.object_box) <= params_.max_range_m;
  if (!seen) return NbvOutcome::kOutOfReach;
  return exhausted ? NbvOutcome::kGainExhausted : NbvOutcome::kSurfaceFlat;
}

/// Predicts the views beyond ways that are too narrow, as if the robot stood there.
/// @return whether one promises what would be worth going for.
bool Planner::JudgeBlockedWays(const mapping::MapView& map, NbvDecision* decision) {
  std::vector<ViewNode> nodes;
  for (const Vec3& p : blocked_ways_.PlacesBeyond()) {
    nodes.push_back({p, HeadingsAt(p.head<2>(), target_.object_box, params_.headings)});
  }
  size_t rays = 0;
  std::vector<double> shares;
  for (const std::vector<ViewGain>& views : evaluator_.Evaluate(map, nodes, threads_, &rays)) {
    double best = 0.0;
    for (const ViewGain& view : views) best = std::max(best, view.gain[DecidesBySurface(params_) ? 1 : 0]);
    // Where no plan ever saw anything worth while, whatever is beyond is.
    shares.push_back(greatest_worth_ > 0.0 ? best / greatest_worth_ : (best > 0.0 ? 1.0 : 0.0));
  }
  decision->rays_traced += rays;
  blocked_ways_.SetWorth(shares);
  decision->blocked = blocked_ways_.ways();
  return std::any_of(shares.begin(), shares.end(),
                     [this](double share) { return share >= params_.blocked_share; });
}

CandidateTree Planner::PickPlaces(const Walkable& walkable, const core::Rng& rng) {
  if (!IsThesis(params_)) {
    // A lattice misses no corner that an RRT happens not to fill.
    CandidateTree lattice =
        params_.passages == "centred"
            ? LatticeCandidates(walkable, params_.lattice_m, 0.0, FindPassages(walkable, kPassage_m))
            : LatticeCandidates(walkable, params_.lattice_m, params_.roadmap ? kPassage_m : 0.0);
    if (params_.roadmap) {
      roadmap_.Learn(lattice);
      roadmap_.Extend(&lattice);
    }
    if (!lattice.nodes.empty()) return lattice;
  }
  return RrtCandidates(walkable, params_.nodes, params_.rrt_step_m, rng.Split("rrt"));
}

void Planner::EvaluateGains(const mapping::MapView& map, const Walkable& walkable, const CandidateTree& tree,
                            NbvDecision* decision) const {
  const std::vector<int> places = SpreadOut(tree.nodes, walkable.start(), params_.nodes);
  std::vector<ViewNode> nodes;
  for (const int place : places) {
    const CandidateNode& node = tree.nodes[static_cast<size_t>(place)];
    const Vec2& p = node.p_map;
    nodes.push_back({Vec3(p.x(), p.y(), node.ground_m), HeadingsAt(p, target_.object_box, params_.headings)});
  }
  const auto gains = evaluator_.Evaluate(map, nodes, threads_, &decision->rays_traced);
  for (size_t i = 0; i < nodes.size(); ++i) {
    for (size_t h = 0; h < nodes[i].yaw_rad.size(); ++h) {
      const ViewGain& view = gains[i][h];
      Candidate c;
      c.p_map = nodes[i].ground_map.head<2>();
      c.ground_m = nodes[i].ground_map.z();
      c.yaw_rad = nodes[i].yaw_rad[h];
      c.node = places[i];
      c.path_length_m = tree.nodes[static_cast<size_t>(places[i])].path_length_m;
      c.gain = view.gain[0];
      const auto extra = view.gain.begin() + (DecidesBySurface(params_) ? 2 : 1);
      c.surface_m2 = DecidesBySurface(params_) ? view.gain[1] : 0.0;
      c.extra_gains.assign(extra, view.gain.end());
      c.gain_void = view.by_end[static_cast<size_t>(EndClass::kVoid)];
      c.gain_ground = view.by_end[static_cast<size_t>(EndClass::kGround)];
      c.gain_object = view.by_end[static_cast<size_t>(EndClass::kObject)];
      decision->candidates.push_back(c);
    }
  }
}

/// What Eq. 3.1 takes for g_x.
void Planner::ValueViews(NbvDecision* decision) {
  double most = 0.0;
  for (const Candidate& c : decision->candidates) {
    most = std::max(most, c.gain);
    greatest_worth_ = std::max(greatest_worth_, DecidesBySurface(params_) ? c.surface_m2 : c.gain);
  }
  for (Candidate& c : decision->candidates) {
    const double relative = most > 0.0 ? c.gain / most : 0.0;
    c.worth =
        DecidesBySurface(params_) ? c.surface_m2 * (1.0 - params_.gain_share * (1.0 - relative)) : c.gain;
    if (params_.unvisited_m2 > 0.0) {
      const double distance = DistanceToVisited(c.p_map, memory_.visited());
      c.worth += params_.unvisited_m2 * std::max(0.0, 1.0 - params_.unvisited_beyond_m / distance);
    }
    if (params_.distrust_m > 0.0) c.worth *= memory_.TrustAt(c.p_map, params_.distrust_m);
  }
}

void Planner::ChargeCosts(const Pose& T_map_base, const mapping::MapView& map, const Walkable& walkable,
                          const CandidateTree& tree, NbvDecision* decision) const {
  const double yaw = core::YawOf(T_map_base.linear());
  const double ground_m = walkable.ground().SurfaceAt(walkable.start()).height_m;
  const ObjectDistance object(map, target_.seen_box, ground_m);
  for (Candidate& c : decision->candidates) {
    if (params_.visited_cost) {
      c.visited_cost =
          PositionCost(DistanceToVisited(c.p_map, memory_.visited()), params_.visited_threshold_m);
    }
    if (params_.too_close_cost) {
      const Vec3 sensor(c.p_map.x(), c.p_map.y(), c.ground_m + evaluator_.view().sensor_height_m());
      const double distance = object.At(sensor, params_.too_close_threshold_m + 0.1);
      c.too_close_cost = PositionCost(distance, params_.too_close_threshold_m);
    }
    c.position_cost = std::max(c.visited_cost, c.too_close_cost);
    const double penalty = IsBehind(c.p_map, T_map_base) ? params_.behind_penalty : 0.0;
    double way = 0.0;  // the thesis's classes: what the tree reaches is safe
    if (params_.traversal == "continuous") {
      const std::vector<Vec2> path = tree.PathTo(c.node, walkable.start());
      way = ContinuousTraversalCost(traversal_, WalkTime(traversal_, walkable, path, yaw, c.yaw_rad));
    }
    c.traversal_cost = CombineCosts(way, penalty);
    c.utility = Utility(c.worth, c.position_cost, c.traversal_cost);
  }
}

/// Candidates that may be chosen, best first; the rest get the reason why not. A commitment comes first
/// unless another view beats it by the margin.
std::vector<int> Planner::RankViews(NbvDecision* decision) const {
  std::vector<int> ranked;
  for (size_t i = 0; i < decision->candidates.size(); ++i) {
    Candidate& c = decision->candidates[i];
    if (c.utility <= 0.0) {
      c.reason = LossReason::kNoGain;
    } else if (params_.blacklist_after > 0 &&
               memory_.BrokenPromisesNear(c.p_map) >= params_.blacklist_after) {
      c.reason = LossReason::kBlacklisted;
    } else {
      ranked.push_back(static_cast<int>(i));
    }
  }
  const auto utility = [&](int i) { return decision->candidates[static_cast<size_t>(i)].utility; };
  std::stable_sort(ranked.begin(), ranked.end(), [&](int a, int b) { return utility(a) > utility(b); });
  if (!memory_.commitment()) return ranked;
  const auto kept = std::find_if(ranked.begin(), ranked.end(), [&](int i) {
    const Candidate& c = decision->candidates[static_cast<size_t>(i)];
    return (c.p_map - memory_.commitment()->p_map).norm() < kSameView_m &&
           std::abs(core::WrapAngle(c.yaw_rad - memory_.commitment()->yaw_rad)) < kSameView_rad;
  });
  if (kept != ranked.end() && utility(*kept) * (1.0 + params_.commit_margin) >= utility(ranked.front())) {
    std::rotate(ranked.begin(), kept, kept + 1);
  }
  return ranked;
}

/// Nowhere to go from here, it seems.
void Planner::Recover(const Pose& T_map_base, const mapping::TraversableGround& ground,
                      NbvDecision* decision) {
  const auto move = recovery_.Next(T_map_base, ground);
  if (!move) return;
  decision->path_map = move->path_map;
  decision->path_length_m = PathLength(move->path_map);
  Candidate there;
  there.p_map = move->path_map.back();
  there.ground_m = T_map_base.translation().z() - evaluator_.view().sensor_height_m();
  there.yaw_rad = move->yaw_rad;
  there.path_length_m = decision->path_length_m;
  there.reason = LossReason::kChosen;
  decision->candidates = {there};
  decision->best = 0;
  decision->outcome = NbvOutcome::kView;
}

void Planner::FindWay(const Walkable& walkable, const CandidateTree& tree, int view, const core::Rng& rng,
                      NbvDecision* decision) const {
  Candidate& c = decision->candidates[static_cast<size_t>(view)];
  decision->path_map = PlanViewPath(walkable, tree.PathTo(c.node, walkable.start()), tree.NarrowSteps(c.node),
                                    params_.rrt_star_iterations, rng.Split("path"));
  decision->path_length_m = PathLength(decision->path_map);
  decision->best = view;
  decision->outcome = NbvOutcome::kView;
  c.reason = LossReason::kChosen;
}

}  // namespace

const std::vector<PlannerEntry>& PlannerCatalog() {
  static const std::vector<PlannerEntry> catalog = {
      {"thesis",
       "as thesis 3.4, 3.5: RRT views, utility of Eq. 3.1, threshold of Eq. 3.8; on OctoMap unless told"},
      {"greedy", "lattice views worth the surface they uncover, continuous traversal cost"},
      {"route",
       "the views of planner.route in their order, so that runs differ in nothing but what they sense"},
  };
  return catalog;
}

NbvParams DefaultParams(const std::string& name) {
  NbvParams params;
  params.name = name;
  if (name == "thesis") {
    params.gain = "occlusion_aware";
    params.traversal = "discrete";
    params.window_m = 12.0;
    params.roadmap = false;
    params.distrust_m = 0.0;
    params.too_close_threshold_m = params.visited_threshold_m;  // Eq. 3.7 has one d_thres
    params.commit_margin = 0.0;
    params.blacklist_after = 0;
    params.stop_utility = kThesisStopUtility;
  }
  params.terrain.window_m = params.window_m;
  if (name == "thesis" || name == "greedy" || name == "route") return params;
  std::vector<std::string> names;
  for (const PlannerEntry& entry : PlannerCatalog()) names.push_back(entry.name);
  throw core::InputError(core::UnknownName("planner", name, names));
}

GainReads ReadsOf(const NbvParams& params) {
  GainReads all;
  if (params.name == "route") return all;
  for (const std::string& name : GainsAsked(params)) {
    const GainReads& reads = FindGain(name).reads;
    all.each_free |= reads.each_free;
    all.each_unmeasured |= reads.each_unmeasured;
    all.behind_surface |= reads.behind_surface;
  }
  return all;
}

std::unique_ptr<NbvPlanner> MakeNbvPlanner(const NbvParams& params, const RobotModel& robot,
                                           const ViewTarget& target, int threads, const core::Rng& rng) {
  DefaultParams(params.name);  // throws for an unknown name
  if (params.name == "route") return MakeRoutePlanner(params.route);
  FindGain(params.gain);
  return std::make_unique<Planner>(params, robot, target, threads, rng);
}

}  // namespace atlas::planner
