// OMPL draws from generators that a process-wide seed feeds. That seed is set once, from the first run seed
// seen here; all samples that decide anything come from the passed stream, so results repeat within a process
// too.
#include "planner/views/ompl_bridge.h"

#include <ompl/base/Planner.h>
#include <ompl/base/goals/GoalState.h>
#include <ompl/base/objectives/PathLengthOptimizationObjective.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/datastructures/NearestNeighborsLinear.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRT.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>

namespace atlas::planner {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;
using core::Vec2;
using core::Vec3;

using Space = ob::RealVectorStateSpace;

void SeedOnce(uint64_t seed) {
  static std::once_flag once;
  std::call_once(once, [seed] {
    ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
    ompl::msg::noOutputHandler();
    ompl::RNG::setSeed(static_cast<uint32_t>(seed % 0x7fffffffU) + 1);
  });
}

Vec2 PointOf(const ob::State* state) {
  const auto* values = state->as<Space::StateType>()->values;
  return {values[0], values[1]};
}

void SetPoint(ob::State* state, const Vec2& p) {
  state->as<Space::StateType>()->values[0] = p.x();
  state->as<Space::StateType>()->values[1] = p.y();
}

/// Heights of the states that a planner keeps. Samples are never twice the same, so that (x, y) tells them
/// apart.
class Heights {
 public:
  void Set(const Vec3& p) { at_[{p.x(), p.y()}] = p.z(); }
  /// Nothing for a state that no step has reached yet.
  std::optional<Vec3> On(const Vec2& p) const {
    const auto found = at_.find({p.x(), p.y()});
    if (found == at_.end()) return std::nullopt;
    return Vec3(p.x(), p.y(), found->second);
  }

 private:
  std::map<std::pair<double, double>, double> at_;
};

/// Shared by a planner's sampler and motion validator.
struct Shared {
  const GroundProblem& problem;
  core::Rng rng;
  std::optional<Vec2> goal;       ///< sampled now and then
  std::vector<Vec2> tree_points;  ///< ends of accepted steps
  bool prefer_sparse = false;
  Heights heights = {};
};

class PassedSampler final : public ob::StateSampler {
 public:
  PassedSampler(const ob::StateSpace* space, Shared* shared) : ob::StateSampler(space), shared_(shared) {}

  void sampleUniform(ob::State* state) override {
    if (shared_->goal && shared_->rng.UniformInt(kGoalEvery) == 0) {
      SetPoint(state, *shared_->goal);
      return;
    }
    Vec2 best = Draw();
    if (shared_->prefer_sparse) {
      double best_gap = Gap(best);
      for (int i = 1; i < kSparseDraws; ++i) {
        const Vec2 other = Draw();
        const double gap = Gap(other);
        if (gap > best_gap) {
          best = other;
          best_gap = gap;
        }
      }
    }
    SetPoint(state, best);
  }
  void sampleUniformNear(ob::State* state, const ob::State*, double) override { sampleUniform(state); }
  void sampleGaussian(ob::State* state, const ob::State*, double) override { sampleUniform(state); }

 private:
  static constexpr int kGoalEvery = 20;
  static constexpr int kSparseDraws = 3;
  static constexpr int kValidTries = 4;

  /// Uniform in the bounds; a few tries for a place where the robot can stand.
  Vec2 Draw() {
    const GroundProblem& problem = shared_->problem;
    Vec2 p = Vec2::Zero();
    for (int i = 0; i < kValidTries; ++i) {
      p = {shared_->rng.Uniform(problem.min.x(), problem.max.x()),
           shared_->rng.Uniform(problem.min.y(), problem.max.y())};
      if (problem.can_stand(p)) break;
    }
    return p;
  }
  double Gap(const Vec2& p) const {
    double gap = std::numeric_limits<double>::infinity();
    for (const Vec2& q : shared_->tree_points) gap = std::min(gap, (q - p).squaredNorm());
    return gap;
  }

