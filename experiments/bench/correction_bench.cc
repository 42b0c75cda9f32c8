#include "experiments/bench/correction_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "core/files.h"
#include "core/stopwatch.h"
#include "experiments/bench/bench_dataset.h"
#include "experiments/report/text_table.h"
#include "mapping/backends/catalog.h"
#include "mapping/slam/graph_poses.h"
#include "mapping/slam/pose_graph_slam.h"
#include "mapping/slam/room_graph.h"

namespace atlas::experiments {
namespace {

using core::Pose;

/// The graph's loops but for the last ones, which are handed out one by one.
struct GrowingGraph {
  mapping::PoseGraphSlam slam;
  std::vector<mapping::PoseEdge> to_come;
};

GrowingGraph MakeGraph(const CorrectionBench& bench) {
  constexpr uint32_t kLoopEvery = 5;
  const mapping::RoomGraph rooms =
      mapping::MakeRoomGraph(bench.nodes, kLoopEvery, core::Rng(11).Split("rooms"));
  GrowingGraph grown{mapping::PoseGraphSlam(rooms.graph.T_map_node.front()), {}};
  std::vector<mapping::PoseEdge> loops;
  for (const mapping::PoseEdge& edge : rooms.graph.edges) {
    if (edge.kind == mapping::EdgeKind::kLoop) {
      loops.push_back(edge);
    } else {
      grown.slam.AddNode(edge.T_from_to, edge.information);
    }
  }
  const size_t known = loops.size() - std::min(loops.size(), static_cast<size_t>(bench.corrections));
  for (size_t k = 0; k < known; ++k)
    grown.slam.AddLoop(loops[k].from, loops[k].to, loops[k].T_from_to, loops[k].information);
  grown.slam.Resolve();
  grown.to_come.assign(loops.begin() + static_cast<std::ptrdiff_t>(known), loops.end());
  return grown;
}

std::shared_ptr<const mapping::GraphPoses> PosesOf(const mapping::PoseGraphSlam& slam) {
  auto solved = std::make_shared<const mapping::SolvedGraph>(
      std::make_shared<const mapping::PoseGraph>(slam.InlierGraph()));
  return std::make_shared<const mapping::GraphPoses>(
      slam.T_map_node(), slam.version(), std::move(solved),
      std::vector<mapping::NodeStep>(slam.T_map_node().size()));
}

/// A scan a submap, each at a node of its own.
std::unique_ptr<mapping::Map> MakeAtlas(const CorrectionBench& bench, const mapping::PoseGraphSlam& slam,
                                        const std::function<void(double)>& progress) {
  BenchDataset dataset = RecordBenchDataset("rooms_small", static_cast<int>(bench.submaps), bench.threads,
                                            [&](double share) { progress(0.5 * share); });
  mapping::MapperParams params;
  params.name = "atlas";
  params.resolution_m = 0.065;
  params.integrator.max_range_m = 60.0;
  params.atlas.lambda_odom_m = 1.0;
  auto map = mapping::MakeMap(params, {.lidar = dataset.lidar});
  const auto poses = PosesOf(slam);
  for (size_t k = 0; k < dataset.spins.size(); ++k) {
    const auto node = static_cast<core::KeyframeId>(k * bench.nodes / dataset.spins.size());
    auto spin = std::make_shared<const core::SpinEvent>(std::move(dataset.spins[k]));
    const Pose T_node_map = spin->T_odom_lidar.poses().front().T.inverse();
    map->Integrate({std::move(spin), node, T_node_map}, *poses);
    progress(0.5 + 0.5 * static_cast<double>(k + 1) / static_cast<double>(dataset.spins.size()));
  }
  return map;
}

double GreatestMove(const std::vector<Pose>& before, const std::vector<Pose>& after) {
  double most = 0.0;
  for (size_t k = 0; k < before.size(); ++k)
    most = std::max(most, (before[k].translation() - after[k].translation()).norm());
  return most;
}

CorrectionTimes CorrectOnce(const mapping::PoseEdge& loop, mapping::PoseGraphSlam* slam, mapping::Map* map) {
  CorrectionTimes times;
  const std::vector<Pose> before = slam->T_map_node();
  slam->AddLoop(loop.from, loop.to, loop.T_from_to, loop.information);
  const core::Stopwatch solving;
  slam->Resolve();
  times.solve_ms = 1e3 * solving.seconds();
  const core::Stopwatch applying;
  const auto poses = PosesOf(*slam);
  map->Correct(*poses);
  times.apply_ms = 1e3 * applying.seconds();
  const core::Stopwatch taking;
  const auto snapshot = map->Snapshot();
  times.snapshot_ms = 1e3 * taking.seconds();
  times.moved_m = GreatestMove(before, slam->T_map_node());
  const core::Stopwatch full;
  const mapping::FullPass pass = mapping::SolveFully(slam->graph());
  times.full_ms = 1e3 * full.seconds();
  return times;
}

TextTable CorrectionTableOf(const CorrectionResult& result) {
  TextTable table{
      {"correction", "solve ms", "apply ms", "snapshot ms", "until planning ms", "moved m", "full pass ms"},
      std::vector<bool>(7, false),
      {},
      {}};
  const auto add = [&](const std::string& name, const CorrectionTimes& t) {
    table.rows.push_back({name, fmt::format("{:.1f}", t.solve_ms), fmt::format("{:.2f}", t.apply_ms),
                          fmt::format("{:.1f}", t.snapshot_ms), fmt::format("{:.1f}", t.until_planning_ms()),
                          fmt::format("{:.3f}", t.moved_m), fmt::format("{:.0f}", t.full_ms)});
  };
  for (size_t k = 0; k < result.corrections.size(); ++k) add(std::to_string(k + 1), result.corrections[k]);
  std::vector<CorrectionTimes> sorted = result.corrections;
  std::sort(sorted.begin(), sorted.end(), [](const CorrectionTimes& a, const CorrectionTimes& b) {
    return a.until_planning_ms() < b.until_planning_ms();
  });
  if (!sorted.empty()) {
    table.rules_before.push_back(table.rows.size());
    add("median", sorted[sorted.size() / 2]);
    add("slowest", sorted.back());
  }
  table.notes = {
      fmt::format("{} nodes, {} loops, {} submaps of {:.0f} MB together. Aim: 250 ms until planning.",
                  result.nodes, result.loops, result.submaps, 1e-6 * static_cast<double>(result.map_bytes))};
  return table;
}

}  // namespace

CorrectionResult RunCorrectionBench(const CorrectionBench& bench,
                                    const std::function<void(double)>& progress) {
  GrowingGraph graph = MakeGraph(bench);
  const std::unique_ptr<mapping::Map> map = MakeAtlas(bench, graph.slam, progress);
  map->Snapshot();  // what the first one alone costs is not a correction's
  CorrectionResult result;
  for (const mapping::PoseEdge& loop : graph.to_come)
    result.corrections.push_back(CorrectOnce(loop, &graph.slam, map.get()));
  result.nodes = graph.slam.graph().size();
  result.loops = graph.slam.graph().edges.size() + 1 - result.nodes;
  result.submaps = map->SubmapCount();
  result.map_bytes = map->Bytes();
  return result;
}

std::string CorrectionTable(const CorrectionResult& result) {
  return ToTerminal(CorrectionTableOf(result));
}

void WriteCorrectionBench(const std::filesystem::path& folder, const CorrectionResult& result) {
  core::WriteFileAtomically(folder / "correction.md", ToMarkdown(CorrectionTableOf(result)));
  core::WriteFileAtomically(folder / "correction.csv", ToCsv(CorrectionTableOf(result)));
}

}  // namespace atlas::experiments
