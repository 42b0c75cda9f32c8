#include "experiments/video/atlas_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/video/bitmap_font.h"

namespace atlas::experiments {
namespace {

using core::Vec2;
using core::Vec3;
using sim::Rgb;
using sim::RgbImage;

constexpr double kAboveGround_m = 0.6, kFinestPixel_m = 0.03, kFloorGap_m = 2.0;
constexpr size_t kLeastShare = 12;  ///< of all nodes, as its inverse
constexpr int kLongestPanel = 1100, kPanelGap = 20, kHeader = 26;
constexpr Rgb kBlank = {255, 255, 255}, kFreeSpace = {240, 240, 240}, kLoopLine = {220, 30, 30},
              kEdgeLine = {60, 60, 60}, kWayLine = {20, 60, 220}, kText = {30, 30, 30};

/// Hues by the golden angle, so that submaps that follow one another differ.
Rgb ColourOf(uint32_t submap, double value) {
  const double hue = std::fmod(0.13 + 0.618034 * submap, 1.0) * 6.0, saturation = 0.75;
  const auto channel = [&](double shift) {
    const double k = std::fmod(hue + shift, 6.0);
    const double v = value * (1.0 - saturation * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0));
    return static_cast<uint8_t>(std::lround(255.0 * v));
  };
  return {channel(5.0), channel(3.0), channel(1.0)};
}

/// Heights of the floors that nodes were on, lowest first: those about which most nodes lie, each at least
/// kFloorGap_m from the one before. Those of a ramp lie at all heights and make no floor.
std::vector<double> FloorsOf(const std::vector<Vec3>& nodes) {
  constexpr double kLevel_m = 0.4;
  std::vector<double> floors;
  while (true) {
    double best_z = 0.0;
    size_t most = 0;
    for (const Vec3& p : nodes) {
      const bool near_one = std::any_of(floors.begin(), floors.end(),
                                        [&](double z) { return std::abs(z - p.z()) < kFloorGap_m; });
      if (near_one) continue;
      const auto count = static_cast<size_t>(std::count_if(
          nodes.begin(), nodes.end(), [&](const Vec3& q) { return std::abs(q.z() - p.z()) < kLevel_m; }));
      if (count > most) {
        most = count;
        best_z = p.z();
      }
    }
    if (most == 0 || (!floors.empty() && kLeastShare * most < nodes.size())) break;
    floors.push_back(best_z);
  }
  std::sort(floors.begin(), floors.end());
  return floors;
}

class Panel {
 public:
  Panel(RgbImage* image, int left, const core::Box3& box, double pixel_m, int height)
      : image_(*image), left_(left), box_(box), pixel_m_(pixel_m), height_(height) {}

  void Slice(const mapping::MapView& map, double z) {
    const int width = static_cast<int>(std::ceil(box_.Size().x() / pixel_m_));
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width; ++u) {
        const Vec3 p(box_.min.x() + (u + 0.5) * pixel_m_, box_.min.y() + (height_ - v - 0.5) * pixel_m_, z);
        const mapping::CellState state = map.StateAt(p);
        if (state == mapping::CellState::kUnknown) continue;
        const bool occupied = state == mapping::CellState::kOccupied;
        Set(u, v, occupied ? ColourOf(map.SubmapAt(p), 0.8) : kFreeSpace);
      }
    }
  }
  void Line(const Vec3& a, const Vec3& b, int radius, const Rgb& rgb) {
    const int steps = 1 + static_cast<int>((b - a).head<2>().norm() / (0.5 * pixel_m_));
    for (int k = 0; k <= steps; ++k) Dot(a + (b - a) * (static_cast<double>(k) / steps), radius, rgb);
  }
  void Dot(const Vec3& p, int radius, const Rgb& rgb) {
    const int u = static_cast<int>(std::floor((p.x() - box_.min.x()) / pixel_m_));
    const int v = height_ - 1 - static_cast<int>(std::floor((p.y() - box_.min.y()) / pixel_m_));
    for (int dv = -radius; dv <= radius; ++dv) {
      for (int du = -radius; du <= radius; ++du) {
        if (du * du + dv * dv <= radius * radius) Set(u + du, v + dv, rgb);
      }
    }
  }

 private:
  void Set(int u, int v, const Rgb& rgb) {
    const int x = left_ + u, y = kHeader + v;
    if (u < 0 || v < 0 || v >= height_ || x >= image_.width) return;
    const size_t at =
        3 * (static_cast<size_t>(y) * static_cast<size_t>(image_.width) + static_cast<size_t>(x));
    for (size_t k = 0; k < 3; ++k) image_.rgb[at + k] = rgb[k];
  }

  RgbImage& image_;
  int left_;
  core::Box3 box_;
  double pixel_m_;
  int height_;
};

void DrawGraph(const AtlasDrawing& drawing, double floor_z, Panel* panel) {
  const auto& nodes = drawing.nodes;
  const auto on_floor = [&](const Vec3& p) { return std::abs(p.z() - floor_z) < kFloorGap_m; };
  for (size_t i = 1; i < nodes.size(); ++i) {
    if (on_floor(nodes[i - 1]) && on_floor(nodes[i])) panel->Line(nodes[i - 1], nodes[i], 0, kEdgeLine);
  }
  for (const auto& [a, b] : drawing.loops) {
    if (a >= nodes.size() || b >= nodes.size()) continue;
    if (on_floor(nodes[a]) && on_floor(nodes[b])) panel->Line(nodes[a], nodes[b], 1, kLoopLine);
  }
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (!on_floor(nodes[i])) continue;
    panel->Dot(nodes[i], 5, kEdgeLine);
    panel->Dot(nodes[i], 4, ColourOf(drawing.submap[i], 1.0));
  }
  for (size_t i = 1; i < drawing.way.size(); ++i) {
    if (on_floor(drawing.way[i])) panel->Line(drawing.way[i - 1], drawing.way[i], 2, kWayLine);
  }
}

}  // namespace

RgbImage AtlasPicture(const AtlasDrawing& drawing) {
  // A way lies on the ground, nodes where the body is: the slice is to pass over the one and through the
  // other.
  const bool planned = !drawing.way.empty();
  std::vector<double> floors = FloorsOf(planned ? drawing.way : drawing.nodes);
  for (double& z : floors) z += planned ? kAboveGround_m : 0.0;
  const Vec2 size = drawing.box_map.Size().head<2>();
  const double pixel_m = std::max(kFinestPixel_m, size.maxCoeff() / kLongestPanel);
  const int width = static_cast<int>(std::ceil(size.x() / pixel_m)),
            height = static_cast<int>(std::ceil(size.y() / pixel_m));
  const auto panels = static_cast<int>(std::max<size_t>(1, floors.size()));
  RgbImage image;
  image.width = panels * (width + kPanelGap);
  image.height = height + kHeader;
  image.rgb.assign(3 * static_cast<size_t>(image.width) * static_cast<size_t>(image.height), kBlank[0]);
  for (size_t k = 0; k < floors.size(); ++k) {
    const int left = static_cast<int>(k) * (width + kPanelGap);
    Panel panel(&image, left, drawing.box_map, pixel_m, height);
    panel.Slice(*drawing.map, floors[k]);
    DrawGraph(drawing, floors[k], &panel);
    DrawText(fmt::format("z {:.1f} m, 100 pixels {:.1f} m", floors[k], 100.0 * pixel_m), left + 6, 6, 2,
             kText, &image);
  }
  return image;
}

}  // namespace atlas::experiments
