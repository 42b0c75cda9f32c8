// The columns of result tables, one declaration each.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "experiments/report/run_groups.h"
#include "experiments/report/thesis_anchors.h"

namespace atlas::experiments {

struct Column {
  enum class Use { kAlways, kWhereMeasured, kGroups, kRuns };  ///< the last two: of one kind of table

  std::string heading;
  std::string meaning;  ///< for the line of terms; empty where the heading says it
  bool left = false;
  Use use = Use::kAlways;
  std::string number;  ///< the key of summary.json that it shows; empty where it shows none
  std::string (*of_group)(const RunGroup& group, const std::string& number) = nullptr;
  std::string (*of_thesis)(const ThesisRow& row) = nullptr;  ///< null: the thesis has no such number

  std::string Of(const RunGroup& group) const { return of_group(group, number); }
};
const std::vector<Column>& TableColumns();

/// What stands where nothing was measured.
inline constexpr const char* kNotMeasured = "-";

/// One value: itself; two: their mean and both; from three on the mean and the half width of its 95 %
/// confidence interval.
std::string MeanWithInterval(const SampleStatistics& s, const std::function<std::string(double)>& text);

/// The text keys of summary.json, in its order.
const std::vector<std::pair<std::string_view, std::string RunSummary::*>>& SummaryWords();
/// Those that are columns of their own, or only tell whether two configurations are the same.
bool IsColumnOrHash(std::string_view word);

}  // namespace atlas::experiments
