#include "mapping/io/scan_from_cloud.h"

#include <cassert>

namespace atlas::mapping {
namespace {

using core::LidarScan;
using core::ReturnKind;
using core::Vec3f;

struct Return {
  ReturnKind kind;
  float range_m;       ///< 0 unless a hit
  bool has_direction;  ///< a point was measured, be it too near or too far
};

Return Judge(const RecordedCloud& cloud, size_t i, const ScanRules& rules) {
  const Vec3f& p = cloud.p_lidar[i];
  const ReturnKind told = cloud.kind.empty() ? ReturnKind::kHit : cloud.kind[i];
  if (!p.allFinite()) return {cloud.kind.empty() ? rules.no_return : told, 0.0f, false};
  if (told != ReturnKind::kHit) return {told, 0.0f, true};
  const float range = p.norm();
  if (range < static_cast<float>(rules.min_range_m)) return {ReturnKind::kDropout, 0.0f, true};
  if (rules.max_range_m > 0.0 && range > static_cast<float>(rules.max_range_m))
    return {ReturnKind::kVoid, 0.0f, true};
  return {ReturnKind::kHit, range, true};
}

void Append(LidarScan* scan, const Vec3f& direction, const Return& r, float time_s) {
  scan->direction_lidar.push_back(direction);
  scan->range_m.push_back(r.range_m);
  scan->time_s.push_back(time_s);
  scan->kind.push_back(r.kind);
}

}  // namespace

LidarScan ScanFromCloud(const RecordedCloud& cloud, const core::LidarModel* model, const ScanRules& rules) {
  assert(model == nullptr || (model->rows() == cloud.rows && model->columns == cloud.columns));
  LidarScan scan;
  scan.min_range_m = static_cast<float>(rules.min_range_m);
  float farthest = 0.0f;
  for (size_t i = 0; i < cloud.size(); ++i) {
    const Return r = Judge(cloud, i, rules);
    const float time_s = cloud.time_s.empty() ? 0.0f : cloud.time_s[i];
    farthest = std::max(farthest, r.range_m);
    if (model == nullptr && (!r.has_direction || r.kind == ReturnKind::kDropout)) continue;
    const int row = static_cast<int>(i) / cloud.columns, column = static_cast<int>(i) % cloud.columns;
    const Vec3f direction = r.has_direction ? Vec3f(cloud.p_lidar[i].normalized())
                                            : Vec3f(model->Direction(row, column).cast<float>());
    Append(&scan, direction, r, time_s);
  }
  scan.rows = model != nullptr ? cloud.rows : 0;
  scan.columns = model != nullptr ? cloud.columns : static_cast<int>(scan.size());
  scan.max_range_m = rules.max_range_m > 0.0 ? static_cast<float>(rules.max_range_m) : farthest;
  return scan;
}

RecordedCloud Transposed(const RecordedCloud& cloud) {
  RecordedCloud out = cloud;
  out.rows = cloud.columns;
  out.columns = cloud.rows;
  const auto turn = [&](const auto& from, auto* to) {
    for (size_t i = 0; i < from.size(); ++i) {
      const size_t row = i / static_cast<size_t>(cloud.columns),
                   column = i % static_cast<size_t>(cloud.columns);
      (*to)[column * static_cast<size_t>(cloud.rows) + row] = from[i];
    }
  };
  turn(cloud.p_lidar, &out.p_lidar);
  turn(cloud.time_s, &out.time_s);
  turn(cloud.kind, &out.kind);
  turn(cloud.ring, &out.ring);
  return out;
}

}  // namespace atlas::mapping
