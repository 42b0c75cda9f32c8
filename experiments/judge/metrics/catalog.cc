#include "experiments/judge/metrics/entries.h"

namespace atlas::experiments {
namespace {

std::vector<core::Column> AllOf(std::vector<core::Column> MetricEntry::*part) {
  std::vector<core::Column> all;
  for (const MetricEntry& entry : MetricCatalog()) {
    all.insert(all.end(), (entry.*part).begin(), (entry.*part).end());
  }
  return all;
}

}  // namespace

const std::vector<MetricEntry>& MetricCatalog() {
  static const std::vector<MetricEntry> catalog = {
#define ATLAS_METRIC(Name) Name##Metric(),
#include "experiments/judge/metrics/catalog.inc"
#undef ATLAS_METRIC
  };
  return catalog;
}

std::vector<core::Column> StepColumns() {
  return AllOf(&MetricEntry::steps);
}
std::vector<core::Column> TimesColumns() {
  return AllOf(&MetricEntry::times);
}
std::vector<core::Column> SummaryColumns() {
  return AllOf(&MetricEntry::summary);
}

}  // namespace atlas::experiments
