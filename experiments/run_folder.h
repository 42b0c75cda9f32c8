// Where a run is kept: a folder of its own, with copies of all that the run was made from.
#pragma once

#include <filesystem>
#include <string>

#include "experiments/experiment_config.h"

namespace atlas::experiments {

/// Whether a run was or is being written there.
bool HoldsRun(const std::filesystem::path& folder);

/// Makes the folder of a new run and empties it of an earlier run's files where `force` is set. Without
/// `force` an earlier run is never touched: where `numbered`, the run goes beside it, to "FOLDER-2",
/// "FOLDER-3" ... Returns the folder, which no other process can get at the same time where numbered.
/// @throws InputError where the folder holds a run and is neither numbered nor forced, or cannot be made.
std::filesystem::path OpenRunFolder(const std::filesystem::path& folder, bool numbered, bool force);

/// Copies a user's scene file with its meshes to FOLDER/scene, and the robot's MJCF with what it names to
/// FOLDER/robot. Returns the configuration that names the copies: paths in `scene` and `robot`, names
/// relative to the folder in `rows`, as config.yaml has them. @throws InputError for input that cannot be
/// loaded.
ExperimentConfig KeepInputs(const ExperimentConfig& config, const std::filesystem::path& folder);

/// Removes the copies, and the folder if nothing else is in it, where no run has begun there.
void DiscardInputs(const std::filesystem::path& folder);

/// A file in the run folder by its name there; any other name as it is.
std::string NameInFolder(const std::string& name_or_path, const std::filesystem::path& folder);

}  // namespace atlas::experiments
