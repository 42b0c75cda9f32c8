#include "experiments/results/ground_plan.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <functional>
#include <map>

#include "core/errors.h"
#include "core/files.h"
#include "core/rng.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;
using core::Vec2;
using mapping::GroundKind;

/// Widths below a cell's: nothing is narrow or tight.
constexpr double kThin_m = 0.01;

/// Rows from the least y up, a letter a cell: . unknown, f free, o obstacle, d drop, c cut off.
class Patch final : public mapping::TraversableGround {
 public:
  Patch(const Vec2& origin, double cell_m, std::vector<std::string> rows)
      : origin_(origin), cell_m_(cell_m), rows_(std::move(rows)) {}

  Levels LevelsAt(const Vec2&) const override {
    Levels levels;
    levels.Add(0.0);
    return levels;
  }
  GroundKind KindAt(const core::Vec3& p_map) const override {
    const std::map<char, GroundKind> kinds = {{'.', GroundKind::kUnknown},
                                              {'f', GroundKind::kFree},
                                              {'o', GroundKind::kObstacle},
                                              {'d', GroundKind::kDrop},
                                              {'c', GroundKind::kCutOff}};
    const Vec2 cell = (p_map.head<2>() - origin_) / cell_m_;
    return kinds.at(
        rows_.at(static_cast<size_t>(std::floor(cell.y()))).at(static_cast<size_t>(std::floor(cell.x()))));
  }
  core::Box3 Window() const override {
    const Vec2 size =
        cell_m_ * Vec2(static_cast<double>(rows_.front().size()), static_cast<double>(rows_.size()));
    return {{origin_.x(), origin_.y(), -1.0}, {origin_.x() + size.x(), origin_.y() + size.y(), 1.0}};
  }
  double Traversability(const core::Vec3&) const override { return 0.0; }
  bool FootprintFree(const core::Vec3&, double) const override { return false; }
  bool CircleFree(const core::Vec3&) const override { return false; }
  Surface SurfaceAt(const core::Vec3&) const override { return {}; }

 private:
  Vec2 origin_;
  double cell_m_;
  std::vector<std::string> rows_;
};

/// The image in the same letters; t tight, n narrow.
std::vector<std::string> RowsOf(const GroundImage& image) {
  const std::map<GroundCode, char> letters = {{GroundCode::kUnknown, '.'},  {GroundCode::kFree, 'f'},
                                              {GroundCode::kObstacle, 'o'}, {GroundCode::kDrop, 'd'},
                                              {GroundCode::kCutOff, 'c'},   {GroundCode::kTight, 't'},
                                              {GroundCode::kNarrow, 'n'}};
  std::vector<std::string> rows(static_cast<size_t>(image.rows));
  for (size_t i = 0; i < image.code.size(); ++i) {
    rows[i / static_cast<size_t>(image.cols)] += letters.at(image.code[i]);
  }
  return rows;
}

class GroundPlanFiles : public ::testing::Test {
 protected:
  ~GroundPlanFiles() override { fs::remove_all(folder_); }

  void ExpectRefusal(const std::function<void()>& read, const std::vector<std::string>& mentions) {
    try {
      read();
      FAIL() << mentions.front();
    } catch (const core::InputError& error) {
      for (const std::string& word : mentions) {
        EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
      }
    }
  }

  fs::path folder_ = fs::temp_directory_path() / ("atlas_ground_plan_" + std::to_string(::getpid()));
};

TEST(GroundPlan, ItGrowsWithTheWindowAndPlacesStayWhereTheyAre) {
  GroundPlan plan(0.5, kThin_m, kThin_m);
  plan.Learn(Patch({1.0, 2.0}, 0.5, {"fo", "df"}));
  plan.Learn(Patch({0.5, 1.5}, 0.5, {"o"}));       // below and to the left
  plan.Learn(Patch({2.0, 3.0}, 0.5, {"d", "o"}));  // above and to the right
  const GroundImage image = plan.Image();
  EXPECT_EQ(image.origin, Vec2(0.5, 1.5));
  EXPECT_EQ(image.cell_m, 0.5);
  EXPECT_EQ(RowsOf(image), (std::vector<std::string>{"o...",  //
                                                     ".fo.",  //
                                                     ".df.",  //
                                                     "...d",  //
                                                     "...o"}));
}

