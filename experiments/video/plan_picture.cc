#include "experiments/video/plan_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/results/ground_plan.h"
#include "experiments/results/run_recorder.h"
#include "experiments/video/bitmap_font.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;
using core::Vec2;
using sim::Rgb;
using sim::RgbImage;

constexpr double kMargin_m = 0.5;  ///< about what is known
constexpr double kFinest_m = 0.02;
constexpr int kLongestSide = 1000;  ///< pixels of the map
constexpr int kLegendWidth = 430, kLineHeight = 22, kLetterScale = 2;
constexpr Rgb kPaper = {255, 255, 255}, kInk = {30, 30, 30}, kPath = {20, 60, 200}, kScan = {20, 20, 20},
              kBlocked = {220, 0, 160};

constexpr std::array<Rgb, kGroundCodes> kColours = {{{226, 226, 226},    // unknown
                                                     {214, 238, 205},    // free
                                                     {70, 70, 70},       // obstacle
                                                     {214, 96, 50},      // step
                                                     {238, 176, 60},     // slope
                                                     {196, 150, 106},    // roughness
                                                     {150, 24, 24},      // drop
                                                     {120, 110, 170},    // overhang
                                                     {170, 200, 220},    // cut_off
                                                     {190, 226, 160},    // tight
                                                     {250, 235, 120}}};  // narrow

class Canvas {
 public:
  Canvas(const GroundImage& ground) : ground_(ground) {
    Vec2 low = Vec2::Constant(1e9), high = Vec2::Constant(-1e9);
    for (int r = 0; r < ground.rows; ++r) {
      for (int c = 0; c < ground.cols; ++c) {
        if (At(r, c) == GroundCode::kUnknown) continue;
        const Vec2 p = ground.origin + ground.cell_m * Vec2(c + 0.5, r + 0.5);
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    }
    if (low.x() > high.x()) low = high = ground.origin;
    min_ = low - Vec2::Constant(kMargin_m);
    const Vec2 size = high + Vec2::Constant(kMargin_m) - min_;
    pixel_m_ = std::max(kFinest_m, size.maxCoeff() / kLongestSide);
    map_width_ = static_cast<int>(std::ceil(size.x() / pixel_m_));
    map_height_ = static_cast<int>(std::ceil(size.y() / pixel_m_));
    image_.width = map_width_ + kLegendWidth;
    image_.height = std::max(map_height_, (kGroundCodes + 8) * kLineHeight);
    image_.rgb.assign(3 * static_cast<size_t>(image_.width) * static_cast<size_t>(image_.height), 255);
    for (int v = 0; v < map_height_; ++v) {
      for (int u = 0; u < map_width_; ++u) Set(u, v, kColours[static_cast<size_t>(CodeAt(u, v))]);
    }
  }

  void Line(const Vec2& a, const Vec2& b, const Rgb& rgb) {
    const int steps = 1 + static_cast<int>((b - a).norm() / (0.5 * pixel_m_));
    for (int k = 0; k <= steps; ++k) Dot(a + (b - a) * (static_cast<double>(k) / steps), 1, rgb);
  }
  void Dot(const Vec2& p, int radius, const Rgb& rgb) {
    const auto [u, v] = PixelOf(p);
    for (int dv = -radius; dv <= radius; ++dv) {
      for (int du = -radius; du <= radius; ++du) {
        if (du * du + dv * dv <= radius * radius && u + du < map_width_) Set(u + du, v + dv, rgb);
      }
    }
  }
  void Cross(const Vec2& p, const Rgb& rgb) {
    const double arm = 9.0 * pixel_m_;
    Line(p + Vec2(-arm, -arm), p + Vec2(arm, arm), rgb);
    Line(p + Vec2(-arm, arm), p + Vec2(arm, -arm), rgb);
  }
  void Label(const Vec2& p, const std::string& text, const Rgb& rgb) {
    const auto [u, v] = PixelOf(p);
    DrawText(text, u + 8, v - 16, kLetterScale, rgb, &image_);
  }

  /// The next line of the legend: a swatch and its meaning.
  void Legend(const Rgb& rgb, const std::string& text, int scale = kLetterScale) {
    const int x = map_width_ + 12, y = 10 + lines_++ * kLineHeight;
    for (int v = y; v < y + 14; ++v) {
      for (int u = x; u < x + 20; ++u) Set(u, v, rgb);
    }
    DrawText(text, x + 30, y, scale, kInk, &image_);
  }
  RgbImage Take() { return std::move(image_); }
  double pixel_m() const { return pixel_m_; }

 private:
  GroundCode At(int row, int col) const {
    return ground_
        .code[static_cast<size_t>(row) * static_cast<size_t>(ground_.cols) + static_cast<size_t>(col)];
  }
  GroundCode CodeAt(int u, int v) const {
    const Vec2 p = min_ + pixel_m_ * Vec2(u + 0.5, map_height_ - v - 0.5);
    const Vec2 cell = (p - ground_.origin) / ground_.cell_m;
    const int col = static_cast<int>(std::floor(cell.x())), row = static_cast<int>(std::floor(cell.y()));
    const bool inside = col >= 0 && row >= 0 && col < ground_.cols && row < ground_.rows;
    return inside ? At(row, col) : GroundCode::kUnknown;
  }
  std::pair<int, int> PixelOf(const Vec2& p) const {
    const Vec2 at = (p - min_) / pixel_m_;
    return {static_cast<int>(std::floor(at.x())), map_height_ - 1 - static_cast<int>(std::floor(at.y()))};
  }
  void Set(int u, int v, const Rgb& rgb) {
    if (u < 0 || v < 0 || u >= image_.width || v >= image_.height) return;
    const size_t at =
        3 * (static_cast<size_t>(v) * static_cast<size_t>(image_.width) + static_cast<size_t>(u));
    for (size_t k = 0; k < 3; ++k) image_.rgb[at + k] = rgb[k];
  }

  const GroundImage& ground_;
  Vec2 min_;
  double pixel_m_ = kFinest_m;
  int map_width_ = 0, map_height_ = 0, lines_ = 0;
  RgbImage image_;
};

std::vector<Vec2> ReadPath(const fs::path& file) {
  std::istringstream text(core::ReadFile(file));
  std::vector<Vec2> path;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    std::istringstream cells(line);
    double time_s = 0.0;
    Vec2 p;
    if (line.empty() || line.starts_with("#")) continue;
    if (!(cells >> time_s >> p.x() >> p.y()))
      throw core::InputError(fmt::format("{}:{}: expected time x y z qx qy qz qw", file.string(), number));
    path.push_back(p);
  }
  return path;
}

}  // namespace

