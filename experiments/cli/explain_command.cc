#include <fmt/format.h>

#include <iostream>
#include <set>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/cli/camera_note.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/map_commands.h"
#include "experiments/identity/experiment_config.h"

namespace atlas::experiments {
namespace {

/// A name that stands beside the experiments' own.
constexpr const char* kMap = "map";

/// Files that ship are named alone, wherever they are installed.
std::string OriginOf(const core::ParamRow& row) {
  const std::string configs = core::InstalledFile("experiments/configs").string() + "/";
  return row.origin.starts_with(configs) ? row.origin.substr(configs.size()) : row.origin;
}

/// The sections of all depths and the keys, for a prefix that none begins with.
void CheckPrefix(const std::vector<core::ParamRow>& rows, const std::string& prefix) {
  std::set<std::string> names;
  for (const core::ParamRow& row : rows) {
    if (row.path.starts_with(prefix)) return;
    for (size_t dot = row.path.find('.'); dot != std::string::npos; dot = row.path.find('.', dot + 1))
      names.insert(row.path.substr(0, dot));
    names.insert(row.path);
  }
  throw core::InputError(core::UnknownName("prefix", prefix, {names.begin(), names.end()}));
}

std::vector<core::ParamRow> RowsOf(const ExplainArguments& arguments) {
  if (arguments.what != kMap) return LoadExperiment(arguments.what, arguments.assignments).rows;
  MapArguments map;
  map.assignments = arguments.assignments;
  return ExplainMap(map);
}

}  // namespace

std::string ExplainText(const std::vector<core::ParamRow>& rows, const std::vector<std::string>& prefixes) {
  for (const std::string& prefix : prefixes) CheckPrefix(rows, prefix);
  std::string text;
  for (const core::ParamRow& row : rows) {
    const auto begins = [&](const std::string& prefix) { return row.path.starts_with(prefix); };
    if (!prefixes.empty() && std::none_of(prefixes.begin(), prefixes.end(), begins)) continue;
    text += fmt::format("{} = {}{}{} | {} | {} | {}\n", row.path, row.value, row.unit.empty() ? "" : " ",
                        row.unit, row.range, OriginOf(row), row.doc);
  }
  return text;
}

int ExplainCommand(const ExplainArguments& arguments) {
  const std::vector<core::ParamRow> rows = RowsOf(arguments);
  std::cout << ExplainText(rows, arguments.prefixes);
  if (arguments.what != kMap) TellOfMissingCamera(rows);
  return 0;
}

}  // namespace atlas::experiments
