#include "experiments/report/thesis_anchors.h"

namespace atlas::experiments {

const std::vector<ThesisRow>& ThesisRows() {
  static const std::vector<ThesisRow> rows = {
      {"3.1", "car", "occlusion_aware", 69.69, 35.39, 8, 482, 2.70},
      {"3.1", "car", "rear_side_entropy", 69.01, 40.18, 10, 621, 2.46},
      {"3.1", "house", "occlusion_aware", 59.41, 42.89, 12, 606, 3.78},
      {"3.1", "house", "rear_side_entropy", 58.98, 44.64, 12, 677, 3.65},
      {"3.1", "facade", "occlusion_aware", 95.11, 33.98, 9, 464, 17.82},
      {"3.1", "facade", "rear_side_entropy", 94.24, 37.82, 9, 501, 19.69},
      {"3.1", "helicopter", "occlusion_aware", 83.76, 41.56, 12, 746, 5.45},
      {"3.1", "helicopter", "rear_side_entropy", 83.01, 43.61, 13, 786, 5.20},
      {"3.2", "facade_grass", "occlusion_aware", 88.06, 37.61, 15, 1256, 9.82},
      {"3.2", "helicopter_grating", "occlusion_aware", 78.60, 49.19, 26, 2125, 2.00},
  };
  return rows;
}

std::optional<ThesisRow> FindThesisRow(const std::string& experiment, const std::string& gain) {
  for (const ThesisRow& row : ThesisRows()) {
    if (row.experiment == experiment && gain.starts_with(row.gain)) return row;
  }
  return std::nullopt;
}

}  // namespace atlas::experiments
