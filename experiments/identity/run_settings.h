// What tells one run from another, its seed and its output aside: the resolved parameters by path.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/params.h"

namespace atlas::experiments {

/// Value by path, as config.yaml has them: {"mapper.resolution_m", "0.05"}. `output.*` and the experiment's
/// own name are not among them, since neither changes a result.
using RunSettings = std::map<std::string, std::string>;

RunSettings SettingsOf(const std::vector<core::ParamRow>& rows);
/// Those of a config.yaml. @throws InputError when it is missing or malformed.
RunSettings ReadSettings(const std::filesystem::path& config);

/// Paths whose values differ or that only one side has, sorted.
std::vector<std::string> DifferingPaths(const RunSettings& a, const RunSettings& b);

}  // namespace atlas::experiments
