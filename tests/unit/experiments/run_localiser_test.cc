// Who is handed the truth.
#include "experiments/mission/run_localiser.h"

#include <gtest/gtest.h>

#include "tests/support/fake_simulator.h"

namespace atlas::experiments {
namespace {

TEST(RunLocaliser, OnlyTheLocaliserTruthIsHandedTheTruth) {
  tests::FakeSimulator simulator;
  simulator.T_map_base_true = core::PoseFromXyzYaw({1.0, 2.0, 0.0}, 0.5);
  simulator.T_odom_base_now = core::PoseFromXyzYaw({0.5, 0.0, 0.0}, 0.1);
  scenes::SceneSpec scene;
  scene.T_map_spawn = core::PoseFromXyzYaw({-3.0, 0.0, 0.0}, 0.0);
  size_t others = 0;
  for (const mapping::LocaliserEntry& entry : mapping::LocaliserCatalog()) {
    ExperimentConfig config;
    config.localisation.name = entry.name;
    const mapping::LocaliserStart start = LocaliserStartFor(config, scene, simulator, 1);
    EXPECT_EQ(start.T_map_odom.matrix(), scene.T_map_spawn.matrix());
    EXPECT_EQ(start.T_odom_base.matrix(), simulator.T_odom_base_now.matrix());
    ASSERT_EQ(static_cast<bool>(start.T_map_base_true), entry.name == "truth") << entry.name;
    if (entry.name == "truth") {
      EXPECT_EQ(start.T_map_base_true().matrix(), simulator.T_map_base_true.matrix());
    } else {
      EXPECT_THROW(start.T_map_base_true(), std::bad_function_call) << entry.name;
      ++others;
    }
  }
  EXPECT_GT(others, 0u);
}

}  // namespace
}  // namespace atlas::experiments
