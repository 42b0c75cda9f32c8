// Line plots as SVG: axes, round ticks, labels, legend. No dependency, the same bytes for the same data.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace atlas::experiments {

struct PlotSeries {
  std::string label = "";
  std::vector<double> x = {}, y = {};           ///< equally long; points that are not finite break the line
  std::vector<double> y_low = {}, y_high = {};  ///< shaded band where given (spread over seeds)
  bool dashed = false;
  bool markers = true;
  int color = -1;  ///< index into the palette; -1: by position
};

struct PlotOptions {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::optional<std::pair<double, double>> x_range, y_range;  ///< else from the data
  bool integer_x = false;                                     ///< ticks on whole numbers only (scans)
  int width_px = 720;
  int height_px = 440;
};

/// A complete SVG document; all text is escaped.
std::string PlotSvg(const std::vector<PlotSeries>& series, const PlotOptions& options);

/// Round tick positions covering [lo, hi] with about `count` steps of 1, 2 or 5 times a power of ten.
std::vector<double> RoundTicks(double lo, double hi, int count, bool integers);

/// &, <, >, " and ' made safe for XML.
std::string EscapeXml(const std::string& text);

}  // namespace atlas::experiments
