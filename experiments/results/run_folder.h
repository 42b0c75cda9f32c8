// Where a run is kept: a folder of its own, with copies of all that the run was made from.
//
// The first thing that a run writes is summary.json, which says `interrupted` until the run has ended. So a
// folder that holds a readable one holds a run, whole or broken; any other folder is the user's own.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/folder_lock.h"
#include "experiments/identity/experiment_config.h"

namespace atlas::experiments {

/// Whether a run was or is being written there: summary.json is one of a run.
bool HoldsRun(const std::filesystem::path& folder);

/// The first thing in the folder that a run would overwrite, by its name there; empty where there is none.
std::string RunFileIn(const std::filesystem::path& folder);

/// Loads scene and robot as the run will, and compiles a robot of the user's, so that bad input is found
/// before anything is written or removed. Returns the files that the run is made from: `experiment` where
/// that is a file, those that its parameters stand in, scene and meshes, robot and what it names.
/// @throws InputError.
std::vector<std::filesystem::path> CheckedInputs(const ExperimentConfig& config,
                                                 const std::string& experiment);

struct RunFolderRequest {
  std::filesystem::path folder;
  bool numbered = false;  ///< where the folder is taken, the run goes to "FOLDER-2", "FOLDER-3" ...
  bool force = false;     ///< replaces the run in the folder
  std::vector<std::filesystem::path> inputs = {};  ///< CheckedInputs
  std::string experiment = "";
  uint64_t seed = 1;
  core::FolderLock* lock = nullptr;  ///< receives the folder's, to be held while the run goes on
};

/// Makes the folder of a new run, claims it, and then removes an earlier run's files where `force` is set.
/// Returns the folder, which no other process can get at the same time where numbered (and not forced).
/// @throws InputError, with nothing written or removed, where the folder
///   holds a run and is neither numbered nor forced, or another process that runs there,
///   holds none, but files that a run would overwrite,
///   or holds one of the inputs; and where it cannot be made.
std::filesystem::path OpenRunFolder(const RunFolderRequest& request);

/// Writes the summary of a run that has not begun. @throws InputError where it cannot be written.
void ClaimRunFolder(const std::filesystem::path& folder, const std::string& experiment, uint64_t seed);

/// Copies a user's scene file with its meshes to FOLDER/scene, and the robot's MJCF with what it names to
/// FOLDER/robot. Returns the configuration that names the copies: paths in `scene` and `robot`, names
/// relative to the folder in `rows`, as config.yaml has them. @throws InputError for input that cannot be
/// loaded.
ExperimentConfig KeepInputs(const ExperimentConfig& config, const std::filesystem::path& folder);

/// Gives up a folder of OpenRunFolder where no run has begun in it: removes the claim and the copies, and the
/// folder if nothing else is in it.
void DiscardInputs(const std::filesystem::path& folder);

/// A file in the run folder by its name there; any other name as it is.
std::string NameInFolder(const std::string& name_or_path, const std::filesystem::path& folder);

}  // namespace atlas::experiments
