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

#include <mutex>

namespace atlas::planner {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;
using core::Vec2;

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

/// Shared by a planner's sampler and motion validator.
struct Shared {
  const PlanarProblem& problem;
  core::Rng rng;
  std::optional<Vec2> goal;       ///< sampled now and then
  std::vector<Vec2> tree_points;  ///< ends of accepted steps
  bool prefer_sparse = false;
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
    const PlanarProblem& problem = shared_->problem;
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
    const Vec2 a = PointOf(from), b = PointOf(to);
    if (!shared_->problem.can_stand(b) || !shared_->problem.can_step(a, b)) return false;
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
  EffortObjective(const ob::SpaceInformationPtr& si, const PlanarProblem& problem)
      : ob::PathLengthOptimizationObjective(si), problem_(problem) {}
  ob::Cost motionCost(const ob::State* a, const ob::State* b) const override {
    return ob::Cost(problem_.effort(PointOf(a), PointOf(b)));
  }

 private:
  const PlanarProblem& problem_;
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
PlanarTree TreeOf(const ob::PlannerData& data) {
  PlanarTree tree;
  if (data.numStartVertices() == 0) return tree;
  std::vector<std::pair<unsigned, int>> queue = {{data.getStartIndex(0), -1}};
  for (size_t next = 0; next < queue.size(); ++next) {
    const auto [vertex, parent] = queue[next];
    tree.points.push_back(PointOf(data.getVertex(vertex).getState()));
    tree.parent.push_back(parent);
    std::vector<unsigned> children;
    data.getEdges(vertex, children);
    for (const unsigned child : children) queue.emplace_back(child, static_cast<int>(next));
  }
  return tree;
}

}  // namespace

PlanarTree GrowRrt(const PlanarProblem& problem, int nodes, int max_attempts, core::Rng rng) {
  SeedOnce(rng.seed());
  Shared shared{problem, std::move(rng), std::nullopt, {problem.start}, true};
  const ob::SpaceInformationPtr si = MakeSpace(&shared);
  const ob::ProblemDefinitionPtr definition = MakeDefinition(si, problem.start);
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
  PlanarTree tree = TreeOf(data);
  if (tree.points.empty()) tree = {{problem.start}, {-1}, 0};
  tree.attempts = attempts;
  return tree;
}

std::optional<std::vector<Vec2>> PlanRrtStar(const PlanarProblem& problem, const Vec2& goal, int iterations,
                                             core::Rng rng) {
  SeedOnce(rng.seed());
  Shared shared{problem, std::move(rng), goal, {}, false};
  const ob::SpaceInformationPtr si = MakeSpace(&shared);
  const ob::ProblemDefinitionPtr definition = MakeDefinition(si, problem.start);
  ob::ScopedState<Space> goal_state(si);
  SetPoint(goal_state.get(), goal);
  definition->setGoalState(goal_state, 1e-3);
  definition->setOptimizationObjective(std::make_shared<EffortObjective>(si, problem));

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
  std::vector<Vec2> points;
  for (size_t i = 0; i < path->getStateCount(); ++i) points.push_back(PointOf(path->getState(i)));
  return points;
}

}  // namespace atlas::planner
