#include "experiments/bench/correction_bench.h"

#include <gtest/gtest.h>

namespace atlas::experiments {
namespace {

TEST(CorrectionBench, MovesManySubmapsAndTouchesNoVoxel) {
  CorrectionBench bench;
  bench.nodes = 400;
  bench.submaps = 4;
  bench.corrections = 3;
  const CorrectionResult result = RunCorrectionBench(bench, [](double) {});
  EXPECT_EQ(result.nodes, 400u);
  EXPECT_EQ(result.submaps, 4u);
  EXPECT_GT(result.map_bytes, 1u << 18);
  ASSERT_EQ(result.corrections.size(), 3u);
  for (const CorrectionTimes& times : result.corrections) {
    EXPECT_GT(times.moved_m, 1e-4) << "else there was nothing to correct";
    EXPECT_GT(times.solve_ms, 0.0);
    EXPECT_GT(times.snapshot_ms, 0.0);
    EXPECT_NEAR(times.until_planning_ms(), times.solve_ms + times.apply_ms + times.snapshot_ms, 1e-9);
  }
  EXPECT_NE(CorrectionTable(result).find("median"), std::string::npos);
}

}  // namespace
}  // namespace atlas::experiments
