// The OctoMap library as people use it, for benches: unbounded, one insertPointCloud a scan.
#pragma once

#include <memory>
#include <span>

#include "core/geometry.h"
#include "mapping/map_view.h"

namespace atlas::mapping {

class OctomapPeer {
 public:
  explicit OctomapPeer(double resolution_m);
  ~OctomapPeer();

  /// Discretised insertion (OctoMap's fastest), inner nodes updated; returns beyond `max_range_m` clear up
  /// to it.
  void Insert(std::span<const core::Vec3f> points_map, const core::Vec3& origin_map, double max_range_m);
  /// Free below and occupied above even odds; unknown where no node is.
  CellState StateAt(const core::Vec3& p_map) const;
  size_t Bytes() const;
  size_t Nodes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atlas::mapping
