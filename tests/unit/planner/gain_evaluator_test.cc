#include <gtest/gtest.h>

#include <functional>
#include <numeric>

#include "core/rng.h"
#include "mapping/grid/dense_grid.h"
#include "planner/gain/view_evaluator.h"
#include "tests/support/voxel_world.h"

namespace atlas::planner {
namespace {

using core::Box3;
using core::Vec3;

const Box3 kObjectBox{Vec3(-2.0, -1.0, 0.0), Vec3(2.0, 1.0, 2.0)};
const ViewTarget kTarget{kObjectBox, kObjectBox.Inflated(0.5)};

SweepSensorModel Sensor() {
  SweepSensorModel sensor;
  sensor.lidar = core::FindLidarModel("vlp16");
  sensor.T_base_lidar.translation().z() = 0.25;
  return sensor;
}

mapping::DenseGrid MakeMap(const Box3& region, double resolution_m,
                           const std::function<double(const Vec3&)>& p) {
  mapping::DenseGrid map(region, resolution_m);
  for (size_t i = 0; i < map.frame().count(); ++i) {
    const double occupancy = p(map.frame().CenterOf(i));
    if (occupancy != 0.5) map.SetLogOdds(i, static_cast<float>(std::log(occupancy / (1.0 - occupancy))));
  }
  map.FinishUpdate();
  return map;
}

/// A box-shaped object of which one side is mapped, its shadow unknown, the space before it free.
mapping::DenseGrid HalfMapped() {
  return MakeMap(kObjectBox.Inflated(0.5), 0.1, [](const Vec3& p) {
    if (p.y() < -0.6) return 0.12;
    if (p.y() < -0.5) return std::abs(p.x()) < 1.5 && p.z() < 1.5 ? 0.97 : 0.12;
    if (std::abs(p.x()) > 1.5 && p.z() < 1.0) return 0.12;
    return 0.5;
  });
}

std::vector<ViewNode> RingOfNodes(int count) {
  std::vector<ViewNode> nodes;
  core::Rng rng(3);
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * core::kPi * i / count, radius = rng.Uniform(3.5, 6.0);
    ViewNode node{Vec3(radius * std::cos(angle), radius * std::sin(angle), 0.0), {}};
    for (int h = 0; h < 4; ++h) node.yaw_rad.push_back(h * core::kPi / 4.0 + 0.1 * i);
    nodes.push_back(node);
  }
  return nodes;
}

std::vector<double> Gains(const std::vector<std::vector<ViewGain>>& views, size_t which) {
  std::vector<double> gains;
  for (const auto& node : views) {
    for (const ViewGain& view : node) gains.push_back(view.gain[which]);
  }
  return gains;
}

double Spearman(const std::vector<double>& a, const std::vector<double>& b) {
  const auto ranks = [](const std::vector<double>& v) {
    std::vector<size_t> order(v.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::sort(order.begin(), order.end(), [&](size_t i, size_t j) { return v[i] < v[j]; });
    std::vector<double> rank(v.size());
    for (size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<double>(i);
    return rank;
  };
  const auto ra = ranks(a), rb = ranks(b);
  const double n = static_cast<double>(a.size());
  double d2 = 0.0;
  for (size_t i = 0; i < a.size(); ++i) d2 += (ra[i] - rb[i]) * (ra[i] - rb[i]);
  return 1.0 - 6.0 * d2 / (n * (n * n - 1.0));
}

TEST(ViewEvaluator, EveryViewHasAtLeastTheRaysAskedFor) {
  const ViewEvaluator evaluator(Sensor(), kTarget, {{"occlusion_aware"}, 6000, 20.0});
  size_t traced = 0;
  const auto views = evaluator.Evaluate(HalfMapped(), RingOfNodes(8), 1, &traced);
  for (const auto& node : views) {
    for (const ViewGain& view : node) EXPECT_GE(view.rays, 6000);
  }
  EXPECT_LT(traced, 8u * 13000u) << "headings share rays";
}

TEST(ViewEvaluator, AnyNumberOfThreadsGivesTheSameBits) {
  const ViewEvaluator evaluator(Sensor(), kTarget, {{"occlusion_aware", "unknown_volume"}, 1000, 20.0});
  const auto world = HalfMapped();
  const auto nodes = RingOfNodes(9);
  const auto one = evaluator.Evaluate(world, nodes, 1);
  for (const int threads : {2, 5}) {
    const auto many = evaluator.Evaluate(world, nodes, threads);
    for (size_t i = 0; i < nodes.size(); ++i) {
      for (size_t h = 0; h < one[i].size(); ++h) EXPECT_EQ(one[i][h].gain, many[i][h].gain);
    }
  }
}

TEST(ViewEvaluator, HeadingsTogetherEqualHeadingsAlone) {
  const ViewEvaluator evaluator(Sensor(), kTarget, {GainNames(), 800, 20.0});
  const auto world = HalfMapped();
  const auto nodes = RingOfNodes(2);
  const auto together = evaluator.Evaluate(world, nodes, 1);
  for (size_t i = 0; i < nodes.size(); ++i) {
    for (size_t h = 0; h < nodes[i].yaw_rad.size(); ++h) {
      const auto alone = evaluator.Evaluate(world, {{nodes[i].ground_map, {nodes[i].yaw_rad[h]}}}, 1);
      for (size_t g = 0; g < alone[0][0].gain.size(); ++g) {
        EXPECT_NEAR(together[i][h].gain[g], alone[0][0].gain[g], 1e-9 * (1.0 + alone[0][0].gain[g]))
            << GainNames()[g];
      }
    }
  }
}

TEST(ViewEvaluator, RankingAgreesWithTenTimesDenserRays) {
  const auto world = HalfMapped();
  const auto nodes = RingOfNodes(8);
  const std::vector<std::string> gains = {"occlusion_aware", "occlusion_aware_normalised",
                                          "rear_side_entropy"};
  const auto coarse = ViewEvaluator(Sensor(), kTarget, {gains, 5000, 20.0}).Evaluate(world, nodes, 2);
  const auto dense = ViewEvaluator(Sensor(), kTarget, {gains, 50000, 20.0}).Evaluate(world, nodes, 2);
  for (size_t g = 0; g < gains.size(); ++g) {
    EXPECT_GE(Spearman(Gains(coarse, g), Gains(dense, g)), 0.95) << gains[g];
  }
}

TEST(ViewEvaluator, ABroadsideHeadingSeesMoreOfATallBoxThanABowOnOne) {
  const Box3 tall{Vec3(-1.0, -1.0, 0.0), Vec3(1.0, 1.0, 4.0)};
  const ViewEvaluator evaluator(Sensor(), {tall, tall.Inflated(0.5)}, {{"unknown_volume"}, 2000, 20.0});
  const auto unknown = MakeMap(tall.Inflated(0.5), 0.1, [](const Vec3&) { return 0.5; });
  const ViewNode node{Vec3(0.0, -4.0, 0.0), {0.0, 0.5 * core::kPi}};
  const auto views = evaluator.Evaluate(unknown, {node}, 1);
  EXPECT_GT(views[0][0].gain[0], 1.2 * views[0][1].gain[0]);
}

/// The whole prediction once more by plain means: every direction traced through the brute-force map and
/// added up by the gain itself.
TEST(ViewEvaluator, EqualsAddingUpRaysOfABruteForceTrace) {
  // The same twice: the world tells every voxel by itself, the grid joins what the gains let it join.
  mapping::DenseGrid grid(kTarget.seen_box, 0.25);
  tests::VoxelWorld world(grid.region(), 0.25);
  core::Rng rng(4);
  for (size_t i = 0; i < grid.frame().count(); ++i) {
    if (rng.UniformInt(2) == 0) continue;
    const float log_odds = rng.UniformInt(6) == 0 ? 2.9f : rng.UniformInt(2) ? -1.9f : -2.0f;
    grid.SetLogOdds(i, log_odds);
    world.Set(grid.frame().CenterOf(i), 1.0f / (1.0f + std::exp(-log_odds)));
  }
  grid.FinishUpdate();
  const ViewNode node{Vec3(3.0, -3.0, 0.0), {0.7}};
  const ViewEvaluator evaluator(Sensor(), kTarget, {GainNames(), 400, 20.0});
  const auto view = evaluator.Evaluate(grid, {node}, 1)[0][0];
  const Vec3 origin = node.ground_map + Vec3(0.0, 0.0, 0.44 + 0.25);
  for (size_t g = 0; g < GainNames().size(); ++g) {
    const auto gain = FindGain(GainNames()[g]).build(0.25);
    gain->BeginView();
    std::vector<mapping::RaySample> samples;
    for (const RayDirection& ray : DirectionsInto(kObjectBox, origin, evaluator.view(), 400, 20.0)) {
      const double weight =
          ray.solid_angle_sr * evaluator.view().RaysPerSteradian(ray.azimuth_rad - 0.7, ray.elevation_rad);
      if (weight <= 0.0) continue;
      const auto end = world.Trace(origin, ray.direction_map, {}, &samples);
      gain->AddRay(samples, end, weight);
    }
    const double expected = gain->FinishView();
    const ViewEvaluator alone(Sensor(), kTarget, {{GainNames()[g]}, 400, 20.0});
    const double by_itself = alone.Evaluate(grid, {node}, 1)[0][0].gain[0];
    EXPECT_NEAR(view.gain[g], expected, 1e-5 * (1.0 + expected)) << GainNames()[g];
    EXPECT_NEAR(by_itself, expected, 1e-5 * (1.0 + expected)) << GainNames()[g];
  }
}

TEST(ViewEvaluator, GainSplitByEndAddsUpToTheGain) {
  const ViewEvaluator evaluator(Sensor(), kTarget, {{"occlusion_aware"}, 2000, 20.0});
  const auto world = MakeMap(kObjectBox.Inflated(0.5), 0.1, [](const Vec3& p) {
    return p.z() < 0.0 || (std::abs(p.y()) < 0.2 && p.z() < 1.0) ? 0.97 : 0.5;
  });
  const auto views = evaluator.Evaluate(world, RingOfNodes(3), 1);
  for (const auto& node : views) {
    for (const ViewGain& view : node) {
      EXPECT_NEAR(view.by_end[0] + view.by_end[1] + view.by_end[2], view.gain[0], 1e-9 * view.gain[0]);
      for (const double part : view.by_end) EXPECT_GT(part, 0.0);
    }
  }
}

TEST(ViewEvaluator, ABoxOutOfReachGainsNothing) {
  const ViewEvaluator evaluator(Sensor(), kTarget, {{"occlusion_aware"}, 1000, 5.0});
  const auto views = evaluator.Evaluate(HalfMapped(), {{Vec3(30.0, 0.0, 0.0), {0.0}}}, 1);
  EXPECT_EQ(views[0][0].gain[0], 0.0);
  EXPECT_EQ(views[0][0].rays, 0);
}

TEST(ViewEvaluator, SolidAnglesOfDirectionsAddUpToTheBoxs) {
  // A box seen head on from (0, -5, 0.69): its solid angle by summing over a fine grid of its faces' rays.
  const SweepView view(Sensor());
  const Vec3 origin(0.4, -5.0, 0.69);
  double covered = 0.0;
  for (const RayDirection& ray : DirectionsInto(kObjectBox, origin, view, 5000, 20.0))
    covered += ray.solid_angle_sr;
  double exact = 0.0;
  constexpr double kStep = core::Radians(0.1);
  for (double e = -0.5; e < 0.5; e += kStep) {
    for (double a = 0.0; a < core::kPi; a += kStep) {
      const Vec3 d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
      if (kObjectBox.Clip(origin, d))
        exact += kStep * (std::sin(e + 0.5 * kStep) - std::sin(e - 0.5 * kStep));
    }
  }
  EXPECT_NEAR(covered, exact, 0.02 * exact);
}

}  // namespace
}  // namespace atlas::planner
