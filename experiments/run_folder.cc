#include "experiments/run_folder.h"

#include <fmt/format.h>

#include "core/errors.h"
#include "core/named_files.h"
#include "robots/robot_files.h"
#include "robots/robot_spec.h"
#include "scenes/scene_files.h"

namespace atlas::experiments {
namespace fs = std::filesystem;
namespace {

/// What runs write; a forced run removes these, and nothing else that lies there.
constexpr const char* kRunFiles[] = {"summary.json",
                                     "config.yaml",
                                     "steps.csv",
                                     "timings.csv",
                                     "candidates.csv",
                                     "coverage_by_part.csv",
                                     "coverage.svg",
                                     "trajectory_truth.tum",
                                     "trajectory_odom.tum",
                                     "alignment.txt",
                                     "cloud.ply",
                                     "ground_truth.ply",
                                     "map.atlas",
                                     "map.bt",
                                     "recording.bin",
                                     "terrain.pgm",
                                     "terrain.yaml",
                                     "blocked_ways.csv",
                                     "exit_code",
                                     "video.mp4",
                                     "log.txt"};

[[noreturn]] void CannotMake(const fs::path& folder, const std::error_code& error) {
  throw core::InputError(fmt::format("{}: cannot make this folder ({})", folder.string(), error.message()));
}

/// True where this call made it.
bool Make(const fs::path& folder) {
  std::error_code error;
  if (folder.has_parent_path()) fs::create_directories(folder.parent_path(), error);
  const bool made = fs::create_directory(folder, error);
  std::error_code unseen;
  if (error || !fs::is_directory(folder, unseen))
    CannotMake(folder, error ? error : std::make_error_code(std::errc::not_a_directory));
  return made;
}

void RemoveRun(const fs::path& folder) {
  const auto check = [&](const char* name, const std::error_code& error) {
    if (!error) return;
    throw core::InputError(fmt::format("{}: cannot remove ({})", (folder / name).string(), error.message()));
  };
  std::error_code error;
  for (const char* name : kRunFiles) {
    fs::remove(folder / name, error);
    check(name, error);
  }
  for (const char* name : {"scene", "robot"}) {
    fs::remove_all(folder / name, error);
    check(name, error);
  }
}

void SetRow(ExperimentConfig* config, const std::string& path, const std::string& value) {
  for (core::ParamRow& row : config->rows) {
    if (row.path == path) row.value = value;
  }
}

}  // namespace

bool HoldsRun(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / "summary.json", error) || fs::exists(folder / "config.yaml", error);
}

fs::path OpenRunFolder(const fs::path& folder, bool numbered, bool force) {
  if (force || !numbered) {
    const bool made = Make(folder);
    if (!made && HoldsRun(folder)) {
      if (!force)
        throw core::InputError(
            fmt::format("{}: holds a run already (--force to replace it)", folder.string()));
      RemoveRun(folder);
    }
    return folder;
  }
  fs::path mine = folder;
  for (int k = 2; !Make(mine); ++k) mine = fmt::format("{}-{}", folder.string(), k);
  return mine;
}

ExperimentConfig KeepInputs(const ExperimentConfig& config, const fs::path& folder) {
  ExperimentConfig kept = config;
  robots::LoadRobot(config.robot.name);
  const std::string scene = scenes::KeepScene(config.scene.name, folder);
  if (core::IsFileName(scene)) {
    kept.scene.name = (folder / scene).string();
    SetRow(&kept, "scene.name", scene);
  }
  const fs::path robot = "robot" / robots::CopyRobot(config.robot.name, folder / "robot");
  kept.robot.name = (folder / robot).string();
  SetRow(&kept, "robot.name", robot.string());
  return kept;
}

void DiscardInputs(const fs::path& folder) {
  if (HoldsRun(folder)) return;
  std::error_code error;
  for (const char* name : {"scene", "robot"}) fs::remove_all(folder / name, error);
  fs::remove(folder, error);
}

std::string NameInFolder(const std::string& name_or_path, const fs::path& folder) {
  const std::string prefix = (folder / "").string();
  return name_or_path.starts_with(prefix) ? name_or_path.substr(prefix.size()) : name_or_path;
}

}  // namespace atlas::experiments
