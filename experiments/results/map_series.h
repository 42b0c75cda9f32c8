// How a map grows over a run: series.csv, a row a keyframe, for plots of memory and submaps over scans
// (thesis Fig. 4.15, 4.16, 4.22).
#pragma once

#include <optional>
#include <string>

#include "mapping/map.h"

namespace atlas::experiments {

inline constexpr const char* kMapSeriesFile = "series.csv";

class MapSeries {
 public:
  /// After a revolution of `keyframe` has been integrated; a keyframe's first makes a row.
  void Observe(const mapping::Map& map, core::KeyframeId keyframe);
  /// keyframe,revolutions,submaps,map_bytes
  std::string Csv() const { return std::string(kHeader) + rows_; }

 private:
  static constexpr const char* kHeader = "keyframe,revolutions,submaps,map_bytes\n";
  size_t revolutions_ = 0;
  std::optional<core::KeyframeId> latest_;
  std::string rows_;
};

}  // namespace atlas::experiments
