#include "experiments/results/map_series.h"

#include <fmt/format.h>

namespace atlas::experiments {

void MapSeries::Observe(const mapping::Map& map, core::KeyframeId keyframe) {
  ++revolutions_;
  if (latest_ == keyframe) return;
  latest_ = keyframe;
  rows_ += fmt::format("{},{},{},{}\n", keyframe, revolutions_, map.SubmapCount(), map.Bytes());
}

}  // namespace atlas::experiments
