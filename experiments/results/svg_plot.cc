#include "experiments/results/svg_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace atlas::experiments {
namespace {

// Colours told apart by readers with any colour vision (Okabe and Ito), darkest first.
constexpr std::array<const char*, 7> kPalette = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                 "#E69F00", "#56B4E9", "#4D4D4D"};
constexpr double kLeft = 68, kRight = 20, kTop = 46, kBottom = 56;
constexpr double kLegendRow = 18;

struct Axis {
  double lo = 0.0, hi = 1.0;      // data
  double begin = 0.0, end = 1.0;  // pixels
  std::vector<double> ticks;

  double Pixel(double value) const { return begin + (value - lo) / (hi - lo) * (end - begin); }
};

struct Frame {
  Axis x, y;
};

std::pair<double, double> DataRange(const std::vector<PlotSeries>& series, bool along_x) {
  double lo = std::numeric_limits<double>::infinity(), hi = -lo;
  const auto extend = [&](const std::vector<double>& values) {
    for (const double v : values) {
      if (!std::isfinite(v)) continue;
      lo = std::min(lo, v);
      hi = std::max(hi, v);
    }
  };
  for (const PlotSeries& s : series) {
    extend(along_x ? s.x : s.y);
    if (!along_x) extend(s.y_low);
    if (!along_x) extend(s.y_high);
  }
  return lo <= hi ? std::pair(lo, hi) : std::pair(0.0, 1.0);
}

Axis MakeAxis(std::pair<double, double> range, bool fixed, bool integers, int count) {
  if (range.first >= range.second) range.second = range.first + 1.0;
  Axis axis{.lo = range.first, .hi = range.second, .begin = 0.0, .end = 1.0, .ticks = {}};
  axis.ticks = RoundTicks(axis.lo, axis.hi, count, integers);
  if (!fixed && !integers && axis.ticks.size() > 1) {
    const double step = axis.ticks[1] - axis.ticks[0];
    axis.lo = std::floor(axis.lo / step + 1e-9) * step;
    axis.hi = std::ceil(axis.hi / step - 1e-9) * step;
    axis.ticks = RoundTicks(axis.lo, axis.hi, count, integers);
  }
  return axis;
}

std::string TickLabel(double value, double step) {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 6);
  return fmt::format("{:.{}f}", std::abs(value) < 1e-12 ? 0.0 : value, decimals);
}

void DrawAxes(const Frame& frame, const PlotOptions& options, std::string* svg) {
  const auto& [x, y] = frame;
  const auto step_of = [](const Axis& a) { return a.ticks.size() > 1 ? a.ticks[1] - a.ticks[0] : 1.0; };
  *svg += "<g stroke=\"#e3e3e3\" stroke-width=\"1\">\n";
  for (const double t : y.ticks) {
    *svg += fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>\n", x.begin,
                        y.Pixel(t), x.end, y.Pixel(t));
  }
  *svg += "</g>\n<g stroke=\"#333\" stroke-width=\"1.2\" fill=\"none\">\n";
  *svg += fmt::format("<path d=\"M{:.1f} {:.1f}V{:.1f}H{:.1f}\"/>\n", x.begin, y.end, y.begin, x.end);
  for (const double t : x.ticks) *svg += fmt::format("<path d=\"M{:.1f} {:.1f}v5\"/>\n", x.Pixel(t), y.begin);
  for (const double t : y.ticks)
    *svg += fmt::format("<path d=\"M{:.1f} {:.1f}h-5\"/>\n", x.begin, y.Pixel(t));
  *svg += "</g>\n<g font-size=\"12\" fill=\"#333\">\n";
  for (const double t : x.ticks) {
    *svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n", x.Pixel(t),
                        y.begin + 20, TickLabel(t, step_of(x)));
  }
  for (const double t : y.ticks) {
    *svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", x.begin - 9,
                        y.Pixel(t) + 4, TickLabel(t, step_of(y)));
  }
  *svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"13\" text-anchor=\"middle\">{}</text>\n",
                      0.5 * (x.begin + x.end), y.begin + 42, EscapeXml(options.x_label));
  *svg += fmt::format(
      "<text transform=\"translate(20 {:.1f}) rotate(-90)\" font-size=\"13\" "
      "text-anchor=\"middle\">{}</text>\n",
      0.5 * (y.begin + y.end), EscapeXml(options.y_label));
  *svg += fmt::format("<text x=\"{:.1f}\" y=\"26\" font-size=\"15\" font-weight=\"600\">{}</text>\n</g>\n",
                      x.begin, EscapeXml(options.title));
}

const char* ColorOf(const PlotSeries& s, size_t position) {
  return kPalette[(s.color >= 0 ? static_cast<size_t>(s.color) : position) % kPalette.size()];
}

void DrawBand(const PlotSeries& s, const Frame& frame, const char* color, std::string* svg) {
  if (s.y_low.size() != s.x.size() || s.y_high.size() != s.x.size() || s.x.size() < 2) return;
  std::string path;
  for (size_t i = 0; i < s.x.size(); ++i) {
    path +=
        fmt::format("{}{:.1f} {:.1f}", i == 0 ? "M" : "L", frame.x.Pixel(s.x[i]), frame.y.Pixel(s.y_high[i]));
  }
  for (size_t i = s.x.size(); i-- > 0;) {
    path += fmt::format("L{:.1f} {:.1f}", frame.x.Pixel(s.x[i]), frame.y.Pixel(s.y_low[i]));
  }
  *svg += fmt::format("<path d=\"{}Z\" fill=\"{}\" fill-opacity=\"0.15\" stroke=\"none\"/>\n", path, color);
}

