// Feet find the laboratory's ramps where rays see them, from each floor to the next.
#include <gtest/gtest.h>

#include "robots/robot_spec.h"
#include "scenes/catalog.h"
#include "sim/world/world.h"

namespace atlas::sim {
namespace {

TEST(LabRamps, RiseTo3200MillimetresFromFloorToFloor) {
  const World world(scenes::LoadScene("lab_three_storeys"), robots::LoadRobot("quadruped"));
  for (int floor = 0; floor < 2; ++floor) {
    const double z = 3.2 * floor;
    const auto ground = [&](double x, double y, double about) {
      return world.GroundBelow({x, y, about + 0.3});
    };
    EXPECT_NEAR(ground(11.0, -6.8, z).value_or(-9), z, 1e-3);
    for (double y = -3.5; y <= 3.5; y += 0.5) {
      const double share = (y + 3.75) / 7.5;
      EXPECT_NEAR(ground(11.0, y, z + 1.6 * share).value_or(-9), z + 1.6 * share, 1e-3) << y;
      EXPECT_NEAR(ground(13.0, y, z + 3.2 - 1.6 * share).value_or(-9), z + 3.2 - 1.6 * share, 1e-3) << y;
    }
    for (double x = 10.5; x < 13.8; x += 0.5)
      EXPECT_NEAR(ground(x, 5.0, z + 1.6).value_or(-9), z + 1.6, 1e-3);
    EXPECT_NEAR(ground(13.0, -6.8, z + 3.2).value_or(-9), z + 3.2, 1e-3);
    EXPECT_NEAR(ground(0.0, 4.0, z + 3.2).value_or(-9), z + 3.2, 1e-3);
  }
}

}  // namespace
}  // namespace atlas::sim
