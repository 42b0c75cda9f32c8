// Planners by name, and the section `planner` of an experiment.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "planner/planners/planner_params.h"

namespace atlas::planner {

const std::vector<PlannerEntry>& PlannerCatalog();

/// Which planner, its own parameters, and those of the terrain map that it plans on.
struct PlannerConfig {
  /// @throws InputError for an unknown name.
  explicit PlannerConfig(const std::string& kind = "greedy");
  PlannerConfig(const PlannerConfig& other);
  PlannerConfig& operator=(const PlannerConfig& other);
  PlannerConfig(PlannerConfig&&) noexcept = default;
  PlannerConfig& operator=(PlannerConfig&&) noexcept = default;

  std::string name;
  std::unique_ptr<PlannerParams> own;  ///< never null; of the planner `name`
  mapping::TerrainParams terrain;
  /// A visitor that sets the name gets that planner's defaults to set further.
  void Visit(core::ParamVisitor& v);
};

/// @throws InputError for parameters that make no planner.
std::unique_ptr<Planner> MakePlanner(const PlannerConfig& config, PlannerSetup setup);

}  // namespace atlas::planner
