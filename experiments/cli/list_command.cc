#include <fmt/format.h>

#include <iostream>

#include "core/errors.h"
#include "core/files.h"
#include "core/labels.h"
#include "core/lidar_model.h"
#include "experiments/bench/false_loops_sweep.h"
#include "experiments/cli/commands.h"
#include "experiments/identity/experiment_config.h"
#include "experiments/judge/metric.h"
#include "experiments/sweep/sweep_spec.h"
#include "mapping/backends/catalog.h"
#include "planner/gain/gain.h"
#include "planner/planners/catalog.h"
#include "robots/robot_spec.h"
#include "scenes/catalog.h"

namespace atlas::experiments {
namespace {

struct Entry {
  std::string name, doc;
};

template <typename Entries>
std::vector<Entry> EntriesOf(const Entries& catalogue) {
  std::vector<Entry> entries;
  for (const auto& entry : catalogue) entries.push_back({entry.name, entry.doc});
  return entries;
}

std::vector<Entry> Metrics() {
  std::vector<Entry> entries;
  for (const core::Column& column : SummaryColumns()) {
    const std::string unit = column.unit.empty() ? "" : " [" + column.unit + "]";
    entries.push_back({column.name, column.meaning + unit});
  }
  return entries;
}

std::vector<Entry> Sweeps() {
  std::vector<Entry> entries;
  for (const std::string& name : SweepNames()) entries.push_back({name, LoadSweep(name).doc});
  entries.push_back({kFalseLoopSweep, kFalseLoopSweepDoc});
  return entries;
}

std::vector<Entry> Lidars() {
  std::vector<Entry> entries;
  for (const std::string& name : core::LidarModelNames()) {
    const core::LidarModel m = core::FindLidarModel(name);
    entries.push_back(
        {name,
         fmt::format("{} beams from {:.1f} to {:.1f} deg, {} columns, {:.1f} to {:.0f} m, "
                     "range noise {:.0f} mm",
                     m.rows(), core::Degrees(m.elevation_rad.back()), core::Degrees(m.elevation_rad.front()),
                     m.columns, m.min_range_m, m.max_range_m, 1000.0 * m.range_sigma_m)});
  }
  return entries;
}

std::vector<Entry> Labels() {
  std::vector<Entry> entries;
  for (size_t i = 0; i < core::kLabelCount; ++i) {
    const core::LabelInfo& info = core::InfoOf(static_cast<core::Label>(i));
    entries.push_back(
        {std::string(info.name), fmt::format("#{:02x}{:02x}{:02x}", info.rgb[0], info.rgb[1], info.rgb[2])});
  }
  return entries;
}

struct Kind {
  std::string name, doc;
  std::vector<Entry> (*entries)();
};

const std::vector<Kind>& Kinds() {
  static const std::vector<Kind> kinds = {
      {"experiments", "what atlas run takes", [] { return EntriesOf(ListExperiments()); }},
      {"sweeps", "what atlas sweep takes", Sweeps},
      {"scenes", "--set scene=NAME, atlas record", [] { return EntriesOf(scenes::Catalog()); }},
      {"robots", "--set robot=NAME", [] { return EntriesOf(robots::Catalog()); }},
      {"lidars", "--set sensors.lidar=NAME, atlas record --lidar", Lidars},
      {"mappers", "--set mapper=NAME", [] { return EntriesOf(mapping::Catalog()); }},
      {"localisers", "--set localisation=NAME", [] { return EntriesOf(mapping::LocaliserCatalog()); }},
      {"planners", "--set planner=NAME", [] { return EntriesOf(planner::PlannerCatalog()); }},
      {"gains", "--set planner.gain=NAME", [] { return EntriesOf(planner::GainCatalog()); }},
      {"routes", "ways through scenes, of atlas record",
       [] { return EntriesOf(ListYaml(core::InstalledFile("scenes/routes"))); }},
      {"labels", "what parts of a scene file may be", Labels},
      {"metrics", "numbers in summary.json", Metrics}};
  return kinds;
}

void Print(const std::vector<Entry>& entries) {
  size_t width = 0;
  for (const Entry& entry : entries) width = std::max(width, entry.name.size());
  for (const Entry& entry : entries) {
    std::cout << (entry.doc.empty() ? entry.name : fmt::format("{:<{}}  {}", entry.name, width, entry.doc))
              << "\n";
  }
}

void PrintSceneAreas() {
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

const Kind& FindKind(const std::string& name) {
  for (const Kind& kind : Kinds()) {
    if (kind.name == name) return kind;
  }
  throw core::InputError(core::UnknownName("kind", name, ListKinds()));
}

}  // namespace

std::vector<std::string> ListKinds() {
  std::vector<std::string> names;
  for (const Kind& kind : Kinds()) names.push_back(kind.name);
  return names;
}

std::vector<std::string> NamesOfKind(const std::string& kind) {
  std::vector<std::string> names;
  for (const Entry& entry : FindKind(kind).entries()) names.push_back(entry.name);
  return names;
}

int ListCommand(const std::string& kind, bool verbose) {
  if (kind.empty()) {
    Print(EntriesOf(Kinds()));
  } else if (kind == "scenes" && verbose) {
    PrintSceneAreas();
  } else {
    Print(FindKind(kind).entries());
  }
  return 0;
}

}  // namespace atlas::experiments
