#include <filesystem>

#include "core/files.h"
#include "experiments/identity/experiment_config.h"
#include "experiments/sweep/sweep_spec.h"
#include "experiments/video/run_recording.h"
#include "scenes/route.h"
#include "tests/fuzz/fuzzed_reader.h"

namespace atlas::fuzz {
namespace {

std::string SmallRecording() {
  experiments::RunRecording run;
  run.scene = "none";
  run.robot = "quadruped";
  for (int i = 0; i < 10; ++i) run.states.push_back({0.1 * i, std::vector<double>(19, 0.5)});
  run.keyframes.push_back({0.5,
                           {{0.025f, 1.025f, 0.525f}, {0.075f, 1.025f, 0.525f}},
                           {{0, 0}, {2, 0}},
                           experiments::ChosenView{{2, 0}, 1}});
  run.keyframes.push_back({0.8, {{0.075f, 1.025f, 0.525f}}, {}, std::nullopt});
  const auto path = std::filesystem::temp_directory_path() / "atlas_fuzz_seed" / "recording.bin";
  experiments::SaveRecording(path, run);
  const std::string bytes = core::ReadFile(path);
  std::filesystem::remove_all(path.parent_path());
  return bytes;
}

}  // namespace

std::vector<FuzzedReader> RunReaders() {
  const std::string experiment =
      "scene: helicopter\nmapper: {name: octomap, resolution_m: 0.08}\nplanner: thesis\n"
      "mission: {max_scans: 30}\noutput: {video: false}\n";
  const std::string sweep =
      "doc: two gains\nexperiments: [helicopter, car]\ngrid:\n  planner.gain: [rear_side_voxel, "
      "unobserved_voxel]\n"
      "seeds: [1, 2]\nestimate_s: 60\n";
  return {
      {"experiment.yaml",
       {experiment, "planner: {name: thesis, nodes: &n 30}\nmission: {max_scans: *n}\n"},
       [](auto, auto& file) { experiments::LoadExperiment(file.string(), {}); },
       true},
      {"sweep.yaml", {sweep}, [](auto, auto& file) { experiments::LoadSweep(file.string()); }, true},
      {"recording.bin", {SmallRecording()}, [](auto, auto& file) { experiments::LoadRecording(file); }, true},
      {"route.yaml",
       {core::ReadFile(core::InstalledFile("scenes/routes/rooms_small.yaml"))},
       [](auto, auto& file) { scenes::LoadRoute(file); },
       true}};
}

}  // namespace atlas::fuzz
