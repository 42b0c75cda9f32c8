// A view at random of all that can be reached: what every other planner has to beat. It never thinks itself
// done; a budget ends its missions.
#include "planner/graph/roadmap.h"
#include "planner/planners/entries.h"
#include "planner/travel/travel.h"

namespace atlas::planner {
namespace {

class RandomParams final : public PlannerParamsOf<RandomParams> {
 public:
  void Visit(core::ParamVisitor& v) override {
    v.Field(
        "window_m", &plan_in_m,
        {.unit = "m",
         .min = 2.0,
         .max = 30.0,
         .doc = "side of the square about the robot that it plans in; what the elevation map does not hold "
                "is left out"});
    v.Field("lattice_m", &lattice_m,
            {.unit = "m", .min = 0.1, .max = 5.0, .doc = "spacing of the places considered"});
    travel.Visit(v);
  }
  std::unique_ptr<Planner> Build(const PlannerSetup& setup) const override;
  double window_m() const override { return plan_in_m; }

  double plan_in_m = 16.0;
  double lattice_m = 0.5;
  TravelParams travel;
};

class Random final : public Planner {
 public:
  Random(const RandomParams& params, const PlannerSetup& setup)
      : params_(params), robot_(setup.robot), rng_(setup.rng.Split("random")), travel_(params.travel) {}

  void OnScan(const ScanOutcome&, const core::PoseSource&) override {}

  Decision Plan(const Belief& belief, DecisionLog* log) override {
    core::Rng rng = rng_.Split("plan" + std::to_string(plans_++));
    const Walkable walkable(belief.ground, belief.p_map(), params_.plan_in_m);
    CandidateTree tree = LatticeCandidates(walkable, params_.lattice_m);
    roadmap_.Learn(tree, belief.poses);
    roadmap_.Extend(&tree);
    log->nodes_obtained = static_cast<int>(tree.nodes.size());
    if (tree.nodes.empty()) {
      if (auto move = travel_.Recover(belief, robot_.GroundUnder(belief.T_map_base), log)) return *move;
      return Stuck{Stuck::Reason::kNoCandidates};
    }
    Candidate view;
    view.node = rng.UniformInt(log->nodes_obtained);
    const CandidateNode& node = tree.nodes[static_cast<size_t>(view.node)];
    view.p_map = node.p_map;
    view.ground_m = node.ground_m;
    view.path_length_m = node.path_length_m;
    view.yaw_rad = rng.Uniform(-core::kPi, core::kPi);
    log->candidates = {view};
    return travel_.GoTo(0, belief, {walkable, tree}, rng, log);
  }

 private:
  RandomParams params_;
  RobotModel robot_;
  core::Rng rng_;
  Travel travel_;
  Roadmap roadmap_;
  int plans_ = 0;
};

std::unique_ptr<Planner> RandomParams::Build(const PlannerSetup& setup) const {
  return std::make_unique<Random>(*this, setup);
}

}  // namespace

PlannerEntry RandomPlanner() {
  return {"random", "a reachable view at random, until a budget ends the mission",
          [] { return std::unique_ptr<PlannerParams>(std::make_unique<RandomParams>()); }};
}

}  // namespace atlas::planner
