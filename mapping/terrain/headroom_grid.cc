#include "mapping/terrain/headroom_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace atlas::mapping::terrain {
namespace {

constexpr float kColumn_m = 0.2f;
constexpr float kBin_m = 0.125f;
constexpr float kReach_m = 8.0f;       ///< beams lie too far apart beyond
constexpr float kStep_m = 0.14f;       ///< along a ray: less than a column, and with many rays none is missed
constexpr float kEndMargin_m = 0.15f;  ///< not counted as clear: range noise, grazing ends
constexpr float kLegs_m = 0.4f;        ///< below, ground returns and steps judge
constexpr int kClearInFive = 3;        ///< of the bins, at least

int FloorToInt(float x) {
  const int toward_zero = static_cast<int>(x);  // std::floor is a call on plain x86-64
  return toward_zero - (x < static_cast<float>(toward_zero) ? 1 : 0);
}

uint64_t BitOf(int bin) {
  return uint64_t{1} << (bin & 63);
}

}  // namespace

HeadroomGrid::HeadroomGrid(double reach_m) {
  const auto side = std::bit_ceil(static_cast<unsigned>(std::ceil(reach_m / static_cast<double>(kColumn_m))));
  mask_ = static_cast<int>(side) - 1;
  columns_.resize(static_cast<size_t>(side) * side);
}

void HeadroomGrid::Mark(int ix, int iy, uint64_t bits) {
  Column& column = columns_[SlotOf(ix, iy)];
  if (column.ix != ix || column.iy != iy) column = {ix, iy, 0};
  column.seen |= bits;
}

void HeadroomGrid::AddClearRay(const core::Vec3f& origin, const core::Vec3f& direction, float clear_m) {
  const float end = std::min(clear_m - kEndMargin_m, kReach_m);
  for (float t = 0.0f; t < end; t += kStep_m) {
    const core::Vec3f p = origin + t * direction;
    Mark(FloorToInt(p.x() / kColumn_m), FloorToInt(p.y() / kColumn_m), BitOf(FloorToInt(p.z() / kBin_m)));
  }
}

void HeadroomGrid::AddClearDisc(const core::Vec2& centre, double radius_m, double low_m, double high_m) {
  uint64_t bits = 0;
  const int low = FloorToInt(static_cast<float>(low_m) / kBin_m);
  const int high = FloorToInt(static_cast<float>(high_m) / kBin_m);
  for (int bin = low; bin <= high; ++bin) bits |= BitOf(bin);
  const int cx = FloorToInt(static_cast<float>(centre.x()) / kColumn_m);
  const int cy = FloorToInt(static_cast<float>(centre.y()) / kColumn_m);
  const int reach = static_cast<int>(std::ceil(radius_m / static_cast<double>(kColumn_m)));
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      if (dx * dx + dy * dy <= reach * reach) Mark(cx + dx, cy + dy, bits);
    }
  }
}

bool HeadroomGrid::IsClear(float x, float y, float ground_m, float headroom_m) const {
  const int ix = FloorToInt(x / kColumn_m), iy = FloorToInt(y / kColumn_m);
  const Column& column = columns_[SlotOf(ix, iy)];
  if (column.ix != ix || column.iy != iy) return false;
  const int low = FloorToInt((ground_m + kLegs_m) / kBin_m),
            high = FloorToInt((ground_m + headroom_m) / kBin_m);
  int seen = 0;
  for (int bin = low; bin < high; ++bin) seen += (column.seen & BitOf(bin)) != 0;
  return 5 * seen >= kClearInFive * (high - low);
}

}  // namespace atlas::mapping::terrain
