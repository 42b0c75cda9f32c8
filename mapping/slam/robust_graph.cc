#include "mapping/slam/robust_graph.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/stopwatch.h"
#include "mapping/slam/chordal_start.h"

namespace atlas::mapping {
namespace {

using core::Pose;

/// Growth of mu from step to step (Yang et al., RA-L 2020).
constexpr double kGncGrowth = 1.4;
/// mu begins no lower: at 1e-4 an error of 100 cuts still weighs a thousandth.
constexpr double kLeastGncMu = 1e-4;
/// Once mu is this, weights between 0 and 1 need errors within 1 % of the cut.
constexpr double kGreatestGncMu = 100.0;
constexpr double kNegligibleWeight = 1e-6;
constexpr int kPolishRounds = 5;
constexpr double kRoughTolerance = 1e-4, kOnlineTolerance = 1e-6;

std::vector<double> SquaredErrors(const PoseGraph& graph) {
  std::vector<double> chi2;
  chi2.reserve(graph.edges.size());
  for (const PoseEdge& edge : graph.edges)
    chi2.push_back(SquaredError(edge, graph.T_map_node[edge.from], graph.T_map_node[edge.to]));
  return chi2;
}

/// The weight that minimises w chi2 + mu (1 - w) / (mu + w) cut, the surrogate of truncated least squares.
double GncWeight(double chi2, double mu, double cut) {
  if (chi2 <= mu / (mu + 1.0) * cut) return 1.0;
  if (chi2 >= (mu + 1.0) / mu * cut) return 0.0;
  const double weight = std::sqrt(cut * mu * (mu + 1.0) / chi2) - mu;
  return weight > kNegligibleWeight ? std::min(weight, 1.0) : 0.0;
}

std::vector<double> GncWeights(const PoseGraph& graph, double mu, double cut) {
  std::vector<double> weights = SquaredErrors(graph);
  for (size_t k = 0; k < weights.size(); ++k)
    weights[k] = graph.edges[k].kind == EdgeKind::kLoop ? GncWeight(weights[k], mu, cut) : 1.0;
  return weights;
}

/// mu at which the surrogate is convex where the loops' errors are now.
double FirstMu(const PoseGraph& graph, double cut) {
  const std::vector<double> chi2 = SquaredErrors(graph);
  double largest = 0.0;
  for (size_t k = 0; k < chi2.size(); ++k) {
    if (graph.edges[k].kind == EdgeKind::kLoop) largest = std::max(largest, chi2[k]);
  }
  return largest > cut ? std::max(cut / (2.0 * largest - cut), kLeastGncMu) : kGreatestGncMu;
}

SolveReport OptimiseBy(LoopLoss loss, double function_tolerance, const RobustOptions& options,
                       PoseGraph* graph) {
  SolveOptions solve;
  solve.function_tolerance = function_tolerance;
  solve.threads = options.threads;
  solve.loop_loss = loss;
  solve.loop_scale = options.dcs_phi;
  return Optimise(graph, solve);
}

/// Among poses as they are, odometry's and those of chordal initialisation, the ones that lead to the lowest
/// truncated cost.
void TakeBestStart(PoseGraph* graph, const RobustOptions& options) {
  double best = std::numeric_limits<double>::infinity();
  std::vector<Pose> best_poses = graph->T_map_node;
  for (const std::vector<Pose>& start : {graph->T_map_node, ChainedPoses(*graph), ChordalStart(*graph)}) {
    PoseGraph trial = *graph;
    trial.T_map_node = start;
    OptimiseBy(LoopLoss::kCauchy, kRoughTolerance, options, &trial);
    OptimiseBy(LoopLoss::kDcs, kRoughTolerance, options, &trial);
    const double cost = TruncatedCost(trial, options.CutOf(trial));
    if (!(cost < best)) continue;
    best = cost;
    best_poses = trial.T_map_node;
  }
  graph->T_map_node = std::move(best_poses);
}

void GraduateNonConvexity(PoseGraph* graph, const RobustOptions& options) {
  const double cut = options.CutOf(*graph);
  SolveOptions solve{.max_iterations = 5, .function_tolerance = 1e-4, .threads = options.threads};
  for (double mu = FirstMu(*graph, cut); mu < kGreatestGncMu; mu *= kGncGrowth) {
    solve.edge_weights = GncWeights(*graph, mu, cut);
    const auto undecided = [](double w) { return w > 0.0 && w < 1.0; };
    const bool decided = std::none_of(solve.edge_weights.begin(), solve.edge_weights.end(), undecided);
    Optimise(graph, solve);
    if (decided) return;
  }
}

/// Least squares without the loops above the cut, until the same ones are.
RobustReport Polish(PoseGraph* graph, const RobustOptions& options) {
  RobustReport report{LoopsAbove(*graph, options.CutOf(*graph)), {}};
  for (int round = 0; round < kPolishRounds; ++round) {
    PoseGraph kept = WithoutEdges(*graph, report.rejected);
    report.solve = Optimise(&kept, {.threads = options.threads});
    graph->T_map_node = kept.T_map_node;
    std::vector<size_t> above = LoopsAbove(*graph, options.CutOf(*graph));
    if (above == report.rejected || round + 1 == kPolishRounds) return report;
    report.rejected = std::move(above);
  }
  return report;
}

}  // namespace

double TruncatedCost(const PoseGraph& graph, double cut) {
  const std::vector<double> chi2 = SquaredErrors(graph);
  double sum = 0.0;
  for (size_t k = 0; k < chi2.size(); ++k)
    sum += graph.edges[k].kind == EdgeKind::kLoop ? std::min(chi2[k], cut) : chi2[k];
  return sum;
}

std::vector<size_t> LoopsAbove(const PoseGraph& graph, double cut) {
  const std::vector<double> chi2 = SquaredErrors(graph);
  std::vector<size_t> above;
  for (size_t k = 0; k < chi2.size(); ++k) {
    if (graph.edges[k].kind == EdgeKind::kLoop && !(chi2[k] <= cut)) above.push_back(k);
  }
  return above;
}

RobustReport SolveDcs(PoseGraph* graph, const RobustOptions& options) {
  RobustReport report;
  report.solve = OptimiseBy(LoopLoss::kDcs, kOnlineTolerance, options, graph);
  report.rejected = LoopsAbove(*graph, options.CutOf(*graph));
  return report;
}

RobustReport SolveWide(PoseGraph* graph, const RobustOptions& options) {
  OptimiseBy(LoopLoss::kCauchy, kRoughTolerance, options, graph);
  return SolveDcs(graph, options);
}

RobustReport SolveFromBestStart(PoseGraph* graph, const RobustOptions& options) {
  const core::Stopwatch watch;
  TakeBestStart(graph, options);
  RobustReport report = SolveDcs(graph, options);
  report.solve.time_s = watch.seconds();
  return report;
}

RobustReport SolveGnc(PoseGraph* graph, const RobustOptions& options) {
  const core::Stopwatch watch;
  TakeBestStart(graph, options);
  GraduateNonConvexity(graph, options);
  RobustReport report = Polish(graph, options);
  report.solve.time_s = watch.seconds();
  return report;
}

}  // namespace atlas::mapping
