// Missions of a second: a block on level ground, a robot without physics, two short sweeps and few views.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "core/files.h"
#include "experiments/mission/closed_loop.h"

namespace atlas::tests {

class TinyMissions {
 public:
  TinyMissions() {
    core::WriteFileAtomically(folder_ / "block.yaml", R"(
spawn: {x: -1.8, y: 0.0}
object_box: {min: [-0.4, -0.4, 0.05], max: [0.4, 0.4, 1.0]}
ground: {size: [7, 7]}
parts:
  - {primitive: box, name: block, size: [0.6, 0.6, 0.9], pose: {xyz: [0, 0, 0.45]}}
)");
    const std::string bare = "scene: {name: " + (folder_ / "block.yaml").string() + "}\n" + R"(
locomotion: {name: kinematic, speed_mps: 1.0, sweep_period_s: 3.0}
sensors: {depth_camera: false, walking_spin_stride: 5}
mapper: {resolution_m: 0.1}
planner: {terrain: {cell_m: 0.06}}
mission: {max_scans: 2, truth_spacing_m: 0.05}
seed: 3
)";
    core::WriteFileAtomically(folder_ / "bare.yaml", bare);
    core::WriteFileAtomically(folder_ / "tiny.yaml", R"(
extends: bare.yaml
planner: {nodes: 6, rays: 100, headings: 2, lattice_m: 1.0, rrt_star_iterations: 50}
)");
    ::setenv("ATLAS_CACHE", (folder_ / "cache").c_str(), 1);
  }
  ~TinyMissions() { std::filesystem::remove_all(folder_); }

  /// Loads the mission with these assignments over it. @throws InputError as LoadExperiment.
  experiments::ExperimentConfig Load(const std::vector<std::string>& assignments) const {
    return experiments::LoadExperiment((folder_ / "tiny.yaml").string(), assignments);
  }
  /// The same without a word on how to plan, for whatever planner the assignments name.
  experiments::ExperimentConfig LoadBare(const std::vector<std::string>& assignments) const {
    return experiments::LoadExperiment((folder_ / "bare.yaml").string(), assignments);
  }
  /// Runs it into folder()/NAME.
  experiments::RunSummary Run(const std::vector<std::string>& assignments, const std::string& name) const {
    experiments::RunOptions options;
    options.folder = folder_ / name;
    return experiments::RunClosedLoop(Load(assignments), options);
  }
  std::string FileOf(const std::string& name, const std::string& file) const {
    return core::ReadFile(folder_ / name / file);
  }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("atlas_tiny_" + std::to_string(::getpid()));
};

}  // namespace atlas::tests
