#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/bench/correction_bench.h"
#include "experiments/bench/mapper_bench.h"
#include "experiments/bench/motion_bench.h"
#include "experiments/bench/odometry_bench.h"
#include "experiments/bench/places_bench.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/progress_line.h"
#include "mapping/integrator/simd_target.h"
#include "scenes/catalog.h"
#include "sim/sensors/raycaster_bench.h"

namespace atlas::experiments {
namespace {

int BenchLidar(const std::string& scene) {
  const core::LidarModel lidar = core::FindLidarModel("vlp16");
  std::cout << fmt::format("{:<20} {:>10} {:>12} {:>14} {:>8} {:>12}\n", "scene", "triangles", "rays/s",
                           "bare Embree/s", "share", "ms a spin");
  for (const auto& entry : scenes::Catalog()) {
    if (!scene.empty() && entry.name != scene) continue;
    const sim::RaycasterSpeed speed = sim::MeasureRaycaster(entry.build(), lidar, 1.0);
    std::cout << fmt::format("{:<20} {:10} {:12.3e} {:14.3e} {:6.1f} % {:12.2f}\n", entry.name,
                             speed.triangles, speed.rays_per_second, speed.bare_rays_per_second,
                             100.0 * speed.rays_per_second / speed.bare_rays_per_second, speed.spin_ms);
  }
  return 0;
}

std::vector<MapperCase> CasesFor(const BenchArguments& arguments) {
  const bool one = arguments.range_m || arguments.resolution_m;
  if (one && arguments.scene.empty()) {
    throw core::InputError("bench mapper: --range and --resolution need --scene");
  }
  if (one)
    return {{arguments.scene, arguments.range_m.value_or(60.0), arguments.resolution_m.value_or(0.065)}};
  std::vector<MapperCase> cases = StandardMapperCases();
  if (arguments.scene.empty()) return cases;
  std::erase_if(cases, [&](const MapperCase& c) { return c.scene != arguments.scene; });
  if (cases.empty()) cases = {{arguments.scene, 60.0, 0.26}, {arguments.scene, 60.0, 0.065}};
  return cases;
}

int BenchMapper(const BenchArguments& arguments, const std::filesystem::path& folder) {
  if (!arguments.simd.empty()) mapping::LimitSimd(arguments.simd);
  MapperBenchOptions options;
  options.max_scans = arguments.scans;
  options.threads = arguments.threads;
  options.octomap = arguments.octomap;
  std::vector<MapperCaseResult> results;
  std::optional<BenchDataset> dataset;
  ProgressLine line;
  for (const MapperCase& setting : CasesFor(arguments)) {
    if (!dataset || dataset->name != setting.scene) {
      dataset.reset();
      dataset = RecordBenchDataset(setting.scene, arguments.scans, arguments.threads, [&](double share) {
        line.Show(fmt::format("recording {}: {:3.0f} %", setting.scene, 100.0 * share), false);
      });
    }
    results.push_back(
        RunMapperCase(setting, *dataset, options, [&](const std::string& text) { line.Show(text, false); }));
    WriteMapperBench(folder, results);
  }
  line.Show("measured", true);
  std::cout << fmt::format("instructions: {}; threads: {}\n", mapping::SimdInUse(), arguments.threads)
            << SpeedTable(results) << "\n"
            << QualityTable(results) << "\ntables and plots: " << folder.string() << "\n";
  return 0;
}

int BenchMotion(const BenchArguments& arguments, const std::filesystem::path& folder) {
  const std::vector<MotionCase> cases = RunMotionBench(arguments.threads);
  WriteMotionBench(folder, cases);
  std::cout << MotionTable(cases) << "\ntable and pictures: " << folder.string() << "\n";
  return 0;
}

int BenchCorrection(const BenchArguments& arguments, const std::filesystem::path& folder) {
  CorrectionBench bench;
  bench.threads = arguments.threads;
  ProgressLine line;
  const CorrectionResult result = RunCorrectionBench(
      bench, [&](double share) { line.Show(fmt::format("preparing: {:3.0f} %", 100.0 * share), false); });
  WriteCorrectionBench(folder, result);
  line.Show("measured", true);
  std::cout << CorrectionTable(result) << "\ntables: " << folder.string() << "\n";
  return 0;
}

/// Scenes of the SLAM benches, each with the LiDAR that its experiments carry.
std::vector<std::pair<std::string, std::string>> SlamScenes(const BenchArguments& arguments) {
  if (arguments.scene.empty()) return {{"rooms_small", "os0_64"}, {"campus", "os1_64"}};
  return {{arguments.scene, arguments.scene == "rooms_small" ? "os0_64" : "os1_64"}};
}

int BenchOdometry(const BenchArguments& arguments, const std::filesystem::path& folder) {
  std::vector<OdometryCase> cases;
  ProgressLine line;
  for (const auto& [scene, lidar] : SlamScenes(arguments)) {
    for (const bool with_prior : {true, false}) {
      cases.push_back(
          RunOdometryCase(scene, lidar, with_prior, arguments.scans, arguments.threads, [&](double share) {
            line.Show(fmt::format("{}, prior {}: {:3.0f} %", scene, with_prior ? "on" : "off", 100.0 * share),
                      false);
          }));
      WriteOdometryBench(folder, cases);
    }
  }
  line.Show("measured", true);
  std::cout << OdometryTable(cases) << "\ntables: " << folder.string() << "\n";
  return 0;
}

int BenchPlaces(const BenchArguments& arguments, const std::filesystem::path& folder) {
  std::vector<PlacesCase> cases;
  ProgressLine line;
  for (const auto& [scene, lidar] : SlamScenes(arguments)) {
    cases.push_back(RunPlacesCase(scene, lidar, arguments.threads, [&](double share) {
      line.Show(fmt::format("{}: {:3.0f} %", scene, 100.0 * share), false);
    }));
    WritePlacesBench(folder, cases);
  }
  line.Show("measured", true);
  std::cout << PlacesTable(cases) << "\ntables and curves: " << folder.string() << "\n";
  return 0;
}

using Bench = int (*)(const BenchArguments&, const std::filesystem::path&);
const std::vector<std::pair<std::string, Bench>> kBenches = {{"mapper", BenchMapper},
                                                             {"motion", BenchMotion},
                                                             {"correction", BenchCorrection},
                                                             {"odometry", BenchOdometry},
                                                             {"places", BenchPlaces}};

}  // namespace

int BenchCommand(const BenchArguments& arguments) {
  const std::string& what = arguments.what;
  if (what == "lidar") return BenchLidar(arguments.scene);
  const auto bench =
      std::find_if(kBenches.begin(), kBenches.end(), [&](const auto& entry) { return entry.first == what; });
  if (bench == kBenches.end()) {
    std::vector<std::string> names = {"lidar"};
    for (const auto& entry : kBenches) names.push_back(entry.first);
    throw core::InputError(core::UnknownName("bench", what, names));
  }
  const std::filesystem::path folder =
      arguments.out.empty() ? std::filesystem::path("runs") / ("bench_" + what) : arguments.out;
  core::RemoveStaleTemporaries(folder);
  core::WriteFileAtomically(folder / "bench.txt",
                            what + "\n");  // before the work: a bad folder costs nothing
  return bench->second(arguments, folder);
}

}  // namespace atlas::experiments
