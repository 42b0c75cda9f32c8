// Nonlinear least squares on pose graphs: Levenberg-Marquardt with sparse Cholesky (Ceres, SuiteSparse).
#pragma once

#include <string>
#include <vector>

#include "mapping/slam/pose_graph.h"

namespace atlas::mapping {

enum class CostConvention { kLogMap, kChordal, kG2o };  ///< see pose_graph.h

/// What loop edges cost.
enum class LoopLoss {
  kSquared,
  kCauchy,  ///< c^2 log(1 + s / c^2): far errors still pull, as 1 / e
  kDcs,     ///< dynamic covariance scaling (Agarwal et al., ICRA 2013): far errors hardly pull, as 1 / e^3
};

struct SolveOptions {
  CostConvention cost = CostConvention::kLogMap;
  int max_iterations = 200;
  /// Ends where an iteration lowers the cost by less than this share of it.
  double function_tolerance = 1e-10;
  int threads = 1;
  LoopLoss loop_loss = LoopLoss::kSquared;
  double loop_scale = 6.0;  ///< squared error at which the loss departs from the square: Phi, c^2
  /// Of each edge's squared error; empty: all one. Edges of weight zero are left out.
  std::vector<double> edge_weights = {};
};

struct SolveReport {
  double initial_cost = 0.0, final_cost = 0.0;  ///< as minimised: weighted, with the robust loss
  int iterations = 0;
  double time_s = 0.0;
  bool converged = false;
  /// Nothing was found that is better than the start, which the graph then still holds.
  bool failed = false;
  std::string message;  ///< one line on how it ended
};

/// Chordal problems converge linearly where residuals are large, so they end sooner.
SolveOptions OptionsFor(CostConvention cost);

/// The cost of `graph` by a convention, without any robust loss.
double CostOf(const PoseGraph& graph, CostConvention cost);

/// Minimises the cost of `graph` from its poses; the same bytes for the same input. Fixed nodes stay. The
/// poses are finite whatever happens.
/// @pre information matrices are positive definite; edges name nodes of the graph.
SolveReport Optimise(PoseGraph* graph, const SolveOptions& options = {});

}  // namespace atlas::mapping
