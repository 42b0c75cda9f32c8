// A planner of the catalogue, told and asked as a mission does.
#pragma once

#include <fmt/format.h>

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/params.h"
#include "planner/planners/catalog.h"
#include "tests/support/moved_keyframes.h"

namespace atlas::tests {

/// Parameters of one planner by their names, as in YAML.
struct PlannerSettings {
  std::string name = "greedy";
  std::map<std::string, std::string> values;

  template <typename Value>
  void Set(const std::string& key, const Value& value) {
    values[key] = fmt::format("{}", value);
  }
  planner::PlannerConfig Load() const {
    core::ParamSource source;
    source.MergeAssignment("planner.name=" + name);
    for (const auto& [key, value] : values) source.MergeAssignment("planner." + key + "=" + value);
    struct {
      planner::PlannerConfig planner;
      void Visit(core::ParamVisitor& v) { v.Section("planner", &planner); }
    } root;
    source.Load(&root);
    return root.planner;
  }
};

/// A plan, all that decided it, and its outcome in the words of steps.csv.
struct PlanResult : planner::DecisionLog {
  planner::Decision decision;
  std::string outcome;
  std::vector<core::Vec2> path_map;
};

inline std::string OutcomeOf(const planner::Decision& decision) {
  if (std::holds_alternative<planner::GoScan>(decision)) return "view";
  if (const auto* stuck = std::get_if<planner::Stuck>(&decision)) {
    return stuck->reason == planner::Stuck::Reason::kOutOfReach ? "out_of_reach" : "no_candidates";
  }
  switch (std::get<planner::Done>(decision).reason) {
    case planner::Done::Reason::kGainExhausted:
      return "gain_exhausted";
    case planner::Done::Reason::kExplored:
      return "explored";
    case planner::Done::Reason::kSurfaceFlat:
      return "surface_flat";
    case planner::Done::Reason::kRouteDone:
      return "route_done";
    case planner::Done::Reason::kBlockedNarrow:
      return "blocked_narrow";
  }
  return "";
}

/// With keyframes that do not move unless the test moves `poses`.
class PlannerStand {
 public:
  PlannerStand(const PlannerSettings& settings, planner::PlannerSetup setup)
      : PlannerStand(settings.Load(), std::move(setup)) {}
  PlannerStand(const planner::PlannerConfig& config, planner::PlannerSetup setup)
      : planner_(planner::MakePlanner(config, std::move(setup))) {}

  void OnSweep(const core::Pose& T_map_base, size_t new_surface) {
    planner_->OnScan({T_map_base, new_surface}, poses);
  }
  PlanResult Plan(const core::Pose& T_map_base, const mapping::MapView& map,
                  const mapping::TraversableGround& ground) {
    PlanResult result;
    const planner::Belief belief{map, ground, poses, T_map_base, {100, 1e6, 1e6}};
    result.decision = planner_->Plan(belief, &result);
    result.outcome = OutcomeOf(result.decision);
    if (const auto* go = std::get_if<planner::GoScan>(&result.decision)) result.path_map = go->path_map;
    return result;
  }

  MovedKeyframes poses;

 private:
  std::unique_ptr<planner::Planner> planner_;
};

}  // namespace atlas::tests
