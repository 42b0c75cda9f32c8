// The whole cone integrator against the scalar rule, voxel by voxel, on random scenes.
//
// Each scan starts from the map as it is, so that a difference is of one scan. The two are identical but for
// what the integrator leaves open where it is far from the sensor: cells lie 0.1 voxels or 0.05 rows off at
// most there, since octants and blocks take the first order of the projection about their middles. A voxel
// that differs must be one that the rule has as the integrator does, with its block moved by as much. Floats
// decide a few otherwise, where a return lies on the face of a voxel or a ray between two cells.
#include "tests/support/cone_reference.h"

#include <gtest/gtest.h>

#include "tests/support/integrator_scenes.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
namespace cone = tests::cone;

constexpr double kExactVoxels = 24.0;  ///< blocks nearer to the LiDAR's axis are projected exactly
// Of the voxels that a scan changes, at most:
constexpr double kMostDiffer = 0.01;      ///< differ; measured 0.0003 to 0.006
constexpr double kMostDifferNear = 5e-5;  ///< of exactly projected blocks; measured 0 to 2e-5
/// And are no matter of 0.1 voxels; measured 0 to 1.6e-4: a ray that falls between two cells, to 1e-4 of a
/// cell, turns the planes of four neighbours, and 50 voxels with them.
constexpr double kMostUnexplained = 4e-4;

/// A ground, perhaps a wall, boxes, balls and pillars where chance has them; the sensor may stand in one.
tests::AnalyticWorld RandomWorld(core::Rng* rng) {
  tests::AnalyticWorld world;
  const auto place = [&] { return Vec3(rng->Uniform(-3, 3), rng->Uniform(-3, 3), rng->Uniform(-1, 1)); };
  world.AddPlane({0.1 * rng->Normal(), 0.1 * rng->Normal(), 1.0}, rng->Uniform(-1.4, -0.6));
  if (rng->UniformInt(2) == 0) world.AddPlane({1.0, rng->Normal(), 0.2}, rng->Uniform(2.0, 3.5));
  for (int k = 0; k < 4; ++k) {
    const Vec3 p = place(), q = place();
    world.AddBox({p, p + Vec3(rng->Uniform(0.1, 1), rng->Uniform(0.1, 1), rng->Uniform(0.1, 1.5))});
    world.AddSphere(place(), rng->Uniform(0.1, 0.5));
    world.AddPillar(q.x(), q.y(), rng->Uniform(0.02, 0.2), -1.5, 1.5);
  }
  return world;
}

/// Of one revolution, anywhere near the middle and tilted.
core::PoseTrajectory RandomPath(core::Rng* rng, bool moving) {
  const auto turn = [&](double most) { return rng->Uniform(-most, most); };
  const core::Pose from = core::MakePose(core::RotationFromYawPitchRoll(turn(3.0), turn(0.1), turn(0.3)),
                                         {turn(1.0), turn(1.0), turn(0.3)});
  const core::Pose by = core::MakePose(core::RotationFromYawPitchRoll(turn(0.2), turn(0.1), turn(0.1)),
                                       {turn(0.1), turn(0.1), turn(0.03)});
  core::PoseTrajectory path;
  path.Add(0.0, from);
  if (moving) path.Add(0.1, from * by);
  return path;
}

struct Case {
  const char* name;
  int rows, columns;
  double resolution;
  bool moving;
  std::function<void(IntegratorParams*, core::LidarModel*)> change;
};

struct Agreement {
  size_t changed = 0, differ = 0, differ_near = 0, unexplained = 0;
};

class ConeReference : public ::testing::TestWithParam<Case> {
 public:
  void SetUp() override {
    lidar_ = tests::SmallLidar(GetParam().rows, GetParam().columns);
    lidar_.dropout_probability = 0.01;
    lidar_.max_range_m = 10.0;
    params_.max_range_m = 4.5;
    params_.void_range_m = 3.5;
    params_.lossless = true;
    GetParam().change(&params_, &lidar_);
  }

  /// Integrates a scan and holds every block about the sensor against the reference.
  void Compare(const core::SpinEvent& spin, ScanIntegrator<OccupancyField>* integrator,
               OccupancyOctree* map) {
    const cone::ScanReference reference(spin, lidar_, params_, map->resolution_m());
    const OccupancyOctree before = map->Clone();
    integrator->Integrate(spin, core::Pose::Identity(), map);
    sensor_ = cone::MiddlePose(spin).translation() / map->resolution_m();
    const double reach = params_.max_range_m / map->resolution_m() + 8.0;
    const auto block_at = [](double v) { return static_cast<int>(std::floor(v / 8.0)); };
    size_t known = 0;
    for (int z = block_at(sensor_.z() - reach); z <= block_at(sensor_.z() + reach); ++z) {
      for (int y = block_at(sensor_.y() - reach); y <= block_at(sensor_.y() + reach); ++y) {
        for (int x = block_at(sensor_.x() - reach); x <= block_at(sensor_.x() + reach); ++x) {
          known += CompareBlock(reference, before, *map, {x, y, z});
        }
      }
    }
    EXPECT_GT(known, 3000u);
  }

