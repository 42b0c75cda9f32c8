#include "mapping/meshing/surface_vertex.h"

#include <algorithm>

#include "mapping/integrator/write/occupancy_shift.h"

namespace atlas::mapping {
namespace {

using core::Vec3f;

/// The gradient around voxel (x, y, z): differences over two and four voxels, binomially smoothed across.
/// Each difference stands only where both ends are known.
template <typename Field>
Vec3f SmoothGradient(const BlockSamples<Field>& samples, int x, int y, int z) {
  static constexpr std::array<float, 5> kBinomial = {1.0f, 4.0f, 6.0f, 4.0f, 1.0f};
  Vec3f gradient = Vec3f::Zero();
  Vec3f weight = Vec3f::Zero();
  for (int c = -2; c <= 2; ++c) {
    for (int b = -2; b <= 2; ++b) {
      const float across = kBinomial[static_cast<size_t>(b + 2)] * kBinomial[static_cast<size_t>(c + 2)];
      for (int reach = 1; reach <= 2; ++reach) {
        const float along = (reach == 1 ? 2.0f : 1.0f) * across;
        const auto add = [&](int axis, float low, float high) {
          if (!IsKnown(low) || !IsKnown(high)) return;
          gradient[axis] += along * (high - low);
          weight[axis] += along * 2.0f * static_cast<float>(reach);
        };
        add(0, samples.At(x - reach, y + b, z + c), samples.At(x + reach, y + b, z + c));
        add(1, samples.At(x + c, y - reach, z + b), samples.At(x + c, y + reach, z + b));
        add(2, samples.At(x + b, y + c, z - reach), samples.At(x + b, y + c, z + reach));
      }
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (weight[axis] > 0.0f) gradient[axis] /= weight[axis];
  }
  return gradient;
}

/// How far the inside reaches from `p` along `inwards`, to `limit` at most (or the bounds of the samples,
/// which only the vertices of coarse cells reach); unknown counts as inside.
template <typename Field>
float Thickness(const BlockSamples<Field>& samples, const Vec3f& p, const Vec3f& inwards, float limit) {
  constexpr float kStep = 0.25f, kBounds = 2.9f;
  constexpr float kNear = 0.5f;  // nearer, a rough gradient may leave the inside sideways
  float last = samples.Between(p + kNear * inwards);
  for (float t = kNear + kStep; t < std::min(limit, kBounds); t += kStep) {
    const float s = samples.Between(p + t * inwards);
    if (IsKnown(s) && !IsInside(s)) return IsInside(last) ? t - kStep * s / (s - last) : t - kStep;
    last = s;
  }
  return limit;
}

NodeKey UpperEnd(const NodeKey& low, int axis) {
  return {low.x + (axis == 0), low.y + (axis == 1), low.z + (axis == 2)};
}

/// Share of the way from the first to the second sample. Kept off the ends, so that no two vertices of a
/// triangle meet.
float CrossingShare(float first, float second) {
  constexpr float kOffEnds = 0.01f;
  return std::clamp(first / (first - second), kOffEnds, 1.0f - kOffEnds);
}

/// Depth of the surface below `p` along `inwards`, from what the voxels around `inside` tell of their places;
/// NaN where none does. Those that face another way (the far side of a thin wall) do not count.
float DepthAround(const BlockSamples<OccupancyField>& samples, const NodeKey& inside, const Vec3f& p,
                  const Vec3f& inwards, float support) {
  constexpr float kReach = 1.5f;   // of the weights, voxels (standard deviation)
  constexpr float kFacing = 1.5f;  // this far outwards there must be free space
  float sum = 0.0f, weight = 0.0f;
  for (int i = 0; i < 27; ++i) {
    const int x = inside.x + i % 3 - 1, y = inside.y + i / 3 % 3 - 1, z = inside.z + i / 9 - 1;
    const float sample = samples.At(x, y, z);
    if (!IsKnown(sample) || !IsInside(sample)) continue;
    const Vec3f middle(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
    const float before = samples.Between(middle - kFacing * inwards);
    if (!IsKnown(before) || IsInside(before)) continue;
    const float w = -sample * std::exp(-0.5f / (kReach * kReach) * (middle - p).squaredNorm());
    sum += w * (inwards.dot(middle - p) - support * (2.0f * PlaceOf(sample) - 1.0f));
    weight += w;
  }
  return weight > 0.0f ? sum / weight : std::nanf("");
}

Vec3f Inwards(const BlockSamples<OccupancyField>& samples, const NodeKey& low, int axis, float share,
              const Vec3f& p) {
  const NodeKey high = UpperEnd(low, axis);
  const Vec3f gradient = (1.0f - share) * SmoothGradient(samples, low.x, low.y, low.z) +
                         share * SmoothGradient(samples, high.x, high.y, high.z);
  const float length = gradient.norm();
  if (!(length > 0.0f)) return Vec3f::Zero();
  const Vec3f inwards = -gradient / length;
  const NodeKey& inside = IsInside(samples.At(low.x, low.y, low.z)) ? low : high;
  const int scale = samples.ScaleAt(inside.x, inside.y, inside.z);
  const auto support = static_cast<float>(OccupancyShift(inwards.cast<double>(), scale));
  float depth = support;
  if (scale == 1) {
    const float told = DepthAround(samples, inside, p, inwards, support);
    if (IsKnown(told)) depth = told;
  }
  constexpr float kBeforeMiddle = 0.45f, kOutwards = -1.0f;
  if (depth <= 0.0f) return std::max(depth, kOutwards) * inwards;
  return std::min(depth, kBeforeMiddle * Thickness(samples, p, inwards, depth / kBeforeMiddle)) * inwards;
}

}  // namespace

template <typename Field>
Vec3f SurfaceVertex(const BlockSamples<Field>& samples, const NodeKey& low, int axis,
                    [[maybe_unused]] bool undo_shift) {
  const NodeKey high = UpperEnd(low, axis);
  const float share =
      CrossingShare(samples.AtScale(low.x, low.y, low.z), samples.AtScale(high.x, high.y, high.z));
  Vec3f p(static_cast<float>(low.x), static_cast<float>(low.y), static_cast<float>(low.z));
  p[axis] += share;
  if constexpr (std::is_same_v<Field, OccupancyField>) {
    if (undo_shift) p += Inwards(samples, low, axis, share, p);
  }
  return p;
}

template Vec3f SurfaceVertex(const BlockSamples<OccupancyField>&, const NodeKey&, int, bool);
template Vec3f SurfaceVertex(const BlockSamples<TsdfField>&, const NodeKey&, int, bool);

}  // namespace atlas::mapping