RgbImage PlanPicture(const fs::path& run_folder) {
  const GroundImage ground = LoadGroundImage(run_folder);
  Canvas canvas(ground);
  const std::vector<Vec2> path = ReadPath(run_folder / "trajectory_truth.tum");
  for (size_t i = 1; i < path.size(); ++i) canvas.Line(path[i - 1], path[i], kPath);
  for (const Vec2& scan : LoadScanPlaces(run_folder)) canvas.Dot(scan, 5, kScan);
  for (int code = 0; code < kGroundCodes; ++code) {
    canvas.Legend(kColours[static_cast<size_t>(code)], NameOf(static_cast<GroundCode>(code)));
  }
  canvas.Legend(kPath, "way (true)");
  canvas.Legend(kScan, "scans");
  canvas.Legend(kPaper, fmt::format("100 pixels: {:.1f} m", 100.0 * canvas.pixel_m()));
  int number = 0;
  for (const planner::BlockedWay& way : LoadBlockedWays(run_folder)) {
    canvas.Cross(way.p_map, kBlocked);
    canvas.Label(way.p_map, std::to_string(++number), kBlocked);
    const std::string worth =
        way.worth_share ? fmt::format(", worth {:.0f} %", 100.0 * *way.worth_share) : "";
    canvas.Legend(kBlocked, fmt::format("{}: {}{}", number, TextOf(way), worth), 1);
  }
  return canvas.Take();
}

}  // namespace atlas::experiments
