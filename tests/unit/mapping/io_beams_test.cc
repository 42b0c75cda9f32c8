#include <gtest/gtest.h>

#include "core/errors.h"
#include "core/files.h"
#include "mapping/io/beam_table.h"
#include "tests/support/recorded_scans.h"
#include "tests/support/shared_data.h"

namespace atlas::mapping {
namespace {

using tests::DriverQuirks;

std::vector<DriverQuirks> AllQuirks() {
  std::vector<DriverQuirks> all;
  for (int bits = 0; bits < 8; ++bits) {
    DriverQuirks quirks;
    quirks.counter_clockwise = bits & 1;
    quirks.destaggered = bits & 2;
    quirks.bottom_row_first = bits & 4;
    quirks.first_azimuth_rad = 0.7 * bits - 3.0;
    quirks.missing = 0.3;
    quirks.point_noise_m = 0.02;
    all.push_back(quirks);
  }
  return all;
}

std::vector<RecordedCloud> Clouds(const core::LidarModel& model, const DriverQuirks& quirks, int count) {
  std::vector<RecordedCloud> clouds;
  for (int i = 0; i < count; ++i)
    clouds.push_back(tests::RoomCloud(model, quirks, static_cast<uint64_t>(i + 1),
                                      core::Vec3(0.4 * i, -0.2 * i, 0.1 * i)));
  return clouds;
}

/// The greatest angle between where the two say that a pixel points.
double WorstAngleDeg(const core::LidarModel& a, const core::LidarModel& b) {
  double worst = 0.0;
  for (int row = 0; row < a.rows(); ++row) {
    for (int column = 0; column < a.columns; column += 7) {
      worst = std::max(worst, (a.Direction(row, column) - b.Direction(row, column)).norm());
    }
  }
  return core::Degrees(worst);
}

TEST(Beams, EstimatedWithinAFewHundredthsOfADegreeWhateverTheDriverDoes) {
  for (const char* name : {"os1_64", "vlp16"}) {
    for (const DriverQuirks& quirks : AllQuirks()) {
      const core::LidarModel truth = tests::Presented(core::FindLidarModel(name), quirks);
      const BeamFit fit = EstimateBeams(Clouds(truth, quirks, 3), "the log");
      EXPECT_EQ(fit.counter_clockwise, quirks.counter_clockwise);
      EXPECT_EQ(fit.measured_rows, truth.rows());
      EXPECT_LT(WorstAngleDeg(fit.model, truth), 0.05) << name;
      EXPECT_LT(core::Degrees(fit.elevation_residual_rad), 0.3);
      EXPECT_GT(core::Degrees(fit.elevation_residual_rad), 0.01) << "the noise is told";
    }
  }
}

TEST(Beams, ATableIsTurnedAndShiftedToTheDriversColumns) {
  for (const DriverQuirks& quirks : AllQuirks()) {
    core::LidarModel table = core::FindLidarModel("os1_64");
    const core::LidarModel truth = tests::Presented(table, quirks);
    table.columns = 512;  // the recorded mode is another than the table's
    const BeamFit fit = FitBeams(table, Clouds(truth, quirks, 2), "the log");
    EXPECT_LT(WorstAngleDeg(fit.model, truth), 0.02);
    EXPECT_EQ(fit.model.elevation_rad, truth.elevation_rad) << "as tabled, in the rows' order";
    EXPECT_EQ(fit.model.max_range_m, 120.0);
  }
}

TEST(Beams, RowsWithoutReturnsAreInterpolatedAndPartOfATurnIsNoTurn) {
  DriverQuirks quirks;
  quirks.point_noise_m = 0.005;
  core::LidarModel truth = tests::Presented(core::FindLidarModel("os1_64"), quirks);
  truth.column_step_rad *= 0.25;  // a window of 90 degrees
  auto clouds = Clouds(truth, quirks, 2);
  for (RecordedCloud& cloud : clouds) {
    for (const int row : {0, 1, 20, 63}) {
      for (int c = 0; c < cloud.columns; ++c)
        cloud.p_lidar[static_cast<size_t>(row * cloud.columns + c)].setConstant(std::nanf(""));
    }
  }
  const BeamFit fit = EstimateBeams(clouds, "the log");
  EXPECT_EQ(fit.measured_rows, 60);
  EXPECT_NEAR(fit.model.column_step_rad, truth.column_step_rad, 1e-7);
  EXPECT_LT(WorstAngleDeg(fit.model, truth), 0.05);
}

TEST(Beams, CloudsThatAreNoSpinningLidarsAreRefused) {
  const DriverQuirks quirks;
  const core::LidarModel model = tests::Presented(core::FindLidarModel("vlp16"), quirks);
  const auto expect_refused = [](const std::vector<RecordedCloud>& clouds, const char* word) {
    try {
      EstimateBeams(clouds, "the log");
      ADD_FAILURE() << word;
    } catch (const core::InputError& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  auto clouds = Clouds(model, quirks, 2);
  expect_refused({}, "no cloud");
  auto rolled = clouds;  // levelled: rows no longer have one elevation
  for (core::Vec3f& p : rolled[0].p_lidar) p = Eigen::AngleAxisf(0.2f, core::Vec3f::UnitX()) * p;
  expect_refused({rolled[0]}, "not the scan of a spinning LiDAR");
  auto unorganised = clouds;
  unorganised[0].organised = false;
  expect_refused(unorganised, "no organised");
  auto empty = clouds[0];
  for (core::Vec3f& p : empty.p_lidar) p.setConstant(std::nanf(""));
  expect_refused({empty}, "too few returns");
  auto other = core::FindLidarModel("os1_64");
  expect_refused({clouds[0], tests::RoomCloud(tests::Presented(other, quirks), quirks, 1)}, "in one log");
  EXPECT_THROW(FitBeams(other, clouds, "the log"), core::InputError) << "16 rows are not 64";
  auto tilted = core::FindLidarModel("vlp16");
  for (double& e : tilted.elevation_rad) e += core::Radians(5.0);
  EXPECT_THROW(FitBeams(tilted, clouds, "the log"), core::InputError);
}

TEST(OusterMetadata, AnglesInDegreesTurnClockwise) {
  const char* text =
      R"({"beam_intrinsics": {"beam_altitude_angles": [10, 0.5, -10], "beam_azimuth_angles": [3, 1, -1]}})";
  const core::LidarModel model = ParseOusterMetadata(text, "os.json");
  ASSERT_EQ(model.rows(), 3);
  EXPECT_NEAR(core::Degrees(model.elevation_rad[1]), 0.5, 1e-12);
  EXPECT_NEAR(core::Degrees(model.azimuth_offset_rad[0]), -3.0, 1e-12);
  for (const char* bad : {"", "[]", "{", "{}", R"({"beam_altitude_angles": [1, 2]})",
                          R"({"beam_altitude_angles": [1, 2], "beam_azimuth_angles": [1]})",
                          R"({"beam_altitude_angles": [1, "a"], "beam_azimuth_angles": [1, 2]})",
                          R"({"beam_altitude_angles": [1, 999], "beam_azimuth_angles": [1, 2]})"}) {
    EXPECT_THROW(ParseOusterMetadata(bad, "os.json"), core::InputError) << bad;
  }
  if (const auto path = tests::SharedData("ouster/os1-64_fw2.1.2.json")) {
    const core::LidarModel real = ReadOusterMetadata(*path);
    ASSERT_EQ(real.rows(), 64);
    EXPECT_NEAR(core::Degrees(real.elevation_rad.front()), 16.729, 1e-9);
    EXPECT_NEAR(core::Degrees(real.azimuth_offset_rad.front()), -3.073, 1e-9);
  }
}

}  // namespace
}  // namespace atlas::mapping
