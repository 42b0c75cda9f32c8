// The picture of `render RUN --plan`, looked at pixel by pixel: its colours are those of its own legend.
#include "experiments/video/plan_picture.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <set>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/cli/commands.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;
using core::Vec2;
using sim::Rgb;
using sim::RgbImage;

constexpr int kKinds = 11;  ///< of ground: lines of the legend
enum LegendLine : int { kWay = kKinds, kScans, kScale, kBlocked };
constexpr int kLegendWidth = 430;

Rgb At(const RgbImage& image, int u, int v) {
  const size_t at = 3 * (static_cast<size_t>(v) * static_cast<size_t>(image.width) + static_cast<size_t>(u));
  return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
}

/// A run's files as it leaves them, written by hand: cells of 0.5 m from (-1, 2), each kind twice side by
/// side and unknown ground about them.
class PlanPictures : public ::testing::Test {
 protected:
  static constexpr int kCols = 24, kRows = 3;
  static constexpr double kCell_m = 0.5;
  const Vec2 kOrigin{-1.0, 2.0};

  PlanPictures() {
    std::string bytes(kCols * kRows, '\0');
    for (int kind = 1; kind < kKinds; ++kind) {
      for (const int col : {2 * kind, 2 * kind + 1})
        bytes[static_cast<size_t>(kCols + col)] = static_cast<char>(kind);
    }
    bytes[2] = 2;  // the top row alone holds an obstacle, at its left
    WriteGround(bytes, kCell_m);
    core::WriteFileAtomically(folder_ / "steps.csv", "scan,x_m,y_m\n1,1.5,2.3\n2,6.5,2.3\n");
    core::WriteFileAtomically(folder_ / "trajectory_truth.tum",
                              "0.0 1.5 2.3 0.4 0 0 0 1\n5.0 4.0 2.3 0.4 0 0 0 1\n9.0 6.5 2.3 0.4 0 0 0 1\n");
    core::WriteFileAtomically(folder_ / "blocked_ways.csv",
                              "x_m,y_m,width_m,needed_m,worth_share\n9.0,2.7,0.550,0.660,0.2500\n");
  }
  ~PlanPictures() override { fs::remove_all(folder_); }

  void WriteGround(const std::string& bytes, double cell_m) {
    core::WriteFileAtomically(folder_ / "terrain.pgm", "P5\n" + std::to_string(kCols) + " " +
                                                           std::to_string(kRows) + "\n255\n" + bytes);
    core::WriteFileAtomically(folder_ / "terrain.yaml",
                              "resolution: " + std::to_string(cell_m) + "\norigin: [-1.0, 2.0, 0.0]\n");
  }

  static Rgb LegendColour(const RgbImage& image, int line) {
    return At(image, image.width - kLegendWidth + 20, 10 + 22 * line + 7);
  }
  /// 2 cm a pixel, from half a metre left of and below the middles of the cells that are known.
  static Rgb ColourAt(const RgbImage& image, const Vec2& p) {
    const Vec2 low(0.25 - 0.5, 2.75 - 0.5);
    const int map_height = 75;  // up to half a metre above the middle of the top row
    return At(image, static_cast<int>((p.x() - low.x()) / 0.02),
              map_height - 1 - static_cast<int>((p.y() - low.y()) / 0.02));
  }

  fs::path folder_ = fs::temp_directory_path() / ("atlas_plan_picture_" + std::to_string(::getpid()));
};

TEST_F(PlanPictures, EveryKindOfGroundHasTheColourOfItsLegend) {
  const RgbImage image = PlanPicture(folder_);
  std::set<Rgb> colours;
  for (int kind = 1; kind < kKinds; ++kind) {
    const Rgb colour = LegendColour(image, kind);
    colours.insert(colour);
    const Vec2 corner = kOrigin + kCell_m * Vec2(2 * kind, 1);
    for (const Vec2& inside : {Vec2(0.03, 0.47), Vec2(0.97, 0.47), Vec2(0.5, 0.45)}) {
      const bool under_cross = (corner + inside - Vec2(9.0, 2.7)).norm() < 0.4;
      if (under_cross) continue;
      EXPECT_EQ(ColourAt(image, corner + inside), colour) << kind << " " << inside.transpose();
    }
  }
  EXPECT_EQ(ColourAt(image, {0.25, 3.25}), LegendColour(image, 2))
      << "the first row is the one of greatest y";
  EXPECT_EQ(ColourAt(image, {2.25, 3.25}), LegendColour(image, 0)) << "unknown";
  colours.insert(LegendColour(image, 0));
  EXPECT_EQ(colours.size(), static_cast<size_t>(kKinds)) << "no two alike";
}

