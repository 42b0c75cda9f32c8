#include <cmath>

#include "core/catalog.h"
#include "planner/gain/entries.h"
#include "planner/gain/voxel_math.h"

namespace atlas::planner {

double Entropy(double p) {
  if (p <= 0.0 || p >= 1.0) return 0.0;
  return -p * std::log(p) - (1.0 - p) * std::log1p(-p);
}

const EntropyTable& EntropyTable::Instance() {
  static const EntropyTable table;
  return table;
}

EntropyTable::EntropyTable() {
  for (int i = 0; i < kCells + 2; ++i)
    value_[static_cast<size_t>(i)] = Entropy(static_cast<double>(i) / kCells);
}

double EntropyTable::Exact(double p) {
  return Entropy(p);
}

const std::vector<GainEntry>& GainCatalog() {
  static const std::vector<GainEntry> catalog = {
#define ATLAS_GAIN(Name) Name##Gain(),
#include "planner/gain/catalog.inc"
#undef ATLAS_GAIN
  };
  return catalog;
}

std::vector<std::string> GainNames() {
  return core::NamesOf(GainCatalog());
}

const GainEntry& FindGain(const std::string& name) {
  return core::EntryNamed(GainCatalog(), "gain", name);
}

}  // namespace atlas::planner
