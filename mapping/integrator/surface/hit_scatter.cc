#include "mapping/integrator/surface/hit_scatter.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace atlas::mapping {
namespace {

/// Hits are deduplicated only where beams are closer than this many voxels: elsewhere hardly a voxel holds
/// two.
constexpr double kDuplicateHitPitchVoxels = 0.5;
constexpr size_t kClearedAtOnce = 8;  ///< blocks
constexpr int kWindowMargin = 8;      ///< voxels beyond the outermost ray end

/// With the plane of the hit in its cell where that is near, else seen head on.
void QueueSpare(const SurfaceImage& surface, const ScanFrame& frame, const RangeImage::SpareHit& spare,
                HitQueue* queue) {
  const auto cell = static_cast<size_t>(spare.cell);
  const size_t at = queue->count++;
  const float inverse = 1.0f / frame.resolution_m;
  const float in_cell = surface.image->range[cell];
  const bool near = in_cell > 0.0f && std::abs(in_cell - spare.range) < frame.resolution_m;
  const float range = spare.range * inverse;
  queue->range[at] = range;
  for (int a = 0; a < 3; ++a) {
    const float* axis = frame.axis[a];
    const float end =
        inverse * inverse * (axis[0] * spare.end[0] + axis[1] * spare.end[1] + axis[2] * spare.end[2]);
    const float inward = near ? -inverse * (axis[0] * surface.nx[cell] + axis[1] * surface.ny[cell] +
                                            axis[2] * surface.nz[cell])
                              : end / range;
    queue->end[a][at] = end;
    queue->inward[a][at] = inward;
  }
}

}  // namespace

void HitScatter::Place(const RangeImage& image, const core::Pose& T_map_lidar, double resolution_m,
                       ScanFrame* frame) {
  frame->resolution_m = static_cast<float>(resolution_m);
  for (int i = 0; i < 9; ++i) {
    frame->axis[i / 3][i % 3] = static_cast<float>(T_map_lidar.linear()(i / 3, i % 3) * resolution_m);
  }
  float low[3], high[3];
  BoundsOfEnds(image, *frame, low, high);
  int32_t first[3];
  for (int a = 0; a < 3; ++a) {
    const double sensor = T_map_lidar.translation()[a] / resolution_m;
    first[a] =
        static_cast<int32_t>(std::floor((sensor + static_cast<double>(low[a]) - kWindowMargin) / kChunkSide));
    const auto last = static_cast<int32_t>(
        std::floor((sensor + static_cast<double>(high[a]) + kWindowMargin) / kChunkSide));
    frame->chunks[static_cast<size_t>(a)] = last - first[a] + 1;
    frame->sensor[a] = static_cast<float>(sensor - static_cast<double>(first[a]) * kChunkSide);
  }
  frame->first_chunk = {first[0], first[1], first[2]};
  frame->SetLanes();
}

size_t HitScatter::SlotOf(int32_t block) {
  int32_t& row = row_of_chunk_[static_cast<size_t>(block) / kChunkBlocks];
  const auto of_chunk = static_cast<size_t>(block) % kChunkBlocks;
  if (row == 0) {
    row = static_cast<int32_t>(rows_used_++);
    const auto at = static_cast<size_t>(row);
    touched_[at] = BlockMask{};
    std::fill_n(slots_.begin() + static_cast<ptrdiff_t>(at * kChunkBlocks), kChunkBlocks, 0);
  }
  const auto at = static_cast<size_t>(row);
  int32_t& slot = slots_[at * kChunkBlocks + of_chunk];
  if (slot == 0) {
    slot = static_cast<int32_t>(blocks_used_++);
    const auto i = static_cast<int>(of_chunk);
    touched_[at].Set(BlockIndex(i & 7, i >> 3 & 7, i >> 6));
    if (blocks_used_ > blocks_clear_) {
      std::memset(blocks_[blocks_clear_].delta, 0, kClearedAtOnce * sizeof(HitBlock));
      blocks_clear_ += kClearedAtOnce;
    }
  }
  return static_cast<size_t>(slot);
}

