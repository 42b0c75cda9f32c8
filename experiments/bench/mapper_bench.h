// SE-Atlas beside OctoMap on the same scans, alternating scan by scan in one process (thesis 4.10.3).
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "experiments/bench/bench_dataset.h"
#include "experiments/bench/map_quality.h"
#include "mapping/integrator/integrator.h"

namespace atlas::experiments {

/// What is mapped, and how finely: a row of the thesis's Fig. 4.14.
struct MapperCase {
  std::string scene;
  double max_range_m = 60.0;
  double resolution_m = 0.065;
};
/// Campus at 20 m/26 cm, 60 m/26 cm and 60 m/6.5 cm; rooms at 20 m/26 cm and 60 m/6.5 cm.
std::vector<MapperCase> StandardMapperCases();

struct MapperBenchOptions {
  int max_scans = 0;  ///< 0: the whole route
  int threads = 1;
  bool octomap = true;
  double octomap_patience_s = 2.0;  ///< a scan; slower than that, OctoMap stops after `octomap_scans`
  int octomap_scans = 4;
  size_t octomap_bytes = size_t{8} << 30;  ///< and in any case at this size
  mapping::IntegratorParams integrator;
};

/// One mapper's course through the scans.
struct MapperCourse {
  std::string mapper;
  std::vector<double> cpu_ms = {}, wall_ms = {};  ///< a scan each
  std::vector<size_t> map_bytes = {};             ///< after each scan
  size_t resident_growth_bytes = 0;               ///< of the process while this mapper worked
  MapQuality early = {};                          ///< after the scans that all mappers took
  MapQuality final = {};                          ///< after its last scan
};

struct MapperCaseResult {
  MapperCase setting;
  size_t scans = 0;                   ///< of the dataset
  size_t common_scans = 0;            ///< that every mapper took
  std::vector<MapperCourse> courses;  ///< OctoMap first, where it ran
};

/// Called with a line on what is going on.
using BenchProgress = std::function<void(const std::string&)>;

MapperCaseResult RunMapperCase(const MapperCase& setting, const BenchDataset& dataset,
                               const MapperBenchOptions& options, const BenchProgress& progress);

/// Speed and memory; ratios to OctoMap over the common scans.
std::string SpeedTable(const std::vector<MapperCaseResult>& results);
std::string QualityTable(const std::vector<MapperCaseResult>& results);
/// mapper_bench.csv (a row a scan and mapper), tables and growth curves as SVG.
void WriteMapperBench(const std::filesystem::path& folder, const std::vector<MapperCaseResult>& results);

}  // namespace atlas::experiments
