// What stands under a table: the words of the summaries that it holds.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <set>

#include "experiments/report/table_columns.h"
#include "experiments/report/tables.h"

namespace atlas::experiments {
namespace {

/// "egl", or "egl | osmesa" where runs of the group differ.
std::string WordOf(const RunGroup& group, std::string RunSummary::*word) {
  std::set<std::string> values;
  for (const ReportedRun& run : group.runs) values.insert(run.summary.*word);
  std::string text;
  for (const std::string& value : values) {
    text += (text.empty() ? "" : " | ") + (value.empty() ? std::string("none named") : value);
  }
  return text;
}

/// "11-15", "1, 3, 4".
std::string SeedsOf(const RunGroup& group) {
  std::set<uint64_t> seeds;
  for (const ReportedRun& run : group.runs) seeds.insert(run.summary.seed);
  if (seeds.size() > 2 && *seeds.rbegin() - *seeds.begin() + 1 == seeds.size()) {
    return fmt::format("{}-{}", *seeds.begin(), *seeds.rbegin());
  }
  return fmt::format("{}", fmt::join(seeds, ", "));
}

/// Whether each row's variant says it already ("mapper=octomap").
bool LabelsSay(std::string_view word, const std::vector<RunGroup>& groups,
               const std::vector<std::string>& values) {
  for (size_t i = 0; i < groups.size(); ++i) {
    const std::string label = " " + groups[i].variant + " ";
    if (label.find(fmt::format(" {}={} ", word, values[i])) == std::string::npos) return false;
  }
  return true;
}

using Namer = std::string (*)(const RunGroup&);

/// The shortest way to name rows by which `values`, one a group, can be told.
Namer NamerFor(const std::vector<RunGroup>& groups, const std::vector<std::string>& values) {
  const std::vector<Namer> namers = {
      [](const RunGroup& g) { return g.planner; }, [](const RunGroup& g) { return g.object; },
      [](const RunGroup& g) { return g.variant; }, [](const RunGroup& g) { return g.Method(); },
      [](const RunGroup& g) { return g.object + " " + g.Method(); }};
  for (const Namer namer : namers) {
    std::map<std::string, std::string> value_of;
    bool tells = true;
    for (size_t i = 0; i < groups.size(); ++i) {
      const std::string name = namer(groups[i]);
      tells = tells && !name.empty() && value_of.emplace(name, values[i]).first->second == values[i];
    }
    if (tells) return namer;
  }
  return [](const RunGroup& g) { return g.object + " " + g.gain + " " + g.Method(); };
}

/// "deviations: thesis: no blacklist; greedy: none named".
std::string ByRow(std::string_view word, const std::vector<RunGroup>& groups,
                  const std::vector<std::string>& values) {
  const Namer namer = NamerFor(groups, values);
  std::string line(word);
  std::set<std::string> told;
  for (size_t i = 0; i < groups.size(); ++i) {
    if (!told.insert(values[i]).second) continue;
    std::string names;
    std::set<std::string> named;
    for (size_t j = i; j < groups.size(); ++j) {
      const std::string name = namer(groups[j]);
      if (values[j] == values[i] && named.insert(name).second) names += (names.empty() ? "" : ", ") + name;
    }
    line += fmt::format("{} {}: {}", i == 0 ? ":" : ";", names, values[i]);
  }
  return line;
}

}  // namespace

std::vector<std::string> WordNotes(const std::vector<RunGroup>& groups) {
  std::vector<std::string> notes;
  if (groups.empty()) return notes;
  std::string common;
  const auto tell = [&](std::string_view word, const std::vector<std::string>& values) {
    if (std::set<std::string>(values.begin(), values.end()).size() == 1) {
      common += fmt::format("{}{}: {}", common.empty() ? "" : "; ", word, values.front());
    } else if (!LabelsSay(word, groups, values)) {
      notes.push_back(ByRow(word, groups, values));
    }
  };
  std::vector<std::string> seeds;
  for (const RunGroup& group : groups) seeds.push_back(SeedsOf(group));
  tell("seeds", seeds);
  for (const auto& [word, member] : SummaryWords()) {
    if (IsColumnOrHash(word)) continue;
    std::vector<std::string> values;
    bool any = false;
    for (const RunGroup& group : groups) {
      values.push_back(WordOf(group, member));
      any = any || values.back() != "none named";
    }
    if (any) tell(word, values);
  }
  if (!common.empty()) notes.insert(notes.begin(), (groups.size() > 1 ? "all rows: " : "") + common);
  return notes;
}

}  // namespace atlas::experiments
