// Evidence added many voxels at a time, against one voxel at a time in plain arithmetic.
#include "mapping/integrator/write/occupancy_apply.h"

#include <gtest/gtest.h>

#include <array>

#include "core/rng.h"

namespace atlas::mapping {
namespace {

constexpr int kLayers = 8, kCount = 64 * kLayers;
constexpr int kMiss = 8, kWeakMiss = 4, kHit = 16;

struct Scan {
  std::array<int8_t, kCount> values{}, delta{};
  std::array<uint64_t, kLayers> free{}, weak{};
  bool IsFree(int i) const { return free[static_cast<size_t>(i / 64)] >> (i % 64) & 1; }
  bool IsWeak(int i) const { return weak[static_cast<size_t>(i / 64)] >> (i % 64) & 1; }
};

Scan DrawScan(uint64_t seed) {
  core::Rng rng(seed);
  Scan scan;
  for (int8_t& value : scan.values) {
    value = static_cast<int8_t>(OccupancyField::kMin +
                                rng.UniformInt(OccupancyField::kMax - OccupancyField::kMin + 1));
  }
  for (size_t layer = 0; layer < kLayers; ++layer) {
    scan.free[layer] = rng.Next();
    scan.weak[layer] = rng.Next();
  }
  return scan;
}

int Clamped(int value) {
  return std::clamp<int>(value, OccupancyField::kMin, OccupancyField::kMax);
}

TEST(OccupancyApply, MissesSubtractAndWeakOnesSubtractLessFromWhatIsHeldAboveTheirLimit) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Scan scan = DrawScan(seed);
    const auto before = scan.values;
    const int above = seed % 2 == 0 ? 0 : OccupancyField::kNoneObserved;
    const WeakMisses weak{scan.weak.data(), kWeakMiss, above};
    const ApplyResult result =
        ApplyEvidence(scan.values.data(), kLayers, scan.free.data(), weak, nullptr, kMiss, kHit);
    int greatest = OccupancyField::kNoneObserved, least = 127;
    bool unknown = false, changed = false;
    for (int i = 0; i < kCount; ++i) {
      const auto at = static_cast<size_t>(i);
      int expected = before[at];
      if (scan.IsFree(i)) {
        expected = Clamped(expected - (scan.IsWeak(i) && before[at] > above ? kWeakMiss : kMiss));
        if (expected == 0) expected = 1;  // known, and undecided
      }
      ASSERT_EQ(scan.values[at], expected) << "held " << int{before[at]};
      changed = changed || expected != before[at];
      unknown = unknown || expected == 0;
      least = std::min(least, expected);
      if (expected != 0) greatest = std::max(greatest, expected);
    }
    EXPECT_EQ(result.changed, changed);
    EXPECT_EQ(result.node.max, greatest);
    EXPECT_EQ(result.min, least);
    EXPECT_EQ(result.node.any_unknown, unknown);
  }
}

TEST(OccupancyApply, NoMissRaisesEvidenceAndNoReturnLowersIt) {
  core::Rng rng(3);
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Scan scan = DrawScan(100 + seed);
    for (int8_t& delta : scan.delta) {
      if (rng.UniformInt(3) == 0)
        delta = static_cast<int8_t>(4 * (1 + rng.UniformInt(4)) + rng.UniformInt(4));
    }
    const auto before = scan.values;
    const WeakMisses weak{scan.weak.data(), kWeakMiss, OccupancyField::kNoneObserved};
    ApplyEvidence(scan.values.data(), kLayers, scan.free.data(), weak, scan.delta.data(), kMiss, kHit);
    for (int i = 0; i < kCount; ++i) {
      const auto at = static_cast<size_t>(i);
      const int held = before[at], now = scan.values[at], steps = scan.delta[at] & ~3;
      const double held_nats = OccupancyField::LogOdds(before[at]),
                   now_nats = OccupancyField::LogOdds(scan.values[at]);
      if (scan.delta[at] != 0) {
        EXPECT_GE(now_nats, held_nats) << held << " + " << int{scan.delta[at]};
        EXPECT_LE(now, Clamped(std::max(held, 0) + steps + 3));
      } else if (scan.IsFree(i)) {
        // Nothing becomes less free, but that known evidence never cancels to unknown.
        EXPECT_TRUE(now <= held || now == 1) << held << " became " << now;
        const int most = scan.IsWeak(i) ? kWeakMiss : kMiss;
        EXPECT_GE(now, Clamped(held - most - 3));
        EXPECT_TRUE(now < held || held <= OccupancyField::kMin + most || held == 1) << held << " stays";
      } else {
        EXPECT_EQ(now, held);
      }
    }
  }
}

TEST(OccupancyApply, AMissOnChosenVoxelsTellsWhichChanged) {
  Scan scan = DrawScan(7);
  const auto before = scan.values;
  const uint64_t which = scan.free[0], changed = ApplyMiss(scan.values.data(), which, kMiss);
  for (int i = 0; i < 64; ++i) {
    const auto at = static_cast<size_t>(i);
    int expected = before[at];
    if (which >> i & 1) {
      expected = Clamped(expected - kMiss);
      if (expected == 0) expected = 1;
    }
    EXPECT_EQ(scan.values[at], expected);
    EXPECT_EQ(changed >> i & 1, expected != before[at] ? 1u : 0u);
  }
}

}  // namespace
}  // namespace atlas::mapping
