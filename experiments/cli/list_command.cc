#include <fmt/format.h>

#include <iostream>

#include "core/errors.h"
#include "experiments/cli/commands.h"
#include "experiments/experiment_config.h"
#include "experiments/metrics/run_summary.h"
#include "mapping/mapper.h"
#include "planner/gain/gain.h"
#include "planner/nbv_planner.h"
#include "robots/robot_spec.h"
#include "scenes/catalog.h"

namespace atlas::experiments {
namespace {

template <typename Entries>
void PrintEntries(const Entries& entries) {
  size_t width = 0;
  for (const auto& entry : entries) width = std::max(width, entry.name.size());
  for (const auto& entry : entries) std::cout << fmt::format("{:<{}}  {}\n", entry.name, width, entry.doc);
}

void PrintScenes(bool verbose) {
  if (!verbose) return PrintEntries(scenes::Catalog());
  for (const auto& entry : scenes::Catalog()) {
    const scenes::SceneSpec scene = entry.build();
    const scenes::GroundTruth truth = scenes::SampleGroundTruth(scene, scene.truth_spacing_m);
    size_t triangles = 0, shapes = 0;
    for (const auto& part : scene.parts) {
      triangles += part.mesh.triangles.size();
      shapes += part.collision.size();
    }
    const core::Vec3 size = scene.object_box.Size();
    std::cout << fmt::format(
        "{}: {}\n  object box {:.1f} x {:.1f} x {:.1f} m, {} triangles, {} collision shapes\n", entry.name,
        entry.doc, size.x(), size.y(), size.z(), triangles, shapes);
    double total = 0.0;
    for (size_t i = 0; i < truth.part_names.size(); ++i) {
      std::cout << fmt::format("  {:<28} {:8.2f} m2\n", truth.part_names[i], truth.part_area_m2[i]);
      total += truth.part_area_m2[i];
    }
    std::cout << fmt::format("  {:<28} {:8.2f} m2 in {} truth points\n\n", "exposed surface", total,
                             truth.points.size());
  }
}

void PrintMetrics() {
#define X(key) std::cout << #key << "\n";
  ATLAS_SUMMARY_NUMBERS(X)
#undef X
}

}  // namespace

int ListCommand(const std::string& what, bool verbose) {
  if (what == "scenes") {
    PrintScenes(verbose);
  } else if (what == "robots") {
    PrintEntries(robots::Catalog());
  } else if (what == "gains") {
    PrintEntries(planner::GainCatalog());
  } else if (what == "mappers") {
    PrintEntries(mapping::Catalog());
  } else if (what == "planners") {
    PrintEntries(planner::PlannerCatalog());
  } else if (what == "experiments") {
    PrintEntries(ListExperiments());
  } else if (what == "metrics") {
    PrintMetrics();
  } else {
    throw core::InputError(core::UnknownName(
        "list", what, {"scenes", "robots", "gains", "mappers", "planners", "experiments", "metrics"}));
  }
  return 0;
}

int ExplainCommand(const std::string& experiment, const std::vector<std::string>& assignments) {
  const ExperimentConfig config = LoadExperiment(experiment, assignments);
  size_t path_width = 0, value_width = 0, range_width = 0;
  for (const core::ParamRow& row : config.rows) {
    path_width = std::max(path_width, row.path.size());
    value_width = std::max(value_width, row.value.size() + row.unit.size() + 1);
    range_width = std::max(range_width, std::min<size_t>(row.range.size(), 32));
  }
  for (const core::ParamRow& row : config.rows) {
    std::cout << fmt::format("{:<{}}  {:<{}}  {:<{}}  {} ({})\n", row.path, path_width,
                             row.value + " " + row.unit, value_width, row.range, range_width, row.doc,
                             row.origin);
  }
  return 0;
}

}  // namespace atlas::experiments