TEST(GroundPlan, LaterKnowledgeWinsAndIgnoranceDoesNot) {
  GroundPlan plan(0.1, kThin_m, kThin_m);
  plan.Learn(Patch({0, 0}, 0.1, {"ffffooo.c"}));
  plan.Learn(Patch({0, 0}, 0.1, {".foc.fcff"}));
  EXPECT_EQ(RowsOf(plan.Image()), std::vector<std::string>{"ffofofcff"});
}

TEST(GroundPlan, NarrowAndTightFollowFromTheDistanceToWhatIsNotFree) {
  const double cell_m = 0.1, half_width_m = 0.33, turning_radius_m = 0.55;
  core::Rng rng(5);
  std::vector<std::string> rows(30, std::string(40, 'f'));
  for (int i = 0; i < 25; ++i) {
    rows[static_cast<size_t>(rng.UniformInt(30))][static_cast<size_t>(rng.UniformInt(40))] = ".odc"[i % 4];
  }
  GroundPlan plan(cell_m, half_width_m, turning_radius_m);
  plan.Learn(Patch({-3, 7}, cell_m, rows));
  std::vector<std::string> expected = rows;
  std::map<char, int> count;
  for (int r = 0; r < 30; ++r) {
    for (int c = 0; c < 40; ++c) {
      char& cell = expected[static_cast<size_t>(r)][static_cast<size_t>(c)];
      if (cell != 'f') continue;
      double nearest = 1e9;
      for (int y = 0; y < 30; ++y) {
        for (int x = 0; x < 40; ++x) {
          if (rows[static_cast<size_t>(y)][static_cast<size_t>(x)] != 'f')
            nearest = std::min(nearest, cell_m * std::hypot(x - c, y - r));
        }
      }
      cell = nearest <= half_width_m ? 'n' : nearest <= turning_radius_m ? 't' : 'f';
      ++count[cell];
    }
  }
  EXPECT_EQ(RowsOf(plan.Image()), expected);
  for (const char letter : {'n', 't', 'f'}) EXPECT_GT(count[letter], 20) << letter;
}

TEST_F(GroundPlanFiles, TheImageIsRawBytesFromTheTopWithALegend) {
  GroundPlan plan(0.25, kThin_m, kThin_m);
  plan.Learn(Patch({-1.0, 0.5}, 0.25, {"fo.", "dcf"}));
  plan.Write(folder_);
  const std::string expected = std::string("P5\n3 2\n255\n") + '\6' + '\10' + '\1' + '\1' + '\2' + '\0';
  EXPECT_EQ(core::ReadFile(folder_ / "terrain.pgm"), expected);
  const YAML::Node yaml = YAML::LoadFile((folder_ / "terrain.yaml").string());
  EXPECT_EQ(yaml["image"].as<std::string>(), "terrain.pgm");
  EXPECT_EQ(yaml["resolution"].as<double>(), 0.25);
  EXPECT_EQ(yaml["origin"].as<std::vector<double>>(), (std::vector<double>{-1.0, 0.5, 0.0}));
  const std::vector<std::string> names = {"unknown", "free",     "obstacle", "step",  "slope", "roughness",
                                          "drop",    "overhang", "cut_off",  "tight", "narrow"};
  ASSERT_EQ(yaml["legend"].size(), names.size());
  for (size_t code = 0; code < names.size(); ++code) {
    EXPECT_EQ(yaml["legend"][code].as<std::string>(), names[code]);
  }
}

