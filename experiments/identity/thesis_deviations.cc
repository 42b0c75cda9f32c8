#include "experiments/identity/thesis_deviations.h"

#include <fmt/format.h>

#include "planner/planners/thesis.h"

namespace atlas::experiments {
namespace {

/// What the thesis's map was (3.3, 3.4.2, 3.6.2).
void CompareMap(const ExperimentConfig& config, std::vector<std::string>* out) {
  const mapping::MapperParams& mapper = config.mapper;
  if (mapper.name != "octomap") out->push_back(fmt::format("map by {} (OctoMap)", mapper.name));
  if (mapper.resolution_m != 0.05) out->push_back(fmt::format("voxels of {} m (0.05)", mapper.resolution_m));
  if (mapper.integrator.void_rays != "ignore") out->emplace_back("void rays clear space (they tell nothing)");
  if (config.mission.map_while_walking) out->emplace_back("the map also takes the walk (sweeps alone)");
  out->emplace_back(
      "the map is updated by each revolution, each ray from its own pose (by one filtered cloud a sweep, "
      "from one "
      "pose)");
}

/// Candidates and costs (3.4.2, 3.5, 3.6.2, 3.6.3).
void ComparePlanner(const planner::ThesisParams& planner, std::vector<std::string>* out) {
  const planner::ViewParams& views = planner.nbv.views;
  const planner::CostParams& costs = planner.nbv.costs;
  const bool as_simulated = views.window_m == 12.0 && views.nodes == 150;
  const bool as_real = views.window_m == 7.0 && views.nodes == 75;
  if (!as_simulated && !as_real) {
    out->emplace_back(
        fmt::format("{} nodes in {} m (150 in 12 m; outdoors 75 in 7 m)", views.nodes, views.window_m));
  }
  if (costs.visited_threshold_m != costs.too_close_threshold_m || !costs.visited_cost ||
      !costs.too_close_cost) {
    out->emplace_back("visited and too close cost apart (one d_thres)");
  }
  if (costs.traversal != "discrete") out->emplace_back("continuous traversal cost (safe or not)");
}

/// What the thesis leaves open.
void NameChoices(const ExperimentConfig& config, const planner::ThesisParams& planner,
                 std::vector<std::string>* out) {
  const planner::CostParams& costs = planner.nbv.costs;
  out->emplace_back(fmt::format("at most {} scans (until Eq. 3.8 holds)", config.mission.max_scans));
  out->emplace_back(
      fmt::format("chosen where the thesis gives no value: u_thres {} nats, d_thres {} m, {} for views "
                  "behind, {} headings a "
                  "node, {} rays a view through the object box as the sweep sends them",
                  planner.stop_utility, costs.visited_threshold_m, costs.behind_penalty,
                  planner.nbv.views.headings, planner.nbv.views.rays));
  out->emplace_back(
      "where no ground about it looks walkable the robot goes back, turns, then steps aside (not said)");
}

}  // namespace

std::vector<std::string> DeviationsFromThesis(const ExperimentConfig& config) {
  std::vector<std::string> deviations;
  const auto* thesis = dynamic_cast<const planner::ThesisParams*>(config.planner.own.get());
  if (thesis == nullptr) return deviations;
  CompareMap(config, &deviations);
  ComparePlanner(*thesis, &deviations);
  NameChoices(config, *thesis, &deviations);
  return deviations;
}

}  // namespace atlas::experiments