  Shared* shared_;
};

class StepValidator final : public ob::MotionValidator {
 public:
  StepValidator(const ob::SpaceInformationPtr& si, Shared* shared)
      : ob::MotionValidator(si), shared_(shared) {}

  bool checkMotion(const ob::State* from, const ob::State* to) const override {
    const Vec2 b = PointOf(to);
    const auto a = shared_->heights.On(PointOf(from));
    if (!a) return false;
    const auto end = shared_->problem.step(*a, b);
    if (!end) return false;
    // A state that other steps have reached, or the goal, may lie on another floor.
    const auto known = shared_->heights.On(b);
    if (known && std::abs(known->z() - end->z()) > mapping::TraversableGround::kSameLevel_m) return false;
    if (!known) shared_->heights.Set(*end);
    if (shared_->prefer_sparse) shared_->tree_points.push_back(b);
    return true;
  }
  bool checkMotion(const ob::State* from, const ob::State* to,
                   std::pair<ob::State*, double>& last) const override {
    last.second = 0.0;
    return checkMotion(from, to);
  }

 private:
  Shared* shared_;
};

class EffortObjective final : public ob::PathLengthOptimizationObjective {
 public:
  EffortObjective(const ob::SpaceInformationPtr& si, const Shared& shared)
      : ob::PathLengthOptimizationObjective(si), shared_(shared) {}
  ob::Cost motionCost(const ob::State* from, const ob::State* to) const override {
    const Vec2 a = PointOf(from), b = PointOf(to);
    const auto on_a = shared_.heights.On(a), on_b = shared_.heights.On(b);
    // Of a state not reached yet: as on the floor of the other one.
    const double height = on_a ? on_a->z() : on_b ? on_b->z() : shared_.problem.start.z();
    return ob::Cost(shared_.problem.effort(on_a.value_or(Vec3(a.x(), a.y(), height)),
                                           on_b.value_or(Vec3(b.x(), b.y(), height))));
  }

 private:
  const Shared& shared_;
};

class NoGoal final : public ob::Goal {
 public:
  explicit NoGoal(const ob::SpaceInformationPtr& si) : ob::Goal(si) {}
  bool isSatisfied(const ob::State*) const override { return false; }
};

ob::SpaceInformationPtr MakeSpace(Shared* shared) {
  auto space = std::make_shared<Space>(2);
  ob::RealVectorBounds bounds(2);
  for (unsigned i = 0; i < 2; ++i) {
    bounds.setLow(i, std::min(shared->problem.min[i], shared->problem.start[i]) - 1e-6);
    bounds.setHigh(i, std::max(shared->problem.max[i], shared->problem.start[i]) + 1e-6);
  }
  space->setBounds(bounds);
  space->setStateSamplerAllocator(
      [shared](const ob::StateSpace* s) { return std::make_shared<PassedSampler>(s, shared); });
  auto si = std::make_shared<ob::SpaceInformation>(space);
  // Steps are validated where they end, and the start is accepted as it is.
  si->setStateValidityChecker([](const ob::State*) { return true; });
  si->setMotionValidator(std::make_shared<StepValidator>(si, shared));
  si->setup();
  return si;
}

ob::ProblemDefinitionPtr MakeDefinition(const ob::SpaceInformationPtr& si, const Vec2& start) {
  auto definition = std::make_shared<ob::ProblemDefinition>(si);
  ob::ScopedState<Space> state(si);
  SetPoint(state.get(), start);
  definition->addStartState(state);
  return definition;
}

/// Vertices in the order in which their parents allow, the start first.
GroundTree TreeOf(const ob::PlannerData& data, const Heights& heights) {
  GroundTree tree;
  if (data.numStartVertices() == 0) return tree;
  std::vector<std::pair<unsigned, int>> queue = {{data.getStartIndex(0), -1}};
  for (size_t next = 0; next < queue.size(); ++next) {
    const auto [vertex, parent] = queue[next];
    tree.points.push_back(heights.On(PointOf(data.getVertex(vertex).getState())).value());
    tree.parent.push_back(parent);
    std::vector<unsigned> children;
    data.getEdges(vertex, children);
    for (const unsigned child : children) queue.emplace_back(child, static_cast<int>(next));
  }
  return tree;
}

}  // namespace

