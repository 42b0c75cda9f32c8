#include "experiments/results/run_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "core/errors.h"
#include "core/files.h"
#include "core/named_files.h"
#include "experiments/results/map_slice.h"
#include "experiments/results/run_summary.h"
#include "mapping/atlas/saved_atlas.h"
#include "robots/robot_files.h"
#include "robots/robot_spec.h"
#include "scenes/catalog.h"
#include "scenes/scene_files.h"
#include "sim/world/world_model.h"

namespace atlas::experiments {
namespace fs = std::filesystem;
namespace {

/// What runs write besides kInputFolders; a forced run removes these, and nothing else that lies there.
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
                                     kMapSliceImage,
                                     kMapSliceLegend,
                                     "blocked_ways.csv",
                                     "exit_code",
                                     "video.mp4",
                                     "log.txt"};
constexpr const char* kInputFolders[] = {"scene", "robot"};
/// Submaps and their list, of `mapper.name: atlas`.
constexpr const char* kAtlasFolder = "atlas";
/// What lies in kInputFolders because a run put it there: a path a line.
constexpr const char* kInputsFile = "inputs.txt";

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

void Remove(const fs::path& file) {
  std::error_code error;
  fs::remove(file, error);
  if (error) throw core::InputError(fmt::format("{}: cannot remove ({})", file.string(), error.message()));
}

/// Whether a run in `folder` may have put a file there: in an input folder, and by no way out of it.
bool IsInput(const fs::path& relative, const fs::path& folder) {
  const bool named = std::any_of(std::begin(kInputFolders), std::end(kInputFolders),
                                 [&](const char* name) { return *relative.begin() == name; });
  if (!named || relative != relative.lexically_normal()) return false;
  fs::path at = folder;
  for (const fs::path& part : relative.parent_path()) {
    at /= part;
    if (fs::is_symlink(fs::symlink_status(at))) return false;
  }
  return true;
}

/// Folders that are left empty go, from the innermost on.
void RemoveIfEmpty(const fs::path& folder) {
  std::error_code error;
  if (fs::is_symlink(fs::symlink_status(folder)) || !fs::is_directory(folder, error)) return;
  for (const auto& entry : fs::directory_iterator(folder, error)) RemoveIfEmpty(entry.path());
  if (fs::is_empty(folder, error)) fs::remove(folder, error);
}

/// The copies that a run was made from, and nothing that the user put beside them.
void RemoveInputs(const fs::path& folder) {
  const fs::path list = folder / kInputsFile;
  if (!fs::is_regular_file(fs::symlink_status(list))) return;
  std::istringstream lines(core::ReadFile(list));
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && IsInput(line, folder)) Remove(folder / line);
  }
  for (const char* name : kInputFolders) RemoveIfEmpty(folder / name);
  Remove(list);
}

/// The submaps of a run, and nothing that the user put beside them.
void RemoveAtlas(const fs::path& folder) {
  const fs::path atlas = folder / kAtlasFolder;
  std::error_code error;
  if (fs::is_symlink(fs::symlink_status(atlas)) || !fs::is_directory(atlas, error)) return;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(atlas, error)) {
    const std::string name = entry.path().filename().string();
    if (mapping::IsAtlasFile(name)) files.push_back(entry.path());
  }
  for (const fs::path& file : files) Remove(file);
  RemoveIfEmpty(atlas);
}

/// All of a run but its summary.
void RemoveResults(const fs::path& folder) {
  RemoveAtlas(folder);
  for (const char* name : kRunFiles) {
    if (std::string_view(name) != "summary.json") Remove(folder / name);
  }
  RemoveInputs(folder);
}

/// Whether `file` is below `folder`, as it is written or where its links lead.
bool LiesIn(const fs::path& file, const fs::path& folder) {
  const auto below = [](const fs::path& path, const fs::path& root) {
    return std::mismatch(root.begin(), root.end(), path.begin(), path.end()).first == root.end();
  };
  const auto written = [](const fs::path& path) { return fs::absolute(path).lexically_normal(); };
  const fs::path root = fs::weakly_canonical(folder);
  return below(fs::weakly_canonical(file), root) ||
         below(fs::weakly_canonical(written(file).parent_path()), root) ||
         below(written(file), written(folder / "").parent_path());
}

/// Of a folder that exists. @throws InputError where a run there would overwrite what is not another run's.
void RefuseFolderInUse(const RunFolderRequest& request) {
  const fs::path& folder = request.folder;
  for (const fs::path& input : request.inputs) {
    if (LiesIn(input, folder)) {
      throw core::InputError(
          fmt::format("{}: the run is made from {}, which lies there (choose another --out)", folder.string(),
                      input.string()));
    }
  }
  if (HoldsRun(folder)) {
    if (request.force) return;
    throw core::InputError(fmt::format("{}: holds a run already (--force to replace it)", folder.string()));
  }
  const std::string own = RunFileIn(folder);
  if (own.empty()) return;
  throw core::InputError(
      fmt::format("{}: holds no run, but '{}', which a run would overwrite (choose another --out)",
                  folder.string(), own));
}