 protected:
  static Vec3 MiddleOf(const NodeKey& block) {
    return 8.0 * Vec3(block.x, block.y, block.z) + Vec3::Constant(4.0);
  }
  /// Returns how many of its voxels are known.
  size_t CompareBlock(const cone::ScanReference& reference, const OccupancyOctree& before,
                      const OccupancyOctree& map, const NodeKey& key) {
    const cone::Block old = cone::BlockIn(before, key), now = cone::BlockIn(map, key);
    const cone::Block expected = reference.After(old, key);
    std::vector<size_t> differing;
    size_t known = 0;
    for (size_t i = 0; i < kBlockVoxels; ++i) {
      known += now.value[i] != 0;
      agreement_.changed += expected.value[i] != old.value[i];
      if (expected.value[i] != now.value[i]) differing.push_back(i);
    }
    agreement_.differ += differing.size();
    if (reference.AxisDistance(MiddleOf(key)) < kExactVoxels) agreement_.differ_near += differing.size();
    if (!differing.empty()) agreement_.unexplained += CountUnexplained(reference, old, now, key, differing);
    return known;
  }

  /// Those that the rule does not have so anywhere within what first order may be off.
  size_t CountUnexplained(const cone::ScanReference& reference, const cone::Block& old,
                          const cone::Block& now, const NodeKey& key, std::vector<size_t> differing) const {
    const double off = 0.1 + 0.05 * reference.RowPitchRad() * (MiddleOf(key) - sensor_).norm();
    for (int k = 0; k < 27; ++k) {
      const cone::Block moved = reference.After(old, key, off * Vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
      std::erase_if(differing, [&](size_t i) { return moved.value[i] == now.value[i]; });
    }
    return differing.size();
  }

  core::LidarModel lidar_;
  IntegratorParams params_;
  Vec3 sensor_ = Vec3::Zero();  ///< voxels
  Agreement agreement_;
};

TEST_P(ConeReference, EveryVoxelIsAsTheScalarRuleHasIt) {
  const Case& c = GetParam();
  core::Rng rng(core::Rng(31).Split(c.name));
  for (int scene = 0; scene < 2; ++scene) {
    const tests::AnalyticWorld world = RandomWorld(&rng);
    OccupancyOctree map(c.resolution);
    const auto integrator = MakeConeIntegrator<OccupancyField>(params_, lidar_);
    for (int k = 0; k < 2; ++k) {
      const auto spin = tests::SpinThrough(world, lidar_, 0.0, RandomPath(&rng, c.moving), &rng);
      Compare(spin, integrator.get(), &map);
    }
  }
  const auto changed = static_cast<double>(agreement_.changed);
  RecordProperty("differ", static_cast<int>(agreement_.differ));
  RecordProperty("unexplained", static_cast<int>(agreement_.unexplained));
  EXPECT_GT(changed, 30000.0);
  EXPECT_LE(static_cast<double>(agreement_.differ), kMostDiffer * changed);
  EXPECT_LE(static_cast<double>(agreement_.differ_near), kMostDifferNear * changed);
  EXPECT_LE(static_cast<double>(agreement_.unexplained), kMostUnexplained * changed);
}

const Case kCases[] = {{"Standing", 24, 300, 0.1, false, [](IntegratorParams*, core::LidarModel*) {}},
                       {"Moving", 24, 300, 0.1, true, [](IntegratorParams*, core::LidarModel*) {}},
                       {"Collapsing", 24, 300, 0.1, true,
                        [](IntegratorParams* p, core::LidarModel*) {
                          p->lossless = false;
                          p->miss_nats = 1.0;
                        }},
                       {"WideCells", 12, 96, 0.06, true, [](IntegratorParams*, core::LidarModel*) {}},
                       {"EvenBeams", 32, 256, 0.08, true,
                        [](IntegratorParams* p, core::LidarModel* lidar) {
                          for (size_t row = 0; row < 32; ++row)
                            lidar->elevation_rad[row] = 0.4 - 0.8 / 31.0 * static_cast<double>(row);
                          p->max_scale = 1;
                          p->pierce_voxels = 0.0;
                        }},
                       {"Skimming", 20, 200, 0.12, true, [](IntegratorParams* p, core::LidarModel*) {
                          p->skim_cosine = 0.5;
                          p->void_rays = "ignore";
                          p->hit_nats = 2.4;  // two scans saturate
                          p->sigma_min_m = 0.03;
                        }}};

INSTANTIATE_TEST_SUITE_P(, ConeReference, ::testing::ValuesIn(kCases),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace atlas::mapping