void HitScatter::Reserve(TrailRules* rules) {
  constexpr size_t kMost = kHitGroup * std::max(HitTrails::kVoxels, HitApproaches::kVoxels);
  if (blocks_.size() < blocks_used_ + kMost + kClearedAtOnce) {
    blocks_.resize(2 * blocks_.size() + kMost + kClearedAtOnce);
  }
  if (touched_.size() < rows_used_ + kMost) {
    touched_.resize(2 * touched_.size() + kMost);
    slots_.resize(touched_.size() * kChunkBlocks);
  }
  rules->slots = slots_.data();
}

void HitScatter::Scatter(const SurfaceImage& surface, const ScanFrame& frame, const SurfaceModel& model,
                         const NodeKey& keep_min, const NodeKey& keep_max) {
  const RangeImage& image = *surface.image;
  row_of_chunk_.assign(static_cast<size_t>(frame.chunks[0]) * static_cast<size_t>(frame.chunks[1]) *
                           static_cast<size_t>(frame.chunks[2]),
                       0);
  rows_used_ = blocks_used_ = 1;
  blocks_clear_ = 1;
  if (blocks_.empty()) blocks_.resize(1);
  std::memset(blocks_.front().delta, 0, kBlockVoxels);
  TrailRules rules{model,
                   keep_min,
                   keep_max,
                   static_cast<float>(kDuplicateHitPitchVoxels / image.grid->min_pitch_rad),
                   row_of_chunk_.data(),
                   nullptr};
  HitQueue queue{}, oblique{};
  const auto approach = [&] {
    Reserve(&rules);
    FollowApproaches(frame, rules, &oblique, &approaches_);
    TakeGroup(0, &oblique, nullptr);
    ScatterVoxels(~uint32_t{0}, &approaches_);
  };
  const auto take = [&](size_t least) {
    while (queue.count >= least) {
      Reserve(&rules);
      FollowTrails(frame, rules, &queue, &trails_);
      const uint32_t changed = NewHits(trails_, blocks_.front().delta);
      TakeGroup(trails_.oblique & changed, &queue, &oblique);
      ScatterVoxels(changed, &trails_);
      if (oblique.count >= kHitGroup) approach();
    }
  };
  Reserve(&rules);
  const size_t cells = image.range.size(), columns = static_cast<size_t>(image.columns);
  for (size_t row = 0; row < cells; row += columns) {
    for (const GridColumns::Run& run : image.runs) {
      for (size_t c = run.first; c < run.last; c += kHitGroup) {
        const size_t cell = row + std::min(c, run.last - kHitGroup);
        QueueCells(surface, cell, frame, rules, blocks_.front().delta, &queue);
        take(kHitGroup);
      }
    }
  }
  for (const RangeImage::SpareHit& spare : image.spare) {
    QueueSpare(surface, frame, spare, &queue);
    take(kHitGroup);
  }
  take(1);
  if (oblique.count > 0) approach();
}

template <typename Voxels>
void HitScatter::ScatterVoxels(uint32_t which, Voxels* voxels) {
  for (int at = 0; at < Voxels::kVoxels; ++at) {
    for (uint32_t bits = voxels->unallocated[at] & which; bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<size_t>(__builtin_ctz(bits));
      const auto slot = static_cast<int32_t>(SlotOf(voxels->block[at][lane]));
      voxels->place[at][lane] = slot * kBlockVoxels + voxels->voxel[at][lane];
    }
  }
  PackUpdates(*voxels, which, &updates_);
  int8_t* const held = blocks_.front().delta;
  for (size_t i = 0; i < updates_.count; ++i) {
    int8_t& value = held[updates_.place[i]];
    const int32_t now =
        value - 128 * static_cast<int32_t>(value == 0);  // no branch: it would be guessed wrong
    value = static_cast<int8_t>(std::max(updates_.delta[i], now));
  }
}

}  // namespace atlas::mapping
