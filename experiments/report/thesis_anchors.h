// The thesis's measured rows (Tables 3.1 and 3.2), to stand beside ours.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace atlas::experiments {

struct ThesisRow {
  std::string_view table;       ///< "3.1" simulation, "3.2" real world
  std::string_view experiment;  ///< ours that stands beside it
  std::string_view gain;
  double coverage_percent;
  double travel_distance_m;
  int scans;
  int time_s;
  double nbv_time_s;
};

const std::vector<ThesisRow>& ThesisRows();
/// The row for an experiment and gain, if the thesis has one. Variants of a gain
/// ("occlusion_aware_normalised") stand beside the row of the gain they derive from.
std::optional<ThesisRow> FindThesisRow(const std::string& experiment, const std::string& gain);

}  // namespace atlas::experiments
