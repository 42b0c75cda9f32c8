#include "mapping/integrator/hit_scatter.h"

#include <algorithm>
#include <cmath>

#include "mapping/integrator/voxel_walk.h"

namespace atlas::mapping {
namespace {

constexpr int kStepsInFront = 2, kStepsBehind = 4;  ///< voxels walked along the beam from its end
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

HitBlock* HitScatter::BlockAt(const NodeKey& voxel) {
  const size_t chunk =
      static_cast<size_t>(voxel.x >> 6) +
      static_cast<size_t>(window_[0]) * (static_cast<size_t>(voxel.y >> 6) +
                                         static_cast<size_t>(window_[1]) * static_cast<size_t>(voxel.z >> 6));
  uint32_t& chunk_slot = slot_of_chunk_[chunk];
  if (chunk_slot == 0) {
    chunk_slot = static_cast<uint32_t>(chunks_used_++);
    if (chunks_.size() < chunks_used_) chunks_.resize(chunks_used_);
    chunks_[chunk_slot].touched = BlockMask{};
  }
  ChunkHits& hits = chunks_[chunk_slot];
  const int block = BlockIndexOf(voxel);
  if (!hits.touched.Test(block)) {
    hits.touched.Set(block);
    hits.slot[static_cast<size_t>(block)] = static_cast<uint32_t>(blocks_used_++);
    if (blocks_.size() < blocks_used_) blocks_.resize(std::max<size_t>(2 * blocks_.size(), 256));
    std::memset(blocks_[blocks_used_ - 1].delta, 0, kBlockVoxels);
  }
  return &blocks_[hits.slot[static_cast<size_t>(block)]];
}

int8_t* HitScatter::EvidenceOf(const NodeKey& voxel) {
  if (((voxel.x ^ last_voxel_.x) | (voxel.y ^ last_voxel_.y) | (voxel.z ^ last_voxel_.z)) >> kBlockLevel !=
      0) {
    last_block_ = BlockAt(voxel);
    last_voxel_ = voxel;
  }
  return &last_block_->delta[VoxelIndex(voxel.x, voxel.y, voxel.z)];
}

void HitScatter::Raise(const NodeKey& voxel, int delta) {
  if (!all_kept_ && (voxel.x < keep_min_.x || voxel.y < keep_min_.y || voxel.z < keep_min_.z ||
                     voxel.x >= keep_max_.x || voxel.y >= keep_max_.y || voxel.z >= keep_max_.z)) {
    return;
  }
  int8_t& held = *EvidenceOf(voxel);
  if (held == 0 || delta > held) held = static_cast<int8_t>(delta);
}

void HitScatter::Scatter(const ScanImage& image, const ScanFrame& frame, const SurfaceModel& model,
                         const NodeKey& keep_min, const NodeKey& keep_max) {
  window_ = frame.chunks;
  keep_min_ = keep_min;
  keep_max_ = keep_max;
  slot_of_chunk_.assign(
      static_cast<size_t>(window_[0]) * static_cast<size_t>(window_[1]) * static_cast<size_t>(window_[2]), 0);
  chunks_used_ = 1;  // 0 marks none
  blocks_used_ = 0;
  crowded_range_ = static_cast<float>(kCrowded / image.grid->min_pitch_rad);
  last_voxel_ = {-1, -1, -1};  // in no block of the window
  if (chunks_.empty()) chunks_.resize(1);
  for (size_t i = 0; i < image.range.size(); ++i) {
    if (image.range[i] > 0.0f) ScatterHit(frame, model, HitOfCell(image, frame, i));
  }
  for (const ScanImage::SpareHit& spare : image.spare)
    ScatterHit(frame, model, HitOfSpare(image, frame, spare));
}

HitScatter::Hit HitScatter::HitOfCell(const ScanImage& image, const ScanFrame& frame, size_t i) const {
  const float inverse = 1.0f / frame.resolution_m;
  Hit hit{{wx_[i], wy_[i], wz_[i]}, {}, image.support[i] * inverse, image.range[i] * inverse};
  for (int a = 0; a < 3; ++a) {
    hit.n[a] = -inverse * (frame.axis[a][0] * image.nx[i] + frame.axis[a][1] * image.ny[i] +
                           frame.axis[a][2] * image.nz[i]);
  }
  return hit;
}

/// With the plane of the hit in its cell where that is near, else seen head on.
HitScatter::Hit HitScatter::HitOfSpare(const ScanImage& image, const ScanFrame& frame,
                                       const ScanImage::SpareHit& spare) const {
  const auto ray = static_cast<size_t>(spare.ray), cell = static_cast<size_t>(spare.cell);
  const float inverse = 1.0f / frame.resolution_m;
  const bool near = std::abs(image.range[cell] - image.ray_range[ray]) < frame.resolution_m;
  Hit hit = HitOfCell(image, frame, cell);
  hit.range = image.ray_range[ray] * inverse;
  float l1 = 0.0f;
  for (int a = 0; a < 3; ++a) {
    hit.w[a] = inverse * inverse *
               (frame.axis[a][0] * image.ray_x[ray] + frame.axis[a][1] * image.ray_y[ray] +
                frame.axis[a][2] * image.ray_z[ray]);
    if (!near) hit.n[a] = hit.w[a] / hit.range;
    l1 += std::abs(hit.n[a]);
  }
  hit.support = 0.5f * l1;
  return hit;
}

HitScatter::Reach HitScatter::ReachOf(const float* p) const {
  constexpr float kReach = std::max(kStepsInFront, kStepsBehind) + 1;
  const int32_t low[3] = {keep_min_.x, keep_min_.y, keep_min_.z};
  const int32_t high[3] = {keep_max_.x, keep_max_.y, keep_max_.z};
  bool some = true, all = true;
  for (int a = 0; a < 3; ++a) {
    const auto first = static_cast<float>(low[a]), last = static_cast<float>(high[a]);
    some = some && p[a] > first - kReach && p[a] < last + kReach;
    all = all && p[a] >= first + kReach && p[a] < last - kReach;
  }
  return all ? Reach::kKept : some ? Reach::kCut : Reach::kDropped;
}

void HitScatter::ScatterHit(const ScanFrame& frame, const SurfaceModel& model, const Hit& hit) {
  const float range = hit.range, per_range = 1.0f / range;
  const float p[3] = {frame.sensor[0] + hit.w[0], frame.sensor[1] + hit.w[1], frame.sensor[2] + hit.w[2]};
  const Reach reach = ReachOf(p);
  if (reach == Reach::kDropped) return;
  all_kept_ = reach == Reach::kKept;
  const float along[3] = {hit.w[0] * per_range, hit.w[1] * per_range, hit.w[2] * per_range};
  const float back[3] = {-along[0], -along[1], -along[2]};
  const float(&n)[3] = hit.n;
  const float shift = hit.support, depth = model.Depth(range), band = model.Band(range);
  const auto distance_to = [&](const NodeKey& v) {
    return n[0] * (static_cast<float>(v.x) + 0.5f - p[0]) + n[1] * (static_cast<float>(v.y) + 0.5f - p[1]) +
           n[2] * (static_cast<float>(v.z) + 0.5f - p[2]) + shift;
  };
  const auto units = [&](float distance) {
    const int rounded = static_cast<int>(std::floor(model.LogOdds(distance, range) + 0.5f));
    return std::clamp(rounded != 0 ? rounded : distance < 0.0f ? -1 : 1, -127, 127);
  };
  const NodeKey end{static_cast<int32_t>(p[0]), static_cast<int32_t>(p[1]), static_cast<int32_t>(p[2])};
  const int at_end = std::max(model.hit_units, units(std::min(distance_to(end), depth)));
  // Where hits are many, the first ones that say most of their voxel speak for what lies around it.
  if (all_kept_ && *EvidenceOf(end) >= at_end + (range < crowded_range_ ? 0 : 1)) return;
  Raise(end, at_end);
  VoxelWalk<float> behind(p, along, end);
  for (int step = 0; step < kStepsBehind; ++step) {
    const float distance = distance_to(behind.Next());
    if (distance > depth) break;
    Raise(behind.voxel(), units(distance));
  }
  VoxelWalk<float> front(p, back, end);
  for (int step = 0; step < kStepsInFront; ++step) {
    const float distance = distance_to(front.Next());
    if (distance <= -band) break;
    Raise(front.voxel(), units(distance));
  }
}

}  // namespace atlas::mapping
