// Pose graphs with false loops: which loop edges to believe, and the least-squares solution of the others.
// Odometry edges are always believed.
#pragma once

#include <vector>

#include "mapping/slam/graph_solver.h"

namespace atlas::mapping {

struct RobustOptions {
  double dcs_phi = 6.0;  ///< Phi of dynamic covariance scaling
  /// Squared error from which a loop is false. 99 % of true loops lie below: chi-square of 6 degrees of
  /// freedom; 11.34 with the plane's 3.
  double chi2_cut = 16.81, planar_chi2_cut = 11.34;
  int threads = 1;

  double CutOf(const PoseGraph& graph) const { return graph.planar ? planar_chi2_cut : chi2_cut; }
};

struct RobustReport {
  std::vector<size_t> rejected;  ///< indices of loop edges, ascending
  SolveReport solve;             ///< the last solve; its time is that of all
};

/// From the graph's poses by dynamic covariance scaling: fast, for each new loop. False loops keep a small
/// pull.
RobustReport SolveDcs(PoseGraph* graph, const RobustOptions& options = {});

/// For loops that are far from closed, which DCS alone would leave so: by Cauchy's loss, which still pulls at
/// them, then by DCS.
RobustReport SolveWide(PoseGraph* graph, const RobustOptions& options = {});

/// SolveWide from the best of several starts: the graph's poses, odometry's and those of chordal
/// initialisation.
RobustReport SolveFromBestStart(PoseGraph* graph, const RobustOptions& options = {});

/// Graduated non-convexity with truncated least squares (Yang et al., RA-L 2020) from the best
/// start; then false loops are removed and the others solved by least squares.
/// @pre the odometry edges connect the graph.
RobustReport SolveGnc(PoseGraph* graph, const RobustOptions& options = {});

/// sum of odometry's squared errors and of min(squared error, cut) of loops: what GNC-TLS minimises.
double TruncatedCost(const PoseGraph& graph, double cut);

/// Loop edges whose squared error is above `cut`, ascending.
std::vector<size_t> LoopsAbove(const PoseGraph& graph, double cut);

}  // namespace atlas::mapping