void FollowGroundOf(const Walkable& walkable, GroundProblem* problem) {
  problem->can_stand = [&walkable](const Vec2& p) {
    const auto levels = walkable.ground().LevelsAt(p);
    return std::any_of(levels.begin(), levels.end(), [&](double height) {
      return walkable.CanStand({p.x(), p.y(), height});
    });
  };
  problem->step = [&walkable](const Vec3& from, const Vec2& to) -> std::optional<Vec3> {
    const auto end = walkable.FollowGround(from, to);
    if (!end || !walkable.CanStand(*end) || !walkable.CanStep(from, *end)) return std::nullopt;
    return end;
  };
}

GroundTree GrowRrt(const GroundProblem& problem, int nodes, int max_attempts, core::Rng rng) {
  SeedOnce(rng.seed());
  Shared shared{problem, std::move(rng), std::nullopt, {problem.start.head<2>()}, true};
  shared.heights.Set(problem.start);
  const ob::SpaceInformationPtr si = MakeSpace(&shared);
  const ob::ProblemDefinitionPtr definition = MakeDefinition(si, problem.start.head<2>());
  definition->setGoal(std::make_shared<NoGoal>(si));

  og::RRT rrt(si);
  rrt.setNearestNeighbors<ompl::NearestNeighborsLinear>();
  rrt.setRange(problem.step_m);
  rrt.setProblemDefinition(definition);
  rrt.setup();
  int attempts = 0;
  rrt.solve(ob::PlannerTerminationCondition([&] {
    if (attempts >= max_attempts || shared.tree_points.size() > static_cast<size_t>(nodes)) return true;
    ++attempts;
    return false;
  }));

  ob::PlannerData data(si);
  rrt.getPlannerData(data);
  GroundTree tree = TreeOf(data, shared.heights);
  if (tree.points.empty()) tree = {{problem.start}, {-1}, 0};
  tree.attempts = attempts;
  return tree;
}

std::optional<std::vector<Vec3>> PlanRrtStar(const GroundProblem& problem, const Vec3& goal, int iterations,
                                             core::Rng rng) {
  SeedOnce(rng.seed());
  Shared shared{problem, std::move(rng), goal.head<2>(), {}, false};
  shared.heights.Set(problem.start);
  shared.heights.Set(goal);
  const ob::SpaceInformationPtr si = MakeSpace(&shared);
  const ob::ProblemDefinitionPtr definition = MakeDefinition(si, problem.start.head<2>());
  ob::ScopedState<Space> goal_state(si);
  SetPoint(goal_state.get(), goal.head<2>());
  definition->setGoalState(goal_state, 1e-3);
  definition->setOptimizationObjective(std::make_shared<EffortObjective>(si, shared));

  og::RRTstar planner(si);
  planner.setNearestNeighbors<ompl::NearestNeighborsLinear>();
  planner.setRange(problem.step_m);
  planner.setGoalBias(0.0);
  planner.setDelayCC(true);
  planner.setProblemDefinition(definition);
  planner.setup();
  int count = 0;
  planner.solve(ob::PlannerTerminationCondition([&] { return count++ >= iterations; }));
  if (!definition->hasExactSolution()) return std::nullopt;

  const auto* path = definition->getSolutionPath()->as<og::PathGeometric>();
  std::vector<Vec3> points;
  for (size_t i = 0; i < path->getStateCount(); ++i) {
    points.push_back(shared.heights.On(PointOf(path->getState(i))).value());
  }
  return points;
}

}  // namespace atlas::planner