TEST_F(GroundPlanFiles, WhatIsWrittenIsReadBack) {
  GroundPlan plan(0.2, 0.3, 0.6);
  plan.Learn(Patch({-1.2, 0.4}, 0.2, {"fffffffo", "ffffffdc", "ffffffff", ".fffffff"}));
  plan.Write(folder_);
  const GroundImage written = plan.Image(), read = LoadGroundImage(folder_);
  EXPECT_EQ(RowsOf(read), RowsOf(written));
  EXPECT_LT((read.origin - written.origin).norm(), 1e-4);
  EXPECT_EQ(read.cell_m, written.cell_m);
}

TEST_F(GroundPlanFiles, DamagedImagesAreRefusedByName) {
  const auto read = [this] { LoadGroundImage(folder_); };
  ExpectRefusal(read, {"terrain.yaml"});
  const std::string legend = "resolution: 0.1\norigin: [0, 0, 0]\n";
  core::WriteFileAtomically(folder_ / "terrain.yaml", legend);
  ExpectRefusal(read, {"terrain.pgm"});
  const std::string head = "P5\n2 2\n255\n";
  const std::vector<std::pair<std::string, std::string>> damaged = {{head + "\1\1\1", "whole"},
                                                                    {head + "\1\1\1\13", "holds 11"},
                                                                    {"P6\n2 2\n255\n\1\1\1\1", "P5"},
                                                                    {"P5\n-2 2\n255\n\1\1\1\1", "P5"},
                                                                    {"", "P5"}};
  for (const auto& [pgm, word] : damaged) {
    core::WriteFileAtomically(folder_ / "terrain.pgm", pgm);
    ExpectRefusal(read, {"terrain.pgm", word});
  }
  core::WriteFileAtomically(folder_ / "terrain.pgm", head + "\1\1\1\1");
  EXPECT_EQ(LoadGroundImage(folder_).code.size(), 4u);
  for (const char* yaml : {"resolution: wide\norigin: [0, 0]\n", "resolution: 0.1\norigin: 3\n",
                           "resolution: 0.1\norigin: [a, b]\n", "resolution: [\n", "resolution: 0.1\n", "",
                           "resolution: 0.1\norigin: [.nan, 0]\n", "resolution: 0.1\norigin: [0, .inf]\n",
                           "resolution: 0\norigin: [0, 0]\n", "resolution: .nan\norigin: [0, 0]\n"}) {
    core::WriteFileAtomically(folder_ / "terrain.yaml", yaml);
    ExpectRefusal(read, {"terrain.yaml"});
  }
}

TEST_F(GroundPlanFiles, BlockedWaysAreALineEachAndAreReadBack) {
  const std::vector<planner::BlockedWay> ways = {{Vec2(3.2, 1.0), 0.55, 0.66, {}, 0.25},
                                                 {Vec2(-2.125, 0.5), 0.9, 1.1, {}, 1.5},
                                                 {Vec2(4.0, 2.0), 0.4, 0.66, {}, {}}};  // not judged
  EXPECT_EQ(TextOf(ways[0]), "at (3.2, 1.0): 0.55 m wide, 0.66 m needed");
  const std::string csv = BlockedWaysCsv(ways);
  EXPECT_EQ(csv,
            "x_m,y_m,width_m,needed_m,worth_share\n"
            "3.200,1.000,0.550,0.660,0.2500\n"
            "-2.125,0.500,0.900,1.100,1.5000\n"
            "4.000,2.000,0.400,0.660,\n");
  core::WriteFileAtomically(folder_ / "blocked_ways.csv", csv);
  const std::vector<planner::BlockedWay> read = LoadBlockedWays(folder_);
  ASSERT_EQ(read.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read[i].p_map, ways[i].p_map);
    EXPECT_EQ(read[i].width_m, ways[i].width_m);
    EXPECT_EQ(read[i].needed_m, ways[i].needed_m);
    EXPECT_EQ(read[i].worth_share, ways[i].worth_share);
  }
  core::WriteFileAtomically(folder_ / "blocked_ways.csv", csv + "1,2,3\n");
  ExpectRefusal([this] { LoadBlockedWays(folder_); }, {"blocked_ways.csv:5", "five numbers"});
}

}  // namespace
}  // namespace atlas::experiments