void SetRow(ExperimentConfig* config, const std::string& path, const std::string& value) {
  for (core::ParamRow& row : config->rows) {
    if (row.path == path) row.value = value;
  }
}

/// What `load` gives for the value of a row. @throws InputError as it does, and where the value is no file
/// (which messages name), tells where it was set.
template <typename Load>
auto LoadNamed(const ExperimentConfig& config, const std::string& path, const std::string& value,
               const Load& load) {
  try {
    return load(value);
  } catch (const core::InputError& error) {
    const auto row = std::find_if(config.rows.begin(), config.rows.end(),
                                  [&](const core::ParamRow& r) { return r.path == path; });
    const bool told = core::IsFileName(value) || row == config.rows.end() || row->origin == "default";
    if (told) throw;
    throw core::InputError(fmt::format("{}: {}: {}", row->origin, path, error.what()));
  }
}

/// Writes kInputsFile: what `kept` names in the folder.
void ListInputs(const ExperimentConfig& kept, const fs::path& folder) {
  std::vector<fs::path> files = scenes::FilesOfScene(kept.scene.name);
  for (fs::path& file : robots::FilesOfRobot(kept.robot.name)) files.push_back(std::move(file));
  std::string lines;
  for (const fs::path& file : files) lines += file.lexically_proximate(folder).string() + "\n";
  core::WriteFileAtomically(folder / kInputsFile, lines);
}

}  // namespace

bool HoldsRun(const fs::path& folder) {
  try {
    LoadRunSummary(folder);
    return true;
  } catch (const core::InputError&) {
    return false;  // none, or a file of the user's
  }
}

std::string RunFileIn(const fs::path& folder) {
  const auto stands = [&](const char* name) {
    return fs::symlink_status(folder / name).type() != fs::file_type::not_found;
  };
  for (const char* name : kInputFolders) {
    if (stands(name)) return name;
  }
  for (const char* name : {kInputsFile, kAtlasFolder}) {
    if (stands(name)) return name;
  }
  for (const char* name : kRunFiles) {
    if (stands(name)) return name;
  }
  return "";
}

std::vector<fs::path> CheckedInputs(const ExperimentConfig& config, const std::string& experiment) {
  const scenes::SceneSpec scene = LoadNamed(config, "scene.name", config.scene.name, scenes::LoadScene);
  const robots::RobotSpec robot = LoadNamed(config, "robot.name", config.robot.name, robots::LoadRobot);
  std::vector<fs::path> inputs = scenes::FilesOfScene(config.scene.name);
  for (fs::path& file : robots::FilesOfRobot(config.robot.name)) inputs.push_back(std::move(file));
  if (core::IsFileName(experiment)) inputs.emplace_back(experiment);
  for (const core::ParamRow& row : config.rows) {
    const fs::path file = row.origin.substr(0, row.origin.rfind(':'));  // "FILE:LINE"
    std::error_code error;
    if (core::IsFileName(file.string()) && fs::exists(file, error)) inputs.push_back(file);
  }
  std::sort(inputs.begin(), inputs.end());
  inputs.erase(std::unique(inputs.begin(), inputs.end()), inputs.end());
  if (core::IsFileName(config.robot.name)) sim::CompileModel(scene, robot);
  return inputs;
}

void ClaimRunFolder(const fs::path& folder, const std::string& experiment, uint64_t seed) {
  RunSummary claim;  // interrupted
  claim.experiment = experiment;
  claim.seed = seed;
  core::WriteFileAtomically(folder / "summary.json", ToJson(claim));
}

fs::path OpenRunFolder(const RunFolderRequest& request) {
  fs::path mine = request.folder;
  bool made = Make(mine);
  if (request.numbered && !request.force) {
    for (int k = 2; !made; ++k) {
      mine = fmt::format("{}-{}", request.folder.string(), k);
      made = Make(mine);
    }
  }
  if (!made) RefuseFolderInUse(request);
  core::FolderLock lock(mine);
  core::RemoveStaleTemporaries(mine);
  try {
    ClaimRunFolder(mine, request.experiment, request.seed);
  } catch (const core::InputError&) {
    std::error_code error;
    if (made) fs::remove(mine, error);
    throw;
  }
  if (!made) RemoveResults(mine);
  if (request.lock != nullptr) *request.lock = std::move(lock);
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
  ListInputs(kept, folder);
  return kept;
}

void DiscardInputs(const fs::path& folder) {
  try {
    if (!LoadRunSummary(folder).config_hash.empty()) return;  // a run has begun
  } catch (const core::InputError&) {
    return;  // not of OpenRunFolder
  }
  std::error_code error;
  try {
    RemoveInputs(folder);
  } catch (const core::InputError&) {
    return;  // of two errors the first is told; the claim says that a run was here
  }
  fs::remove(folder / "summary.json", error);
  fs::remove(folder, error);
}

std::string NameInFolder(const std::string& name_or_path, const fs::path& folder) {
  const std::string prefix = (folder / "").string();
  return name_or_path.starts_with(prefix) ? name_or_path.substr(prefix.size()) : name_or_path;
}

}  // namespace atlas::experiments
