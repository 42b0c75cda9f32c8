#include "mapping/integrator/hit_scatter.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace atlas::mapping {
namespace {

constexpr double kCrowded = 0.25;  ///< voxels between beams: closer, and hits are many a voxel
constexpr int kWindowMargin = 8;   ///< voxels beyond the outermost ray end

}  // namespace

void HitScatter::Place(const ScanImage& image, const core::Pose& T_map_lidar, double resolution_m,
                       ScanFrame* frame) {
  const size_t cells = image.range.size();
  for (auto* v : {&wx_, &wy_, &wz_}) v->resize(cells);
  float m[9];
  for (int i = 0; i < 9; ++i) m[i] = static_cast<float>(T_map_lidar.linear()(i / 3, i % 3) / resolution_m);
  float low[3] = {0, 0, 0}, high[3] = {0, 0, 0};
  for (size_t i = 0; i < cells; ++i) {
    const float r = image.range[i];
    const float scale = r < 0.0f ? -r : r > 0.0f ? 1.0f : 0.0f;
    const float x = image.x[i] * scale, y = image.y[i] * scale, z = image.z[i] * scale;
    const float wx = m[0] * x + m[1] * y + m[2] * z, wy = m[3] * x + m[4] * y + m[5] * z,
                wz = m[6] * x + m[7] * y + m[8] * z;
    wx_[i] = wx;
    wy_[i] = wy;
    wz_[i] = wz;
    low[0] = std::min(low[0], wx), high[0] = std::max(high[0], wx);
    low[1] = std::min(low[1], wy), high[1] = std::max(high[1], wy);
    low[2] = std::min(low[2], wz), high[2] = std::max(high[2], wz);
  }
  int32_t first[3];
  for (int a = 0; a < 3; ++a) {
    const double sensor = T_map_lidar.translation()[a] / resolution_m;
    first[a] =
        static_cast<int32_t>(std::floor((sensor + static_cast<double>(low[a]) - kWindowMargin) / kChunkSide));
    const auto last = static_cast<int32_t>(
        std::floor((sensor + static_cast<double>(high[a]) + kWindowMargin) / kChunkSide));
    frame->chunks[static_cast<size_t>(a)] = last - first[a] + 1;
    frame->sensor[a] = static_cast<float>(sensor - static_cast<double>(first[a]) * kChunkSide);
    for (int c = 0; c < 3; ++c) {
      frame->axis[a][c] = static_cast<float>(T_map_lidar.linear()(a, c) * resolution_m);
    }
  }
  frame->first_chunk = {first[0], first[1], first[2]};
  frame->resolution_m = static_cast<float>(resolution_m);
  frame->SetLanes();
}

int8_t* HitScatter::BlockAt(int32_t block) {
  uint32_t& chunk_slot = slot_of_chunk_[static_cast<size_t>(block) / kChunkBlocks];
  if (chunk_slot == 0) {
    chunk_slot = static_cast<uint32_t>(chunks_used_++);
    if (chunks_.size() < chunks_used_) chunks_.resize(chunks_used_);
    chunks_[chunk_slot].touched = BlockMask{};
  }
  ChunkHits& hits = chunks_[chunk_slot];
  const int of_chunk = block % kChunkBlocks;
  if (!hits.touched.Test(of_chunk)) {
    hits.touched.Set(of_chunk);
    hits.slot[static_cast<size_t>(of_chunk)] = static_cast<uint32_t>(blocks_used_++);
    if (blocks_.size() < blocks_used_) blocks_.resize(std::max<size_t>(2 * blocks_.size(), 256));
    std::memset(blocks_[blocks_used_ - 1].delta, 0, kBlockVoxels);
  }
  return blocks_[hits.slot[static_cast<size_t>(of_chunk)]].delta;
}

void HitScatter::Scatter(const ScanImage& image, const ScanFrame& frame, const SurfaceModel& model,
                         const NodeKey& keep_min, const NodeKey& keep_max) {
  slot_of_chunk_.assign(static_cast<size_t>(frame.chunks[0]) * static_cast<size_t>(frame.chunks[1]) *
                            static_cast<size_t>(frame.chunks[2]),
                        0);
  chunks_used_ = 1;  // 0 marks none
  blocks_used_ = 0;
  if (chunks_.empty()) chunks_.resize(1);
  const TrailRules rules{model, keep_min, keep_max, static_cast<float>(kCrowded / image.grid->min_pitch_rad)};
  const float* const ends[3] = {wx_.data(), wy_.data(), wz_.data()};
  HitTrails trails;
  const size_t cells = image.range.size();
  for (size_t i = 0; i < cells; i += kHitGroup) {
    TrailsOfCells(image, ends, std::min(i, cells - kHitGroup), frame, rules, &trails);
    ScatterTrails(trails);
  }
  HitGroup group;
  for (size_t i = 0; i < image.spare.size(); i += kHitGroup) {
    for (size_t lane = 0; lane < kHitGroup; ++lane) {
      FillSpare(image, frame, image.spare[std::min(i + lane, image.spare.size() - 1)], lane, &group);
    }
    TrailsOfHits(group, frame, rules, &trails);
    ScatterTrails(trails);
  }
}

void HitScatter::ScatterTrails(const HitTrails& trails) {
  int32_t block = -1;
  int8_t* delta = nullptr;
  for (uint32_t bits = trails.hits; bits != 0; bits &= bits - 1) {
    const auto lane = static_cast<size_t>(__builtin_ctz(bits));
    for (int at = 0; at < HitTrails::kVoxels; ++at) {
      const int32_t units = trails.delta[at][lane];
      if (units == 0) continue;
      if (trails.block[at][lane] != block) {
        block = trails.block[at][lane];
        delta = BlockAt(block);
      }
      int8_t& held = delta[trails.voxel[at][lane]];
      if (at == 0 && held >= trails.said[lane]) break;
      if (held == 0 || units > held) held = static_cast<int8_t>(units);
    }
  }
}

/// With the plane of the hit in its cell where that is near, else seen head on.
void HitScatter::FillSpare(const ScanImage& image, const ScanFrame& frame, const ScanImage::SpareHit& spare,
                           size_t lane, HitGroup* group) const {
  const auto ray = static_cast<size_t>(spare.ray), cell = static_cast<size_t>(spare.cell);
  const float inverse = 1.0f / frame.resolution_m;
  const bool near = std::abs(image.range[cell] - image.ray_range[ray]) < frame.resolution_m;
  const float range = image.ray_range[ray] * inverse;
  group->range[lane] = range;
  float l1 = 0.0f;
  for (int a = 0; a < 3; ++a) {
    const float* axis = frame.axis[a];
    const float end = inverse * inverse *
                      (axis[0] * image.ray_x[ray] + axis[1] * image.ray_y[ray] + axis[2] * image.ray_z[ray]);
    const float inward =
        near ? -inverse * (axis[0] * image.nx[cell] + axis[1] * image.ny[cell] + axis[2] * image.nz[cell])
             : end / range;
    group->end[a][lane] = end;
    group->inward[a][lane] = inward;
    l1 += std::abs(inward);
  }
  group->support[lane] = 0.5f * l1;
}

}  // namespace atlas::mapping
