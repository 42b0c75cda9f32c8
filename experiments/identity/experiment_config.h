// An experiment: every parameter of a run, by section.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/params.h"
#include "mapping/backends/catalog.h"
#include "mapping/slam/localiser.h"
#include "planner/planners/catalog.h"
#include "sim/simulator.h"

namespace atlas::experiments {

struct NamedParams {
  std::string name;
  std::string doc;
  void Visit(core::ParamVisitor& v);
};

struct MissionParams {
  int max_scans = 60;
  double max_time_s = 2700.0;
  double max_distance_m = 300.0;
  double planning_latency_s = 1.0;     ///< simulated time a plan takes, whatever the machine
  double integration_latency_s = 0.5;  ///< likewise for a sweep's integration
  double coverage_radius_m = 0.043;    ///< Eq. 3.9: half the diagonal of a 5 cm voxel
  double truth_spacing_m = 0.01;
  bool attainable = true;  ///< also what could be had at best; hours and gigabytes where places are wide
  bool map_while_walking = true;  ///< the map also takes the spins of the walk; off for the thesis's planner
  double flat_coverage = 0.015;   ///< flat_by_truth: the last `flat_scans` scans added less each
  int flat_scans = 3;
  std::vector<std::string> plan_after;  ///< two places "X Y Z": at the end, a way between them on the map
  void Visit(core::ParamVisitor& v);
};

struct OutputParams {
  bool video = false;
  double video_speed = 8.0;
  void Visit(core::ParamVisitor& v);
};

inline constexpr int kGreatestSeed = 2147483647;

struct ExperimentConfig {
  std::string experiment;  ///< name: the file's stem where none is set
  int seed = 1;            ///< of all randomness
  NamedParams scene{"helicopter", "built-in scene, or path/scene.yaml"};
  NamedParams robot{"quadruped", "built-in robot, or path/robot.xml"};
  sim::SimParams sim;
  mapping::LocalisationParams localisation;
  mapping::MapperParams mapper;
  planner::PlannerConfig planner;
  MissionParams mission;
  OutputParams output;
  std::vector<core::ParamRow> rows;  ///< as resolved

  void Visit(core::ParamVisitor& v);
};

/// Loads `experiments/configs/NAME.yaml`, or a file of the user's, with `--set` assignments over it. Scene
/// and robot files are relative to the YAML that names them, those of assignments to the working directory.
/// Defaults are those of the planner that these name; `thesis` also brings OctoMap without void rays unless
/// they name a mapper, and maps its sweeps alone.
/// @throws InputError for an unknown experiment, key or value.
ExperimentConfig LoadExperiment(const std::string& name_or_path, const std::vector<std::string>& assignments);

struct ExperimentEntry {
  std::string name;
  std::string doc;
};
std::vector<ExperimentEntry> ListExperiments();
/// The YAML files of a folder by name, sorted; `doc` is a first line that is a comment.
std::vector<ExperimentEntry> ListYaml(const std::filesystem::path& folder);

}  // namespace atlas::experiments