TEST_F(PlanPictures, WayScansAndBlockedWaysAreDrawnWhereTheyAre) {
  const RgbImage image = PlanPicture(folder_);
  const Rgb way = LegendColour(image, kWay), scan = LegendColour(image, kScans),
            blocked = LegendColour(image, kBlocked);
  for (const double x : {2.0, 3.99, 5.7, 6.2}) EXPECT_EQ(ColourAt(image, {x, 2.3}), way) << x;
  for (const double x : {1.5, 6.5}) {
    EXPECT_EQ(ColourAt(image, {x, 2.3}), scan) << x;
    EXPECT_EQ(ColourAt(image, {x, 2.38}), scan) << x;
  }
  EXPECT_NE(ColourAt(image, {1.3, 2.3}), way) << "nor before its beginning";
  for (const Vec2& arm : {Vec2(0, 0), Vec2(0.14, 0.14), Vec2(-0.14, 0.14), Vec2(0.14, -0.14)}) {
    EXPECT_EQ(ColourAt(image, Vec2(9.0, 2.7) + arm), blocked) << arm.transpose();
  }
  EXPECT_NE(ColourAt(image, {9.0, 2.86}), blocked) << "a cross, not a disc";
}

TEST_F(PlanPictures, LargeGroundIsDrawnCoarserAndNothingKnownIsDrawnToo) {
  const int small = PlanPicture(folder_).width;
  EXPECT_EQ(small - kLegendWidth, 525) << "9.5 m between middles and the margins, in pixels of 2 cm";
  std::string bytes(kCols * kRows, '\1');
  WriteGround(bytes, 5.0);
  EXPECT_EQ(PlanPicture(folder_).width - kLegendWidth, 1000) << "115 + 1 m on the longest side";
  WriteGround(std::string(kCols * kRows, '\0'), kCell_m);
  EXPECT_EQ(PlanPicture(folder_).width - kLegendWidth, 50) << "the margin alone";
}

TEST_F(PlanPictures, EachMissingOrDamagedFileIsNamed) {
  for (const char* file :
       {"terrain.pgm", "terrain.yaml", "steps.csv", "trajectory_truth.tum", "blocked_ways.csv"}) {
    const std::string whole = core::ReadFile(folder_ / file);
    for (const bool missing : {true, false}) {
      fs::remove(folder_ / file);
      if (!missing) core::WriteFileAtomically(folder_ / file, "this\nis none\n");
      try {
        PlanPicture(folder_);
        ADD_FAILURE() << file << (missing ? " missing" : " damaged");
      } catch (const core::InputError& error) {
        EXPECT_NE(std::string(error.what()).find(file), std::string::npos) << error.what();
      }
    }
    core::WriteFileAtomically(folder_ / file, whole);
  }
  EXPECT_NO_THROW(PlanPicture(folder_));
}

TEST_F(PlanPictures, RenderWritesItAsPng) {
  RenderArguments arguments;
  arguments.what = folder_.string();
  arguments.plan = true;
  ::testing::internal::CaptureStdout();
  const int code = RenderCommand(arguments);
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), (folder_ / "plan.png").string() + "\n");
  EXPECT_EQ(code, 0);
  const std::string png = core::ReadFile(folder_ / "plan.png");
  ASSERT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  const auto side = [&png](size_t at) {
    int value = 0;
    for (size_t i = 0; i < 4; ++i) value = 256 * value + static_cast<uint8_t>(png[at + i]);
    return value;
  };
  const RgbImage image = PlanPicture(folder_);
  EXPECT_EQ(side(16), image.width);
  EXPECT_EQ(side(20), image.height);
  arguments.out = folder_ / "plan.mp4";
  EXPECT_THROW(RenderCommand(arguments), core::InputError) << "a picture is no video";
  arguments.what = (folder_ / "nowhere").string();
  EXPECT_THROW(RenderCommand(arguments), core::InputError);
}

}  // namespace
}  // namespace atlas::experiments
