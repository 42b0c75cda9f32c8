#include "experiments/identity/run_settings.h"

#include "core/yaml_text.h"

namespace atlas::experiments {
namespace {

bool TellsRunsApart(const std::string& path) {
  return path != "experiment" && path != "seed" && !path.starts_with("output.");
}

void Flatten(const YAML::Node& node, const std::string& path, RunSettings* settings) {
  if (node.IsMap()) {
    for (const auto& entry : node) {
      const std::string key = entry.first.as<std::string>();
      Flatten(entry.second, path.empty() ? key : path + "." + key, settings);
    }
    return;
  }
  if (path.empty() || !TellsRunsApart(path)) return;
  std::string value;
  if (node.IsSequence()) {
    for (const auto& item : node) value += (value.empty() ? "" : ", ") + item.as<std::string>("");
    value = "[" + value + "]";
  } else if (node.IsScalar()) {
    value = node.Scalar();
  }
  (*settings)[path] = value;
}

}  // namespace

RunSettings SettingsOf(const std::vector<core::ParamRow>& rows) {
  RunSettings settings;
  for (const core::ParamRow& row : rows) {
    if (TellsRunsApart(row.path)) settings[row.path] = row.value;
  }
  return settings;
}

RunSettings ReadSettings(const std::filesystem::path& config) {
  RunSettings settings;
  Flatten(core::LoadYaml(config), "", &settings);
  return settings;
}

std::vector<std::string> DifferingPaths(const RunSettings& a, const RunSettings& b) {
  std::vector<std::string> paths;
  auto i = a.begin(), j = b.begin();
  while (i != a.end() || j != b.end()) {
    if (j == b.end() || (i != a.end() && i->first < j->first)) {
      paths.push_back((i++)->first);
    } else if (i == a.end() || j->first < i->first) {
      paths.push_back((j++)->first);
    } else {
      if (i->second != j->second) paths.push_back(i->first);
      ++i;
      ++j;
    }
  }
  return paths;
}

}  // namespace atlas::experiments
