#include "experiments/report/run_groups.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "core/errors.h"

namespace atlas::experiments {
namespace fs = std::filesystem;
namespace {

constexpr size_t kMostNamed = 6;    ///< runs or settings that a note names before it counts
constexpr size_t kMostInLabel = 3;  ///< settings of a label, unless more are needed to tell groups apart

using Cell = std::vector<RunGroup*>;

const std::string* Find(const RunSettings& settings, const std::string& path) {
  const auto found = settings.find(path);
  return found == settings.end() ? nullptr : &found->second;
}

/// Text of a value as it compares: absent differs from every text.
std::string Shown(const RunSettings& settings, const std::string& path) {
  const std::string* value = Find(settings, path);
  return value == nullptr ? "-" : *value;
}

bool EachHas(const Cell& cell, const std::string& path) {
  return std::all_of(cell.begin(), cell.end(), [&](const RunGroup* g) { return Find(g->settings, path); });
}

/// Settings in which the groups of a cell differ. First what all of them have, names before numbers; then
/// what is no parameter (the commit); then parameters that only some have.
std::vector<std::string> DifferingIn(const Cell& cell) {
  std::set<std::string> paths;
  for (const RunGroup* group : cell) {
    for (const std::string& path : DifferingPaths(cell.front()->settings, group->settings))
      paths.insert(path);
  }
  const auto rank = [&](const std::string& path) {
    if (path.find('.') == std::string::npos) return 2;
    return !EachHas(cell, path) ? 3 : path.ends_with(".name") ? 0 : 1;
  };
  std::vector<std::string> ordered(paths.begin(), paths.end());
  std::stable_sort(ordered.begin(), ordered.end(),
                   [&](const std::string& a, const std::string& b) { return rank(a) < rank(b); });
  return ordered;
}

size_t CountDistinct(const Cell& cell, const std::vector<std::string>& paths) {
  std::set<std::vector<std::string>> values;
  for (const RunGroup* group : cell) {
    std::vector<std::string> row;
    for (const std::string& path : paths) row.push_back(Shown(group->settings, path));
    values.insert(std::move(row));
  }
  return values.size();
}

/// Of `paths`, in order, those that tell groups apart which the ones before do not.
std::vector<std::string> Separating(const Cell& cell, const std::vector<std::string>& paths) {
  std::vector<std::string> chosen;
  for (const std::string& path : paths) {
    std::vector<std::string> more = chosen;
    more.push_back(path);
    if (CountDistinct(cell, more) > std::max<size_t>(1, CountDistinct(cell, chosen)))
      chosen = std::move(more);
  }
  return chosen;
}

std::string LabelOf(const RunGroup& group, const std::vector<std::string>& paths) {
  std::string label;
  for (const std::string& path : paths) {
    const std::string* value = Find(group.settings, path);
    if (value == nullptr) continue;
    const std::string name = path.ends_with(".name") ? path.substr(0, path.size() - 5) : path;
    label += fmt::format("{}{}={}", label.empty() ? "" : " ", name, *value);
  }
  return label;
}

/// "a, b, c and 4 more".
std::string Named(const std::vector<std::string>& names) {
  if (names.size() <= kMostNamed + 1) return fmt::format("{}", fmt::join(names, ", "));
  return fmt::format("{} and {} more", fmt::join(names.begin(), names.begin() + kMostNamed, ", "),
                     names.size() - kMostNamed);
}

/// The settings that label a cell's groups: all that differ where they are few and each group has them, else
/// as many as tell the groups apart.
std::vector<std::string> LabellingOf(const Cell& cell, const std::vector<std::string>& all) {
  std::vector<std::string> common;
  for (const std::string& path : all) {
    if (EachHas(cell, path)) common.push_back(path);
  }
  const bool enough = common.size() <= kMostInLabel && CountDistinct(cell, common) == cell.size();
  return enough ? common : Separating(cell, all);
}

/// Labels the groups that share object, gain and planner. Returns a line on differences that no label shows;
/// parameters that only one of two mappers has go with the mapper's name.
std::string LabelCell(const Cell& cell) {
  if (cell.size() < 2) return "";
  const std::vector<std::string> all = DifferingIn(cell), shown = LabellingOf(cell, all);
  for (RunGroup* group : cell) group->variant = LabelOf(*group, shown);
  const auto is_shown = [&](const std::string& path) {
    return std::find(shown.begin(), shown.end(), path) != shown.end();
  };
  std::vector<std::string> rest;
  for (const std::string& path : all) {
    const std::string name = path.substr(0, path.find('.')) + ".name";
    if (!is_shown(path) && (EachHas(cell, path) || !is_shown(name))) rest.push_back(path);
  }
  if (rest.empty()) return "";
  const RunGroup& one = *cell.front();
  return fmt::format("{}, {}, {}: rows also differ in {}", one.object, one.gain, one.planner, Named(rest));
}

void LabelVariants(GroupedRuns* grouped) {
  std::vector<Cell> cells;
  for (RunGroup& group : grouped->groups) {
    auto cell = std::find_if(cells.begin(), cells.end(), [&](const Cell& c) {
      return c[0]->object == group.object && c[0]->gain == group.gain && c[0]->planner == group.planner;
    });
    if (cell == cells.end()) cell = cells.insert(cells.end(), Cell{});
    cell->push_back(&group);
  }
  for (const Cell& cell : cells) {
    if (std::string note = LabelCell(cell); !note.empty()) grouped->notes.push_back(std::move(note));
  }
}

std::string NameOf(const ReportedRun& run) {
  if (run.folder.empty()) return fmt::format("{} seed {}", run.summary.experiment, run.summary.seed);
  return (run.folder.parent_path().filename() / run.folder.filename()).string();
}

/// Runs of one object together, objects in order of first appearance.
void GatherObjects(std::vector<RunGroup>* groups) {
  std::vector<std::string> objects;
  for (const RunGroup& group : *groups) {
    if (std::find(objects.begin(), objects.end(), group.object) == objects.end())
      objects.push_back(group.object);
  }
  const auto place = [&](const RunGroup& g) { return std::find(objects.begin(), objects.end(), g.object); };
  std::stable_sort(groups->begin(), groups->end(),
                   [&](const RunGroup& a, const RunGroup& b) { return place(a) < place(b); });
}

}  // namespace

std::string ObjectOf(const RunSummary& run) {
  if (run.scene.empty() || run.scene == run.experiment) return run.experiment;
  return fs::path(run.scene).stem().string();
}

ReportedRun RunOfSummary(const RunSummary& s) {
  ReportedRun run{.folder = {}, .summary = s};
  const auto add = [&run](const char* path, const std::string& value) {
    if (!value.empty()) run.settings[path] = value;
  };
  add("scene.name", s.scene.empty() ? s.experiment : s.scene);
  add("robot.name", s.robot);
  add("locomotion.name", s.locomotion);
  add("mapper.name", s.mapper);
  add("planner.name", s.planner);
  add("planner.gain", s.gain);
  add("commit", s.commit);
  add("version", s.version);
  return run;
}

ReportedRun LoadReportedRun(const fs::path& folder) {
  ReportedRun run = RunOfSummary(LoadRunSummary(folder));
  run.folder = folder;
  std::error_code error;
  if (!fs::exists(folder / "config.yaml", error)) return run;
  const RunSettings known = run.settings;
  run.settings = ReadSettings(folder / "config.yaml");
  run.settings.insert(known.begin(), known.end());  // keeps what config.yaml says
  // Contents count, not where their files lie.
  if (!run.summary.scene_hash.empty()) run.settings["scene.name"] = run.summary.scene_hash;
  if (!run.summary.robot_hash.empty()) run.settings["robot.name"] = run.summary.robot_hash;
  return run;
}

SampleStatistics RunGroup::Over(const std::string& number) const {
  std::vector<double> values;
  for (const ReportedRun& run : runs) {
    if (const auto value = run.summary.Number(number)) values.push_back(*value);
  }
  return Describe(values);
}

int RunGroup::CountOf(RunStatus status) const {
  return static_cast<int>(std::count_if(
      runs.begin(), runs.end(), [&](const ReportedRun& run) { return run.summary.status == status; }));
}

std::string RunGroup::Method() const {
  return variant.empty() ? planner : planner + " " + variant;
}

GroupedRuns GroupRuns(const std::vector<ReportedRun>& runs) {
  GroupedRuns grouped;
  std::vector<std::string> unfinished, repeated;
  for (const ReportedRun& run : runs) {
    const RunSummary& s = run.summary;
    if (runs.size() > 1 && !IsFinal(s.status)) {
      unfinished.push_back(fmt::format("{} ({})", NameOf(run), NameOf(s.status)));
      grouped.left_out.push_back(run);
      continue;
    }
    auto group = std::find_if(grouped.groups.begin(), grouped.groups.end(), [&](const RunGroup& g) {
      return g.object == ObjectOf(s) && g.settings == run.settings;
    });
    if (group == grouped.groups.end()) {
      grouped.groups.push_back(
          {.object = ObjectOf(s), .gain = s.gain, .planner = s.planner, .settings = run.settings});
      group = grouped.groups.end() - 1;
    }
    const bool again = std::any_of(group->runs.begin(), group->runs.end(),
                                   [&](const ReportedRun& r) { return r.summary.seed == s.seed; });
    if (again) {
      repeated.push_back(NameOf(run));
      grouped.left_out.push_back(run);
    } else {
      group->runs.push_back(run);
    }
  }
  GatherObjects(&grouped.groups);
  if (!unfinished.empty()) grouped.notes.push_back("left out, no result: " + Named(unfinished));
  if (!repeated.empty())
    grouped.notes.push_back("left out, same configuration and seed as another: " + Named(repeated));
  LabelVariants(&grouped);
  return grouped;
}

}  // namespace atlas::experiments
