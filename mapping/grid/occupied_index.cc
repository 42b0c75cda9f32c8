#include "mapping/grid/occupied_index.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace atlas::mapping {
namespace {

constexpr double kBucket_m = 0.5;

}  // namespace

OccupiedIndex::OccupiedIndex(const core::Box3& region) : region_(region) {
  for (int a = 0; a < 3; ++a) {
    size_[static_cast<size_t>(a)] = std::max(1, static_cast<int>(std::ceil(region.Size()[a] / kBucket_m)));
  }
  Build({});
}

size_t OccupiedIndex::BucketOf(const core::Vec3f& p) const {
  size_t index = 0;
  for (int a = 2; a >= 0; --a) {
    const int n = size_[static_cast<size_t>(a)];
    const int cell = static_cast<int>((static_cast<double>(p[a]) - region_.min[a]) / kBucket_m);
    index = index * static_cast<size_t>(n) + static_cast<size_t>(std::clamp(cell, 0, n - 1));
  }
  return index;
}

void OccupiedIndex::Build(std::vector<core::Vec3f> centers) {
  centers_ = std::move(centers);
  const size_t buckets =
      static_cast<size_t>(size_[0]) * static_cast<size_t>(size_[1]) * static_cast<size_t>(size_[2]);
  begin_.assign(buckets + 1, 0);
  for (const core::Vec3f& p : centers_) ++begin_[BucketOf(p) + 1];
  for (size_t b = 0; b < buckets; ++b) begin_[b + 1] += begin_[b];
  sorted_.resize(centers_.size());
  std::vector<uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (const core::Vec3f& p : centers_) sorted_[next[BucketOf(p)]++] = p;
}

double OccupiedIndex::DistanceTo(const core::Vec3& p_map, double limit_m) const {
  double best_squared = limit_m * limit_m;
  int lo[3], hi[3];
  for (int a = 0; a < 3; ++a) {
    const double local = p_map[a] - region_.min[a];
    const int n = size_[static_cast<size_t>(a)];
    lo[a] = std::clamp(static_cast<int>(std::floor((local - limit_m) / kBucket_m)), 0, n - 1);
    hi[a] = std::clamp(static_cast<int>(std::floor((local + limit_m) / kBucket_m)), 0, n - 1);
  }
  const core::Vec3f p = p_map.cast<float>();
  for (int k = lo[2]; k <= hi[2]; ++k) {
    for (int j = lo[1]; j <= hi[1]; ++j) {
      const size_t row = static_cast<size_t>(size_[0]) *
                         (static_cast<size_t>(j) + static_cast<size_t>(size_[1]) * static_cast<size_t>(k));
      const uint32_t begin = begin_[row + static_cast<size_t>(lo[0])];
      const uint32_t end = begin_[row + static_cast<size_t>(hi[0]) + 1];
      for (uint32_t i = begin; i < end; ++i) {
        best_squared = std::min(best_squared, static_cast<double>((sorted_[i] - p).squaredNorm()));
      }
    }
  }
  return std::sqrt(best_squared);
}

}  // namespace atlas::mapping
