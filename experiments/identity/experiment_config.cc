#include "experiments/identity/experiment_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "core/errors.h"
#include "core/files.h"
#include "core/safe_text.h"

namespace atlas::experiments {
namespace fs = std::filesystem;
namespace {

/// `--set odometry.localisation_sigma_m=0.03` is what localisation.sigma_m was called.
std::string InPresentSpelling(const std::string& assignment) {
  constexpr std::string_view kOld = "odometry.localisation_";
  return assignment.starts_with(kOld) ? "localisation." + assignment.substr(kOld.size()) : assignment;
}

}  // namespace

void NamedParams::Visit(core::ParamVisitor& v) {
  v.Field("name", &name, {.doc = doc, .is_file = true});
}

void MissionParams::Visit(core::ParamVisitor& v) {
  v.Field("max_scans", &max_scans, {.min = 1, .max = 1000, .doc = "scan budget"});
  v.Field("max_time_s", &max_time_s, {.unit = "s", .min = 1, .max = 1e6, .doc = "simulated time budget"});
  v.Field("max_distance_m", &max_distance_m,
          {.unit = "m", .min = 1, .max = 1e6, .doc = "travel budget, by odometry"});
  v.Field("planning_latency_s", &planning_latency_s,
          {.unit = "s", .min = 0, .max = 60, .doc = "simulated time that a plan takes"});
  v.Field("integration_latency_s", &integration_latency_s,
          {.unit = "s", .min = 0, .max = 60, .doc = "simulated time that integrating a sweep takes"});
  v.Field("coverage_radius_m", &coverage_radius_m,
          {.unit = "m",
           .min = 0.005,
           .max = 0.5,
           .doc = "a true point is covered by a measured one this near (Eq. 3.9)"});
  v.Field("truth_spacing_m", &truth_spacing_m,
          {.unit = "m", .min = 0.005, .max = 0.1, .doc = "spacing of the ground-truth cloud"});
  v.Field("attainable", &attainable,
          {.doc = "find out what could be covered at best (once a scene; off for wide places)"});
  v.Field("map_while_walking", &map_while_walking,
          {.doc = "the map also takes the revolutions of the walk between views (thesis: sweeps only)"});
  v.Field("flat_coverage", &flat_coverage,
          {.min = 0.0,
           .max = 1.0,
           .doc = "flat_by_truth: the last flat_scans scans added less coverage each, on average"});
  v.Field("flat_scans", &flat_scans,
          {.min = 1, .max = 100, .doc = "scans that flat_coverage is judged over"});
  v.Field("plan_after", &plan_after,
          {.doc = "two places \"X Y Z\" (m, map): after the mission RRT* plans from one to the other on the "
                  "map (thesis 4.10.8); planned_way.csv, planned_way.png"});
}

void OutputParams::Visit(core::ParamVisitor& v) {
  v.Field("video", &video, {.doc = "write video.mp4 (also --video)"});
  v.Field("video_speed", &video_speed, {.min = 0.1, .max = 100, .doc = "times real time"});
}

void ExperimentConfig::Visit(core::ParamVisitor& v) {
  v.Field("experiment", &experiment,
          {.doc = "name in tables and of run folders (default: that of the file)"});
  v.Field("seed", &seed, {.min = 0, .max = kGreatestSeed, .doc = "of all randomness (also --seed)"});
  v.Section("scene", &scene);
  v.Section("robot", &robot);
  v.Section("locomotion", &sim.locomotion);
  v.Section("odometry", &sim.odometry);
  localisation.lidar = sim.odometry.name == "lidar";
  v.Section("localisation", &localisation);
  v.Section("sensors", &sim.sensors);
  v.Section("mapper", &mapper);
  v.Section("planner", &planner);
  v.Section("mission", &mission);
  v.Section("output", &output);
}

namespace {

/// The thesis's planner brings a map as it had one: OctoMap, of the sweeps alone, from clouds that know
/// nothing of void rays (3.3, 3.4.2). A mapper that the user names brings its own.
void UseDefaultsOf(const std::string& planner, const std::optional<std::string>& mapper,
                   ExperimentConfig* config) {
  if (planner != "thesis") return;
  config->mission.map_while_walking = false;
  if (mapper.value_or("octomap") != "octomap") return;
  config->mapper.name = "octomap";
  config->mapper.integrator.void_rays = "ignore";
}

}  // namespace

std::vector<ExperimentEntry> ListExperiments() {
  return ListYaml(core::InstalledFile("experiments/configs"));
}

std::vector<ExperimentEntry> ListYaml(const fs::path& folder) {
  std::vector<ExperimentEntry> entries;
  for (const auto& file : fs::directory_iterator(folder)) {
    if (file.path().extension() != ".yaml") continue;
    const std::string text = core::ReadFile(file.path());
    const std::string doc = text.starts_with("# ") ? text.substr(2, text.find('\n') - 2) : "";
    entries.push_back({file.path().stem().string(), doc});
  }
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return entries;
}

ExperimentConfig LoadExperiment(const std::string& name_or_path,
                                const std::vector<std::string>& assignments) {
  const fs::path configs = core::InstalledFile("experiments/configs");
  fs::path path = name_or_path;
  if (path.extension() != ".yaml") {
    path = configs / (name_or_path + ".yaml");
    std::error_code error;
    if (!fs::exists(path, error)) {
      std::vector<std::string> names;
      for (const ExperimentEntry& entry : ListExperiments()) names.push_back(entry.name);
      throw core::InputError(core::UnknownName("experiment", name_or_path, names));
    }
  }
  core::ParamSource source;
  source.MergeFile(path, configs);
  for (const std::string& assignment : assignments) source.MergeAssignment(InPresentSpelling(assignment));
  ExperimentConfig config;
  config.experiment = path.stem().string();
  UseDefaultsOf(source.TextAt("planner", "name").value_or(config.planner.name),
                source.TextAt("mapper", "name"), &config);
  config.rows = source.Load(&config);
  if (core::FileNameFrom(config.experiment) != config.experiment) {
    const auto row = std::find_if(config.rows.begin(), config.rows.end(),
                                  [](const core::ParamRow& r) { return r.path == "experiment"; });
    const std::string where = row->origin == "default" ? path.string() : row->origin;
    throw core::InputError(fmt::format(
        "{}: experiment: '{}' cannot name a folder (letters, digits, '.', '-' and '_', beginning with "
        "neither '.' nor '-')",
        where, config.experiment));
  }
  return config;
}

}  // namespace atlas::experiments
