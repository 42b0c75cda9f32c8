// What an octree stores a voxel: log-odds occupancy (MultiresOFusion) or a signed distance (MultiresTSDF).
//
// A field defines how N cells lie in memory (`Cells<N>`), what a node above them knows (`Node`) and how eight
// nodes make their parent. All-zero cells are unknown in both.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>

namespace atlas::mapping {

/// Log-odds occupancy in steps of 0.05 nats, int8. 0 is unknown: observed evidence that cancels is held as 1.
/// The two low bits of an occupied voxel hold where in it the surface lies (PlaceOf) and count for nothing.
struct OccupancyField {
  using Value = int8_t;
  static constexpr double kNatsPerUnit = 0.05;
  static constexpr int kMin = -40;   ///< p = 0.12
  static constexpr int kMax = 71;    ///< p = 0.97
  static constexpr int kPlaces = 4;  ///< evidence on occupied voxels comes in steps of so many units
  static constexpr const char* kName = "occupancy";

  static constexpr Value Unknown() { return 0; }
  static constexpr bool Known(Value v) { return v != 0; }
  static constexpr bool Occupied(Value v) { return v > 0; }
  static constexpr bool Free(Value v) { return v < 0; }
  static double LogOdds(Value v) { return kNatsPerUnit * (v > 0 ? (v | (kPlaces - 1)) : v); }
  static double Probability(Value v) { return 1.0 / (1.0 + std::exp(-LogOdds(v))); }
  /// How much of the voxel's extent along the surface's normal lies behind the surface, in (0, 1).
  /// @pre Occupied(v).
  static constexpr double PlaceOf(Value v) { return ((v & (kPlaces - 1)) + 0.5) / kPlaces; }
  /// Evidence in units, whole steps, at least one.
  static int StepsOf(double nats) {
    return kPlaces * std::max(1, static_cast<int>(std::lround(nats / kNatsPerUnit / kPlaces)));
  }

  template <int N>
  struct alignas(64) Cells {
    int8_t log_odds[N];
    Value Get(int i) const { return log_odds[i]; }
    void Set(int i, Value v) { log_odds[i] = v; }
    void Fill(Value v) { std::memset(log_odds, v, N); }
  };

  /// The greatest occupancy of the observed voxels below, and whether any is unknown.
  struct Node {
    int8_t max = kNoneObserved;
    bool any_unknown = true;
    friend bool operator==(const Node&, const Node&) = default;
  };
  static constexpr int8_t kNoneObserved = -128;
  static constexpr Node NodeOf(Value v) { return Known(v) ? Node{v, false} : Node{kNoneObserved, true}; }
  static constexpr Node Merge(const Node& a, const Node& b) {
    return {std::max(a.max, b.max), a.any_unknown || b.any_unknown};
  }
  static constexpr bool NodeObserved(const Node& n) { return n.max != kNoneObserved; }
};

/// Truncated signed distance and its weight. Positive in front of the surface; weight 0 is unknown.
struct TsdfField {
  /// Distances are held in units of the widest truncation / 32767.
  static constexpr double kWidestTruncationVoxels = 24.0;
  static constexpr int kMaxWeight = 100;
  static constexpr const char* kName = "tsdf";
  struct Value {
    int16_t distance = 0;  ///< metres = distance * UnitM(resolution)
    uint8_t weight = 0;
    friend bool operator==(const Value&, const Value&) = default;
  };
  static constexpr double UnitM(double resolution_m) {
    return kWidestTruncationVoxels * resolution_m / 32767.0;
  }

  static constexpr Value Unknown() { return {}; }
  static constexpr bool Known(Value v) { return v.weight != 0; }
  static constexpr bool Occupied(Value v) { return v.weight != 0 && v.distance <= 0; }
  static constexpr bool Free(Value v) { return v.weight != 0 && v.distance > 0; }

  template <int N>
  struct alignas(64) Cells {
    int16_t distance[N];
    uint8_t weight[N];
    Value Get(int i) const { return {distance[i], weight[i]}; }
    void Set(int i, Value v) {
      distance[i] = v.distance;
      weight[i] = v.weight;
    }
    void Fill(Value v) {
      std::fill_n(distance, N, v.distance);
      std::memset(weight, v.weight, N);
    }
  };

  /// Mean distance and mean weight of the observed voxels below, the smallest distance (what a collision
  /// query needs), and how much of the node is observed.
  struct Node {
    float mean_distance = 0.0f;  ///< in UnitM
    float mean_weight = 0.0f;
    int16_t min_distance = 32767;
    float observed = 0.0f;  ///< share of the voxels below, in [0, 1]
    bool any_unknown = true;
    friend bool operator==(const Node&, const Node&) = default;
  };
  static constexpr Node NodeOf(Value v) {
    return Known(v)
               ? Node{static_cast<float>(v.distance), static_cast<float>(v.weight), v.distance, 1.0f, false}
               : Node{};
  }
  static constexpr bool NodeObserved(const Node& n) { return n.observed > 0.0f; }
  /// The node above cells held one by one, and their extremes, unknown ones (of distance 0) included.
  struct Summary {
    Node node;
    int16_t least = INT16_MAX, greatest = INT16_MIN;
    uint8_t lightest = UINT8_MAX, heaviest = 0;
  };
  template <int N>
  static Summary Summarise(const Cells<N>& cells) {
    // Sums are exact. Plain loops over one array each, which vectorise.
    Summary s;
    int16_t least_known = INT16_MAX;
    int32_t known = 0, distance = 0, weight = 0;
    for (int i = 0; i < N; ++i) {
      const int16_t d = cells.distance[i];
      s.least = std::min(s.least, d);
      s.greatest = std::max(s.greatest, d);
    }
    for (int i = 0; i < N; ++i) {
      const uint8_t w = cells.weight[i];
      s.lightest = std::min(s.lightest, w);
      s.heaviest = std::max(s.heaviest, w);
    }
    for (int i = 0; i < N; ++i) {
      const int32_t is_known = cells.weight[i] != 0;
      known += is_known;
      weight += cells.weight[i];
      distance += -is_known & cells.distance[i];
      least_known = std::min<int16_t>(least_known, is_known != 0 ? cells.distance[i] : INT16_MAX);
    }
    if (known > 0) {
      const auto n = static_cast<float>(known);
      s.node = {static_cast<float>(distance) / n, static_cast<float>(weight) / n, least_known,
                n / static_cast<float>(N), known < N};
    }
    return s;
  }
  /// Of two nodes of like size, or of like total share when folded over siblings.
  static constexpr Node Merge(const Node& a, const Node& b) {
    const float n = a.observed + b.observed;
    if (n <= 0.0f) return {};
    return {(a.mean_distance * a.observed + b.mean_distance * b.observed) / n,
            (a.mean_weight * a.observed + b.mean_weight * b.observed) / n,
            std::min(a.min_distance, b.min_distance), 0.5f * n, a.any_unknown || b.any_unknown};
  }
};

}  // namespace atlas::mapping
