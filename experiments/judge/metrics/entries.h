// One function a metric, each defined in the metric's own file.
#pragma once

#include "experiments/judge/metric.h"

namespace atlas::experiments {

#define ATLAS_METRIC(Name) MetricEntry Name##Metric();
#include "experiments/judge/metrics/catalog.inc"
#undef ATLAS_METRIC

template <typename M>
std::unique_ptr<Metric> BuildMetric(const MetricSetup&) {
  return std::make_unique<M>();
}

}  // namespace atlas::experiments
