#include "experiments/sweep/standing.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <map>

#include "core/errors.h"
#include "experiments/identity/run_settings.h"
#include "experiments/sweep/run_pool.h"

namespace atlas::experiments {
namespace fs = std::filesystem;
namespace {

constexpr size_t kMostNamed = 3;

/// "planner.nodes changed", "commit abc, now def": what tells the run in the folder from the one wanted.
std::string WhatChanged(const SweepRun& run, const RunSummary& found) {
  const RunIdentity& wanted = *run.identity;
  std::vector<std::string> changed;
  try {
    RunSettings settings = ReadSettings(run.folder / "config.yaml");
    settings["scene.name"] = found.scene_hash;
    settings["robot.name"] = found.robot_hash;
    for (std::string path : DifferingPaths(settings, wanted.settings)) {
      if (path.ends_with(".name")) path.resize(path.size() - 5);
      changed.push_back(std::move(path));
    }
  } catch (const core::InputError&) {
    changed = {"configuration"};  // it cannot be read, the hash differs
  }
  const size_t count = changed.size();
  std::string text;
  if (count > kMostNamed) {
    changed.resize(kMostNamed);
    text = fmt::format("{} and {} more changed", fmt::join(changed, ", "), count - kMostNamed);
  } else if (count > 0) {
    text = fmt::format("{} changed", fmt::join(changed, ", "));
  }
  if (found.commit != wanted.commit) {
    text += fmt::format("{}commit {}, now {}", text.empty() ? "" : "; ",
                        found.commit.empty() ? "unknown" : found.commit, wanted.commit);
  }
  return text.empty() ? "configuration changed" : text;
}

}  // namespace

RunStanding StandingOf(const SweepRun& run) {
  std::error_code error;
  if (!fs::exists(run.folder / "summary.json", error)) return {};
  RunSummary summary;
  try {
    summary = LoadRunSummary(run.folder);
  } catch (const core::InputError&) {
    return {.state = RunState::kBroken, .why = "damaged"};
  }
  if (!IsFinal(summary.status))
    return {.state = RunState::kBroken, .why = std::string(NameOf(summary.status))};
  if (EndedOtherwise(run.folder, summary.status))
    return {.state = RunState::kBroken,
            .why = fmt::format("exit code not that of {}", NameOf(summary.status))};
  const bool same = summary.config_hash == run.identity->config_hash && summary.seed == run.seed &&
                    summary.commit == run.identity->commit;
  if (same) return {.state = RunState::kDone, .summary = summary};
  return {.state = RunState::kStale, .why = WhatChanged(run, summary), .summary = summary};
}

std::string CountsText(const std::vector<RunStanding>& standings) {
  std::string text;
  for (const auto& [state, name] :
       {std::pair(RunState::kDone, "done"), std::pair(RunState::kStale, "stale"),
        std::pair(RunState::kBroken, "broken"), std::pair(RunState::kNew, "new")}) {
    int count = 0;
    std::map<std::string, int> reasons;
    for (const RunStanding& standing : standings) {
      if (standing.state != state) continue;
      ++count;
      if (!standing.why.empty()) ++reasons[standing.why];
    }
    if (count == 0) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, name);
    std::string why;
    for (const auto& [reason, times] : reasons) {
      why += (why.empty() ? "" : "; ") + (reasons.size() > 1 ? fmt::format("{}: ", times) : "") + reason;
    }
    if (!why.empty()) text += " (" + why + ")";
  }
  return text;
}

}  // namespace atlas::experiments
