#include "experiments/report/mapper_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "experiments/report/table_columns.h"
#include "experiments/report/tables.h"

namespace atlas::experiments {
namespace {

constexpr const char* kMapper = "se_atlas";

const std::string& MapperOf(const RunGroup& group) {
  return group.runs.front().summary.mapper;
}

bool DifferInMapperOnly(const RunGroup& a, const RunGroup& b) {
  if (a.object != b.object || MapperOf(a) == MapperOf(b)) return false;
  const std::vector<std::string> paths = DifferingPaths(a.settings, b.settings);
  return std::all_of(paths.begin(), paths.end(), [&](const std::string& path) {
    const bool one_sided = a.settings.contains(path) != b.settings.contains(path);
    return path == "mapper.name" || (one_sided && path.starts_with("mapper."));
  });
}

/// The variant less the mapper's name, which has a column.
std::string VariantBesideMapper(const RunGroup& group) {
  const std::string name = "mapper=" + MapperOf(group);
  std::string variant = group.variant;
  const size_t at = variant.find(name);
  if (at == std::string::npos) return variant;
  variant.erase(at > 0 ? at - 1 : at, name.size() + 1);  // and the space beside it
  return variant;
}

/// What pairs of runs differ in, a value a pair.
struct Differences {
  std::vector<double> at_end, at_equal_scans, scans;
  std::array<std::vector<double>, kPairRatios.size()> ratios;

  static void AddRatio(std::optional<double> a, std::optional<double> b, std::vector<double>* to) {
    if (a && b && *b > 0.0) to->push_back(*a / *b);
  }
  void Add(const ReportedRun& atlas, const ReportedRun& other) {
    const auto &a = atlas.curve.coverage, &b = other.curve.coverage;
    const size_t both = std::min(a.size(), b.size());
    at_end.push_back(100.0 * (a.back() - b.back()));
    at_equal_scans.push_back(100.0 * (a[both - 1] - b[both - 1]));
    scans.push_back(static_cast<double>(a.size()) - static_cast<double>(b.size()));
    for (size_t k = 0; k < ratios.size(); ++k) {
      const std::string number = kPairRatios[k].number;
      AddRatio(atlas.summary.Number(number), other.summary.Number(number), &ratios[k]);
    }
  }
};

Differences PairsOf(const RunGroup& atlas, const RunGroup& other) {
  Differences differences;
  for (const ReportedRun& a : atlas.runs) {
    for (const ReportedRun& b : other.runs) {
      const bool drawn = !a.curve.coverage.empty() && !b.curve.coverage.empty();
      if (drawn && a.summary.seed == b.summary.seed) differences.Add(a, b);
    }
  }
  return differences;
}

std::string Signed(const std::vector<double>& values, int decimals) {
  return MeanWithInterval(Describe(values), [=](double v) { return fmt::format("{:+.{}f}", v, decimals); });
}
std::string Ratio(const std::vector<double>& values) {
  return MeanWithInterval(Describe(values), [](double v) { return fmt::format("{:.2f}", v); });
}

}  // namespace

TextTable MapperPairsTable(const std::vector<RunGroup>& groups) {
  TextTable table{
      {"object", "gain", "planner", "against", "pairs", "c_p at the end", "after equal scans", "scans"},
      {true, true, true, true},
      {},
      {}};
  for (const PairRatio& ratio : kPairRatios) table.heading.emplace_back(ratio.heading);
  table.left.resize(table.heading.size(), false);
  std::vector<RunGroup> shown;
  for (const RunGroup& atlas : groups) {
    for (const RunGroup& other : groups) {
      if (MapperOf(atlas) != kMapper || !DifferInMapperOnly(atlas, other)) continue;
      const Differences pairs = PairsOf(atlas, other);
      if (pairs.at_end.empty()) continue;
      const std::string variant = VariantBesideMapper(atlas);
      table.rows.push_back({atlas.object, atlas.gain,
                            variant.empty() ? atlas.planner : atlas.planner + " " + variant, MapperOf(other),
                            fmt::format("{}", pairs.at_end.size()), Signed(pairs.at_end, 2),
                            Signed(pairs.at_equal_scans, 2), Signed(pairs.scans, 1)});
      for (const auto& ratios : pairs.ratios) table.rows.back().push_back(Ratio(ratios));
      for (const RunGroup* group : {&atlas, &other}) shown.push_back(*group);
    }
  }
  if (table.rows.empty()) return table;
  table.notes = {
      "SE-Atlas less the other mapper, of pairs with the same seed: points of coverage, scans; ratios of "
      "times. "
      "a ± b: mean and half width of its 95 % confidence interval (t distribution); a [b, c]: of two pairs, "
      "both"};
  for (std::string& note : WordNotes(shown)) table.notes.push_back(std::move(note));
  return table;
}

}  // namespace atlas::experiments
