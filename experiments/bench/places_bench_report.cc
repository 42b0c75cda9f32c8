#include <fmt/format.h>

#include <algorithm>

#include "core/files.h"
#include "experiments/bench/places_bench.h"
#include "experiments/report/text_table.h"
#include "experiments/results/svg_plot.h"

namespace atlas::experiments {
namespace {

struct NamedOffers {
  const char* name;
  const std::vector<LoopOffer>* offers;
};
std::vector<NamedOffers> OffersOf(const PlacesCase& c) {
  return {{"descriptor", &c.by_descriptor}, {"seen", &c.by_sight}, {"seen, in the gate", &c.in_gate}};
}

/// The greatest recall up to which every offer is right.
double RecallAtFullPrecision(const std::vector<PrecisionRecall>& curve) {
  double recall = 0.0;
  for (const PrecisionRecall& point : curve) {
    if (point.precision < 1.0) break;
    recall = point.recall;
  }
  return recall;
}

TextTable PlacesRows(const std::vector<PlacesCase>& cases) {
  TextTable table{{"scene", "LiDAR", "keyframes", "revisits", "loops by", "offers", "precision", "recall",
                   "recall at precision 1", "describe ms", "query ms", "checks ms"},
                  {true, true, false, false, true, false, false, false, false, false, false, false},
                  {},
                  {}};
  for (const PlacesCase& c : cases) {
    table.rules_before.push_back(table.rows.size());
    for (const NamedOffers& way : OffersOf(c)) {
      const std::vector<PrecisionRecall> curve = PrecisionRecallOf(*way.offers, c.revisits);
      const PrecisionRecall last = curve.empty() ? PrecisionRecall{} : curve.back();
      const auto offers = std::count_if(way.offers->begin(), way.offers->end(),
                                        [](const LoopOffer& o) { return o.distance <= 1.0; });
      table.rows.push_back({c.scene, c.lidar, fmt::format("{}", c.keyframes), fmt::format("{}", c.revisits),
                            way.name, fmt::format("{}", offers), fmt::format("{:.3f}", last.precision),
                            fmt::format("{:.3f}", last.recall),
                            fmt::format("{:.3f}", RecallAtFullPrecision(curve)),
                            fmt::format("{:.1f}", c.describe_ms), fmt::format("{:.1f}", c.query_ms),
                            fmt::format("{:.0f}", c.check_ms)});
    }
  }
  table.notes = {
      "revisits: keyframes within 3 m of one at least ten older. descriptor: the first candidate, right to "
      "1.5 m and 10 "
      "degrees. seen: the first of four whose registration is accepted, right to 0.2 m and 1 degree. gate: "
      "with the "
      "graph's estimate, 0.6 m and 2 degrees off."};
  return table;
}

}  // namespace

std::string PlacesTable(const std::vector<PlacesCase>& cases) {
  return ToTerminal(PlacesRows(cases));
}

void WritePlacesBench(const std::filesystem::path& folder, const std::vector<PlacesCase>& cases) {
  core::WriteFileAtomically(folder / "places.md", ToMarkdown(PlacesRows(cases)));
  core::WriteFileAtomically(folder / "places.csv", ToCsv(PlacesRows(cases)));
  std::vector<PlotSeries> series;
  for (const PlacesCase& c : cases) {
    for (const NamedOffers& way : OffersOf(c)) {
      PlotSeries line;
      line.label = c.scene + ": " + way.name;
      line.dashed = way.offers == &c.by_descriptor;
      line.markers = false;
      for (const PrecisionRecall& point : PrecisionRecallOf(*way.offers, c.revisits)) {
        line.x.push_back(point.recall);
        line.y.push_back(point.precision);
      }
      series.push_back(std::move(line));
    }
  }
  PlotOptions options;
  options.title = "Loop detection";
  options.x_label = "recall";
  options.y_label = "precision";
  options.x_range = options.y_range = std::pair{0.0, 1.02};
  core::WriteFileAtomically(folder / "places.svg", PlotSvg(series, options));
}

}  // namespace atlas::experiments
