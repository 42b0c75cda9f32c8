// Each gain on rays of three voxels, against values worked out by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "core/errors.h"
#include "planner/gain/area_factor.h"
#include "planner/gain/gain.h"
#include "planner/gain/voxel_math.h"

namespace atlas::planner {
namespace {

using mapping::RayEnd;
using mapping::RaySample;

constexpr double kRes = 0.05;
const double kLn2 = std::log(2.0);
/// H(0.9), and H(0.1) alike: 0.9 ln(10/9) + 0.1 ln 10.
const double kH9 = 0.9 * std::log(10.0 / 9.0) + 0.1 * std::log(10.0);

std::vector<RaySample> Ray(std::initializer_list<float> occupancy) {
  std::vector<RaySample> ray;
  uint64_t key = 1;
  for (const float p : occupancy) ray.push_back({p, static_cast<float>(kRes), key++, 0.0f});
  return ray;
}

double GainOf(const std::string& name, const std::vector<std::pair<std::vector<RaySample>, RayEnd>>& rays,
              double weight = 1.0) {
  const auto gain = FindGain(name).build(kRes);
  gain->BeginView();
  for (const auto& [samples, end] : rays) gain->AddRay(samples, end, weight);
  return gain->FinishView();
}
double GainOfRay(const std::string& name, const std::vector<RaySample>& samples, RayEnd end) {
  return GainOf(name, {{samples, end}});
}

const auto kFreeUnknownHit = Ray({0.1f, 0.5f, 0.9f});
const auto kUnknown3 = Ray({0.5f, 0.5f, 0.5f});
const auto kFrontHit = Ray({0.1f, 0.1f, 0.9f});

TEST(GainValues, EntropyTableFollowsTheFormula) {
  EXPECT_NEAR(Entropy(0.5), kLn2, 1e-15);
  EXPECT_EQ(Entropy(0.0), 0.0);
  EXPECT_EQ(Entropy(1.0), 0.0);
  for (double p = 0.0; p <= 1.0; p += 0.00037) EXPECT_NEAR(EntropyTable::Instance()(p), Entropy(p), 1e-6);
}

TEST(GainValues, OcclusionAwareAttenuatesByFreeProbability) {
  EXPECT_NEAR(GainOfRay("occlusion_aware", kFreeUnknownHit, RayEnd::kOccupied), kH9 + 0.9 * kLn2 + 0.45 * kH9,
              2e-6);
  EXPECT_NEAR(GainOfRay("occlusion_aware", kUnknown3, RayEnd::kVoid), kLn2 * (1.0 + 0.5 + 0.25), 2e-6);
}

TEST(GainValues, OcclusionAwarePrefersClampedFreeSpaceAsMeasured) {
  // 10 m at 5 cm: known free at clamp 0.12 then a hit 3.06 nats, all unknown 1.39.
  std::vector<RaySample> known_free(200, {0.12f, static_cast<float>(kRes), 1, 0.0f});
  known_free.push_back({0.97f, static_cast<float>(kRes), 2, 0.0f});
  const std::vector<RaySample> unknown(200, {0.5f, static_cast<float>(kRes), 1, 0.0f});
  EXPECT_NEAR(GainOfRay("occlusion_aware", known_free, RayEnd::kOccupied), 3.06, 0.005);
  EXPECT_NEAR(GainOfRay("occlusion_aware", unknown, RayEnd::kVoid), 1.39, 0.005);
}

TEST(GainValues, NormalisedCountsConfirmedFreeAsCertain) {
  const std::vector<RaySample> known_free(200, {0.12f, static_cast<float>(kRes), 1, 0.0f});
  const std::vector<RaySample> unknown(200, {0.5f, static_cast<float>(kRes), 1, 0.0f});
  EXPECT_EQ(GainOfRay("occlusion_aware_normalised", known_free, RayEnd::kVoid), 0.0);
  EXPECT_NEAR(GainOfRay("occlusion_aware_normalised", unknown, RayEnd::kVoid), 1.0, 1e-6);
  // One unknown voxel of one reference length: half of the ray passes, ln 2 / ln 2 * (1 - 1/2).
  EXPECT_NEAR(GainOfRay("occlusion_aware_normalised", kFreeUnknownHit, RayEnd::kOccupied), 0.5, 1e-6);
}

TEST(GainValues, UnobservedVoxelSkipsKnownOnes) {
  EXPECT_NEAR(GainOfRay("unobserved_voxel", kFreeUnknownHit, RayEnd::kOccupied), 0.9 * kLn2, 2e-6);
  EXPECT_EQ(GainOfRay("unobserved_voxel", kFrontHit, RayEnd::kOccupied), 0.0);
}

TEST(GainValues, RearSideVoxelNeedsUnknownBeforeTheHit) {
  EXPECT_EQ(GainOfRay("rear_side_voxel", kFreeUnknownHit, RayEnd::kOccupied), 1.0);
  EXPECT_EQ(GainOfRay("rear_side_voxel", kFrontHit, RayEnd::kOccupied), 0.0);
  EXPECT_EQ(GainOfRay("rear_side_voxel", kUnknown3, RayEnd::kVoid), 0.0);
  EXPECT_EQ(GainOfRay("rear_side_voxel", Ray({0.9f}), RayEnd::kOccupied), 0.0);
}

TEST(GainValues, RearSideEntropyCountsTheUnknownRunBeforeTheHitOnly) {
  EXPECT_NEAR(GainOfRay("rear_side_entropy", kFreeUnknownHit, RayEnd::kOccupied), 0.9 * kLn2, 2e-6);
  EXPECT_NEAR(GainOfRay("rear_side_entropy", Ray({0.5f, 0.5f, 0.9f}), RayEnd::kOccupied), 1.5 * kLn2, 2e-6);
  // The first unknown voxel is cut off from the hit by a free one: only its attenuation stays.
  EXPECT_NEAR(GainOfRay("rear_side_entropy", Ray({0.5f, 0.1f, 0.5f, 0.9f}), RayEnd::kOccupied), 0.45 * kLn2,
              2e-6);
  EXPECT_EQ(GainOfRay("rear_side_entropy", kFrontHit, RayEnd::kOccupied), 0.0);
  EXPECT_EQ(GainOfRay("rear_side_entropy", kUnknown3, RayEnd::kVoid), 0.0);
}

TEST(GainValues, ProximityCountSumsStoredValuesOfUnmeasuredVoxels) {
  auto ray = kUnknown3;
  ray[1].behind_surface = 11.0f;
  ray[2].behind_surface = 10.0f;
  EXPECT_EQ(GainOfRay("proximity_count", ray, RayEnd::kVoid), 21.0);
  ray[1] = {0.1f, ray[1].length_m, ray[1].key, 11.0f};
  EXPECT_EQ(GainOfRay("proximity_count", ray, RayEnd::kVoid), 10.0);
}

/// SE-Atlas holds a scan's miss as free at log-odds of -0.4 (thesis 4.5.2): what the voxel counts as is the
/// map's, how uncertain it is the log-odds'.
TEST(GainValues, VoxelsCountAsTheirMapSaysAndWeighAsItsLogOddsSay) {
  const float p = static_cast<float>(1.0 / (1.0 + std::exp(0.4)));
  auto ray = Ray({p, 0.5f, 0.9f});
  ray[0].state = mapping::CellState::kFree;
  const double entropy = -static_cast<double>(p) * std::log(static_cast<double>(p)) -
                         (1.0 - static_cast<double>(p)) * std::log(1.0 - static_cast<double>(p));
  const double passed = 1.0 - static_cast<double>(p);
  EXPECT_NEAR(GainOfRay("occlusion_aware", ray, RayEnd::kOccupied), entropy + passed * (kLn2 + 0.5 * kH9),
              2e-6);
  EXPECT_NEAR(GainOfRay("rear_side_entropy", ray, RayEnd::kOccupied), passed * kLn2, 2e-6);
  EXPECT_NEAR(GainOfRay("unobserved_voxel", ray, RayEnd::kOccupied), passed * kLn2, 2e-6);
  EXPECT_NEAR(GainOfRay("occlusion_aware_normalised", ray, RayEnd::kOccupied),
              GainOfRay("occlusion_aware_normalised", Ray({0.01f, 0.5f, 0.9f}), RayEnd::kOccupied), 1e-9);
  EXPECT_EQ(GainOfRay("rear_side_voxel", {ray[0], ray[2]}, RayEnd::kOccupied), 0.0);
}

TEST(GainValues, AverageEntropyIsPerVoxelOverRaysThatHit) {
  EXPECT_NEAR(GainOfRay("average_entropy", kFreeUnknownHit, RayEnd::kOccupied), (2.0 * kH9 + kLn2) / 3.0,
              2e-6);
  EXPECT_EQ(GainOfRay("average_entropy", kUnknown3, RayEnd::kVoid), 0.0);
  EXPECT_NEAR(
      GainOf("average_entropy", {{kFreeUnknownHit, RayEnd::kOccupied}, {Ray({0.9f}), RayEnd::kOccupied}}),
      (3.0 * kH9 + kLn2) / 4.0, 2e-6);
}

TEST(GainValues, AreaFactorShapeHasItsFixedPoints) {
  for (const double a : {0.2, 0.8}) {
    EXPECT_NEAR(AreaFactorShape(0.0, a), 0.0, 1e-12);
    EXPECT_NEAR(AreaFactorShape(a, a), 1.0, 1e-12);
    EXPECT_NEAR(AreaFactorShape(1.0, a), 0.0, 1e-12);
    EXPECT_NEAR(AreaFactorShape(a + 1e-9, a), 1.0, 1e-6);
  }
}

TEST(GainValues, AreaFactorIsTwoAtAFifthSurfaceAndFourFifthsOcclusionPlane) {
  const std::pair surface{kFrontHit, RayEnd::kOccupied};
  const std::pair plane{Ray({0.1f, 0.5f, 0.5f}), RayEnd::kVoid};
  const std::pair unobserved{kUnknown3, RayEnd::kVoid};
  EXPECT_NEAR(GainOf("area_factor", {surface, plane, plane, plane, plane}), 2.0, 1e-12);
  EXPECT_NEAR(GainOf("area_factor", {unobserved, unobserved}), 0.0, 1e-12);
}

TEST(GainValues, UnknownVolumeCountsAVoxelOnce) {
  const double voxel = kRes * kRes * kRes;
  EXPECT_NEAR(GainOf("unknown_volume", {{kUnknown3, RayEnd::kVoid}, {kUnknown3, RayEnd::kVoid}}), 3.0 * voxel,
              1e-15);
  EXPECT_NEAR(GainOf("unknown_volume", {{kFreeUnknownHit, RayEnd::kOccupied}}), voxel, 1e-15);
}

TEST(GainValues, SurfaceFrontierCountsUnmeasuredPatchesOnceByTheRaysThatMeetThem) {
  // Voxels of 5 cm over a depth of 30 cm: each is worth 5^3 / 30 cm^2; 6 rays give 1 - 1/e of it.
  const double patch = kRes * kRes * kRes / 0.30, share = 1.0 - std::exp(-1.0);
  EXPECT_NEAR(GainOf("surface_frontier", {{kFreeUnknownHit, RayEnd::kOccupied}}, 6.0), patch * share, 1e-9);
  EXPECT_NEAR(GainOf("surface_frontier", {{kUnknown3, RayEnd::kVoid}, {kUnknown3, RayEnd::kVoid}}, 3.0),
              3.0 * patch * share, 1e-9);
  EXPECT_NEAR(GainOf("surface_frontier", {{Ray({0.1f, 0.4f, 0.5f}), RayEnd::kVoid}}, 1e6), patch, 1e-9)
      << "measured but undecided is not counted";
  EXPECT_EQ(GainOfRay("surface_frontier", Ray({0.1f, 0.7f, 0.5f}), RayEnd::kVoid), 0.0) << "likely a surface";
  const auto deep = Ray({0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f});
  EXPECT_NEAR(GainOf("surface_frontier", {{deep, RayEnd::kVoid}}, 1e6), 6.0 * patch, 1e-9)
      << "down to its depth";
}

TEST(GainValues, UnknownNameSuggestsTheNearOne) {
  try {
    FindGain("oclusion_aware");
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'occlusion_aware'"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace atlas::planner
