#include "mapping/terrain/layered_grid.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace atlas::mapping::terrain {
namespace {

constexpr float kNoHeight = std::numeric_limits<float>::quiet_NaN();
/// The mean never becomes surer than 4 mm, so that it follows the slow motion of the map frame.
constexpr float kMaxInfo = 1.0f / (0.004f * 0.004f);

bool Joins(const Layer& layer, float z_m) {
  if (layer.hi_m - layer.lo_m > kTall_m) {
    return z_m >= layer.lo_m - kLayerGate_m && z_m <= layer.hi_m + kLayerGate_m;
  }
  return std::abs(z_m - layer.mean_m) <= kLayerGate_m;
}

void Fuse(Layer* layer, float z_m, float info, int count) {
  const float prior = static_cast<float>(layer->info);
  layer->mean_m += (z_m - layer->mean_m) * info / (prior + info);
  layer->info = static_cast<uint16_t>(std::min(prior + info, kMaxInfo));
  layer->lo_m = std::min(layer->lo_m, z_m);
  layer->hi_m = std::max(layer->hi_m, z_m);
  layer->count = static_cast<uint16_t>(std::min(60000, layer->count + count));
}

/// Joins the two layers with the least space between them and frees the second; returns the freed one.
Layer* MergeNearest(LayeredCell* cell) {
  auto& layers = cell->layer;
  std::sort(layers.begin(), layers.end(), [](const Layer& a, const Layer& b) { return a.lo_m < b.lo_m; });
  size_t best = 0;
  float least = std::numeric_limits<float>::infinity();
  for (size_t i = 0; i + 1 < layers.size(); ++i) {
    const float space = layers[i + 1].lo_m - layers[i].hi_m;
    if (space < least) {
      least = space;
      best = i;
    }
  }
  Layer& low = layers[best];
  Layer& high = layers[best + 1];
  const float sum = static_cast<float>(low.info) + static_cast<float>(high.info) + 1e-6f;
  low.mean_m += (high.mean_m - low.mean_m) * static_cast<float>(high.info) / sum;
  low.hi_m = std::max(low.hi_m, high.hi_m);
  low.count = static_cast<uint16_t>(std::min(60000, low.count + high.count));
  low.info = std::max(low.info, high.info);
  high = Layer{};
  return &high;
}

}  // namespace

LayeredGrid::LayeredGrid(double cell_m, int side_cells)
    : cell_m_(cell_m), inverse_cell_(1.0 / cell_m), side_(side_cells) {
  assert(side_cells > 0);
  const size_t count = static_cast<size_t>(side_) * static_cast<size_t>(side_);
  cells_.resize(count);
  crossings_.resize(count);
  assumed_m_.resize(count);
  reference_m_.resize(count);
  Clear();
}

void LayeredGrid::ClearSlot(size_t slot) {
  cells_[slot] = LayeredCell{};
  crossings_[slot] = 0;
  assumed_m_[slot] = kNoHeight;
  reference_m_[slot] = kNoHeight;
}

void LayeredGrid::Clear() {
  for (size_t slot = 0; slot < cells_.size(); ++slot) ClearSlot(slot);
}

void LayeredGrid::CenterOn(int ix, int iy) {
  const int new_x = ix - side_ / 2, new_y = iy - side_ / 2;
  const int dx = new_x - min_x_, dy = new_y - min_y_;
  if (std::abs(dx) >= side_ || std::abs(dy) >= side_) {
    Clear();
    min_x_ = new_x;
    min_y_ = new_y;
    return;
  }
  // The columns and rows that the window leaves hold, once it has moved, those that it enters.
  const int left = dx > 0 ? min_x_ : min_x_ + side_ + dx;
  for (int x = left; x < left + std::abs(dx); ++x) {
    for (int y = min_y_; y < min_y_ + side_; ++y) ClearSlot(Slot(x, y));
  }
  const int low = dy > 0 ? min_y_ : min_y_ + side_ + dy;
  for (int y = low; y < low + std::abs(dy); ++y) {
    for (int x = min_x_; x < min_x_ + side_; ++x) ClearSlot(Slot(x, y));
  }
  shift_x_ = (shift_x_ + dx + side_) % side_;
  shift_y_ = (shift_y_ + dy + side_) % side_;
  min_x_ = new_x;
  min_y_ = new_y;
}

void LayeredGrid::AddHeight(size_t slot, float z_m, float variance_m2, int count) {
  const float info = 1.0f / variance_m2;
  Layer* nearest = nullptr;
  Layer* unused = nullptr;
  float nearest_m = std::numeric_limits<float>::infinity();
  for (Layer& layer : cells_[slot].layer) {
    if (layer.count == 0) {
      unused = &layer;
      break;
    }
    if (Joins(layer, z_m) && std::abs(z_m - layer.mean_m) < nearest_m) {
      nearest = &layer;
      nearest_m = std::abs(z_m - layer.mean_m);
    }
  }
  if (nearest == nullptr) {
    nearest = unused != nullptr ? unused : MergeNearest(&cells_[slot]);
    *nearest = Layer{.mean_m = z_m, .lo_m = z_m, .hi_m = z_m};
  }
  Fuse(nearest, z_m, info, count);
}

}  // namespace atlas::mapping::terrain
