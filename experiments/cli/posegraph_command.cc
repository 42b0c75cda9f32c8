#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "core/errors.h"
#include "core/temporary_file.h"
#include "experiments/cli/map_commands.h"
#include "experiments/cli/progress_bar.h"
#include "experiments/report/text_table.h"
#include "mapping/io/recorded_poses.h"
#include "mapping/slam/chordal_start.h"
#include "mapping/slam/g2o_file.h"
#include "mapping/slam/robust_graph.h"
#include "mapping/slam/trajectory_error.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;
using mapping::CostConvention;
using mapping::G2oGraph;
using mapping::PoseGraph;
using mapping::SolveReport;

/// A graph minimised by one convention of cost.
struct Minimum {
  CostConvention cost;
  std::string name, doc;
  double initial = 0.0, start = 0.0;  ///< of the file's poses, of those it was minimised from
  PoseGraph graph = {};
  SolveReport report = {};
};

void Minimise(const PoseGraph& file, std::vector<PoseGraph> starts, Minimum* minimum) {
  const auto cost = [&](const PoseGraph& graph) { return mapping::CostOf(graph, minimum->cost); };
  minimum->initial = cost(file);
  minimum->graph = *std::min_element(starts.begin(), starts.end(),
                                     [&](const auto& a, const auto& b) { return cost(a) < cost(b); });
  minimum->start = cost(minimum->graph);
  minimum->report = mapping::Optimise(&minimum->graph, mapping::OptionsFor(minimum->cost));
}

/// The three conventions, each minimised for itself: the minimum of one is none of another, so that none
/// could be compared with its published optimum otherwise.
std::vector<Minimum> MinimiseAll(const PoseGraph& graph, ProgressBar* bar) {
  std::vector<Minimum> minima = {{CostConvention::kLogMap, "log", "log-map, with 1/2"},
                                 {CostConvention::kChordal, "chordal", "chordal isotropic, without 1/2"},
                                 {CostConvention::kG2o, "g2o", "chi2 of g2o, without 1/2"}};
  PoseGraph chordal = graph;
  chordal.T_map_node = mapping::ChordalStart(graph);
  std::vector<PoseGraph> starts = {graph, chordal};
  for (size_t k = 0; k < minima.size(); ++k) {
    bar->Show(1 + k, minima[k].name);
    Minimise(graph, starts, &minima[k]);
    if (k == 0) starts.push_back(minima[k].graph);
  }
  return minima;
}

std::string Cost(double cost) {
  return fmt::format("{:.8g}", cost);
}

TextTable CostTable(const std::vector<Minimum>& minima, bool has_poses) {
  TextTable table;
  table.heading = {"cost", "initial", "start", "final", "iterations", "time", ""};
  table.left = {true, false, false, false, false, false, true};
  for (const Minimum& m : minima) {
    const std::string ending = m.report.failed      ? "failed: the start is kept"
                               : m.report.converged ? "converged"
                                                    : "not converged";
    table.rows.push_back({m.doc, has_poses ? Cost(m.initial) : "-", Cost(m.start),
                          Cost(mapping::CostOf(m.graph, m.cost)), std::to_string(m.report.iterations),
                          fmt::format("{:.2f} s", m.report.time_s), ending});
  }
  return table;
}

std::string Described(const G2oGraph& file) {
  size_t loops = 0;
  for (const auto& edge : file.graph.edges) loops += edge.kind == mapping::EdgeKind::kLoop;
  std::string text = fmt::format("{} nodes, {} edges ({} odometry, {} loops) in {}", file.graph.size(),
                                 file.graph.edges.size(), file.graph.edges.size() - loops, loops,
                                 file.graph.planar ? "the plane" : "space");
  if (!file.has_poses) text += "; no vertices, so poses come from the edges";
  if (file.skipped > 0)
    text += fmt::format("; {} lines of unknown tags skipped ({})", file.skipped, file.first_skipped);
  if (file.without_cross_terms > 0) {
    text += fmt::format(
        "; {} edges without terms between translation and rotation, with which their "
        "information is indefinite",
        file.without_cross_terms);
  }
  return text;
}

/// Where the true nodes are: those of a graph by id, those of a trajectory by order.
std::vector<core::Pose> TruthFor(const G2oGraph& file, const fs::path& path) {
  if (path.extension() != ".g2o") {
    mapping::RecordedPoses poses = mapping::ReadPoses(path);
    if (poses.size() != file.id.size())
      throw core::InputError(
          fmt::format("{}: {} poses, the graph has {} nodes", path.string(), poses.size(), file.id.size()));
    return std::move(poses.T_map_lidar);
  }
  const mapping::G2oGraph truth = mapping::ReadG2oVertices(path);
  std::vector<core::Pose> T_map_node;
  for (const int64_t id : file.id) {
    const auto found = std::lower_bound(truth.id.begin(), truth.id.end(), id);
    if (found == truth.id.end() || *found != id)
      throw core::InputError(fmt::format("{}: has no vertex {}, a node of the graph", path.string(), id));
    T_map_node.push_back(truth.graph.T_map_node[static_cast<size_t>(found - truth.id.begin())]);
  }
  return T_map_node;
}

/// Takes the loops out that are false, and leaves the poses that this found. Returns how many.
size_t RemoveFalseLoops(const std::string& method, PoseGraph* graph, double* time_s) {
  if (method == "none") return 0;
  const mapping::RobustReport report =
      method == "dcs" ? mapping::SolveFromBestStart(graph) : mapping::SolveGnc(graph);
  *time_s = report.solve.time_s;
  *graph = mapping::WithoutEdges(*graph, report.rejected);
  return report.rejected.size();
}

}  // namespace

int PoseGraphCommand(const PoseGraphArguments& arguments) {
  ProgressBar bar("posegraph", 4);
  bar.Show(0, "reading " + arguments.graph.string());
  G2oGraph file = mapping::ReadG2o(arguments.graph);
  const std::vector<core::Pose> truth =
      arguments.truth.empty() ? std::vector<core::Pose>{} : TruthFor(file, arguments.truth);
  const std::string described = Described(file);
  double robust_time_s = 0.0;
  const size_t edges = file.graph.edges.size();
  const size_t rejected = RemoveFalseLoops(arguments.robust, &file.graph, &robust_time_s);
  const std::vector<Minimum> minima = MinimiseAll(file.graph, &bar);
  bar.Finish(described);
  std::cout << ToTerminal(CostTable(minima, file.has_poses));
  std::cout << fmt::format("edges rejected: {} of {} ({})\n", rejected, edges,
                           arguments.robust == "none"
                               ? "none was asked for: --robust dcs or gnc"
                               : fmt::format("{}, {:.2f} s", arguments.robust, robust_time_s));

  const auto chosen =
      std::find_if(minima.begin(), minima.end(), [&](const Minimum& m) { return m.name == arguments.cost; });
  file.graph = chosen->graph;
  if (!truth.empty()) {
    std::cout << fmt::format("ATE after rigid alignment: {:.6g} m (the minimum of {})\n",
                             mapping::AbsoluteTrajectoryError(file.graph.T_map_node, truth), chosen->doc);
  }
  if (!arguments.out.empty()) {
    core::RemoveStaleTemporaries(arguments.out.parent_path());
    mapping::WriteG2o(arguments.out, file);
    std::cout << fmt::format("{}: the minimum of {}\n", arguments.out.string(), chosen->doc);
  }
  return chosen->report.failed ? 1 : 0;
}

}  // namespace atlas::experiments