void DrawSeries(const PlotSeries& s, const Frame& frame, const char* color, std::string* svg) {
  assert(s.x.size() == s.y.size());
  DrawBand(s, frame, color, svg);
  std::string path, dots;
  bool pen_down = false;
  for (size_t i = 0; i < s.x.size(); ++i) {
    if (!std::isfinite(s.x[i]) || !std::isfinite(s.y[i])) {
      pen_down = false;
      continue;
    }
    const double px = frame.x.Pixel(s.x[i]), py = frame.y.Pixel(s.y[i]);
    path += fmt::format("{}{:.1f} {:.1f}", pen_down ? "L" : "M", px, py);
    dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.2\"/>\n", px, py);
    pen_down = true;
  }
  if (path.empty()) return;
  *svg += fmt::format(
      "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\" stroke-linejoin=\"round\"{}/>\n", path,
      color, s.dashed ? " stroke-dasharray=\"6 4\"" : "");
  if (s.markers)
    *svg += fmt::format("<g fill=\"{}\" stroke=\"#fff\" stroke-width=\"1\">\n{}</g>\n", color, dots);
}

/// A row a series below the title, in as many columns as fit.
struct LegendLayout {
  double column_px = 0.0;
  size_t columns = 1, rows = 0;
};

LegendLayout LayOutLegend(const std::vector<PlotSeries>& series, double width_px) {
  LegendLayout layout;
  size_t longest = 0, labelled = 0;
  for (const PlotSeries& s : series) {
    longest = std::max(longest, s.label.size());
    labelled += !s.label.empty();
  }
  layout.column_px = 44.0 + 6.9 * static_cast<double>(longest);
  layout.columns = std::max<size_t>(1, static_cast<size_t>(width_px / layout.column_px));
  layout.rows = (labelled + layout.columns - 1) / layout.columns;
  return layout;
}

void DrawLegend(const std::vector<PlotSeries>& series, const LegendLayout& layout, std::string* svg) {
  size_t slot = 0;
  for (size_t i = 0; i < series.size(); ++i) {
    if (series[i].label.empty()) continue;
    const double x = kLeft + layout.column_px * static_cast<double>(slot % layout.columns);
    const double y = kTop + kLegendRow * static_cast<double>(slot / layout.columns);
    *svg += fmt::format("<path d=\"M{:.1f} {:.1f}h22\" stroke=\"{}\" stroke-width=\"2.4\"{}/>\n", x, y,
                        ColorOf(series[i], i), series[i].dashed ? " stroke-dasharray=\"6 4\"" : "");
    *svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"12\" fill=\"#333\">{}</text>\n", x + 28,
                        y + 4, EscapeXml(series[i].label));
    ++slot;
  }
}

}  // namespace

std::string EscapeXml(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      case '\'':
        safe += "&#39;";
        break;
      default:
        safe += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return safe;
}

std::vector<double> RoundTicks(double lo, double hi, int count, bool integers) {
  assert(lo < hi && count > 0);
  const double rough = (hi - lo) / count;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough * (1.0 - 1e-9)) {
      step = factor * power;
      break;
    }
  }
  if (integers) step = std::max(1.0, std::ceil(step - 1e-9));
  std::vector<double> ticks;
  for (double k = std::ceil(lo / step - 1e-9); k * step <= hi + 1e-9 * step; k += 1.0)
    ticks.push_back(k * step);
  return ticks;
}

std::string PlotSvg(const std::vector<PlotSeries>& series, const PlotOptions& options) {
  const double width = options.width_px, height = options.height_px;
  const LegendLayout legend = LayOutLegend(series, width - kLeft - kRight);
  Frame frame;
  frame.x = MakeAxis(options.x_range.value_or(DataRange(series, true)), options.x_range.has_value(),
                     options.integer_x, 8);
  frame.y =
      MakeAxis(options.y_range.value_or(DataRange(series, false)), options.y_range.has_value(), false, 5);
  const double inset = options.integer_x ? 14.0 : 0.0;  // whole-number markers stay clear of the axis
  frame.x.begin = kLeft;
  frame.x.end = width - kRight;
  frame.y.begin = height - kBottom;
  frame.y.end = kTop + kLegendRow * static_cast<double>(legend.rows) + 4.0;

  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\">\n<rect width=\"{0}\" height=\"{1}\" "
      "fill=\"#fff\"/>\n",
      options.width_px, options.height_px);
  if (inset > 0.0) {
    const double span = (frame.x.hi - frame.x.lo) / (frame.x.end - frame.x.begin - 2.0 * inset) * inset;
    frame.x.lo -= span;
    frame.x.hi += span;
  }
  DrawAxes(frame, options, &svg);
  for (size_t i = 0; i < series.size(); ++i) DrawSeries(series[i], frame, ColorOf(series[i], i), &svg);
  DrawLegend(series, legend, &svg);
  return svg + "</svg>\n";
}

}  // namespace atlas::experiments
