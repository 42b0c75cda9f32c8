// What a run that bears the thesis's name is, and what it says of itself.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/errors.h"
#include "experiments/identity/thesis_deviations.h"
#include "planner/planners/thesis.h"

namespace atlas::experiments {
namespace {

bool Names(const std::vector<std::string>& deviations, const std::string& word) {
  return std::any_of(deviations.begin(), deviations.end(),
                     [&](const std::string& d) { return d.find(word) != std::string::npos; });
}

TEST(ThesisRows, BringTheThesissMapUnlessOneIsNamed) {
  const ExperimentConfig thesis = LoadExperiment("car", {"planner=thesis"});
  EXPECT_EQ(thesis.mapper.name, "octomap");
  EXPECT_EQ(thesis.mapper.resolution_m, 0.05);
  EXPECT_EQ(thesis.mapper.integrator.void_rays, "ignore");
  EXPECT_FALSE(thesis.mission.map_while_walking);
  const ExperimentConfig atlas = LoadExperiment("car", {"planner.name=thesis", "mapper=se_atlas"});
  EXPECT_EQ(atlas.mapper.name, "se_atlas");
  EXPECT_EQ(atlas.mapper.integrator.void_rays, "clear");
  EXPECT_FALSE(atlas.mission.map_while_walking);
  const ExperimentConfig told = LoadExperiment("car", {"planner=thesis", "mapper.void_rays=clear"});
  EXPECT_EQ(told.mapper.name, "octomap");
  EXPECT_EQ(told.mapper.integrator.void_rays, "clear");
  const ExperimentConfig greedy = LoadExperiment("car", {});
  EXPECT_EQ(greedy.mapper.name, "se_atlas");
  EXPECT_TRUE(greedy.mission.map_while_walking);
}

TEST(ThesisRows, PlanAsTheThesisDoes) {
  const ExperimentConfig config = LoadExperiment("car", {"planner=thesis"});
  const auto& p = dynamic_cast<const planner::ThesisParams&>(*config.planner.own);
  EXPECT_EQ(p.gain(), "occlusion_aware");
  EXPECT_EQ(p.nbv.views.nodes, 150);
  EXPECT_EQ(p.window_m(), 12.0);
  EXPECT_EQ(config.planner.terrain.window_m, 12.0);
  EXPECT_EQ(p.nbv.costs.traversal, "discrete");
  EXPECT_EQ(p.nbv.costs.visited_threshold_m, p.nbv.costs.too_close_threshold_m) << "Eq. 3.7 has one";
  EXPECT_GT(p.stop_utility, 0.0);
  for (const char* of_ours : {"commit_margin", "blacklist_after", "distrust_m", "unvisited_m2"}) {
    EXPECT_THROW(LoadExperiment("car", {"planner=thesis", fmt::format("planner.{}=1", of_ours)}),
                 core::InputError);
  }
}

TEST(ThesisRows, NameEachChoiceThatDiffers) {
  EXPECT_TRUE(DeviationsFromThesis(LoadExperiment("car", {})).empty()) << "greedy does not claim to be it";
  const auto faithful = DeviationsFromThesis(LoadExperiment("car", {"planner=thesis"}));
  EXPECT_FALSE(Names(faithful, "OctoMap"));
  EXPECT_FALSE(Names(faithful, "void"));
  EXPECT_FALSE(Names(faithful, "150"));
  EXPECT_TRUE(Names(faithful, "u_thres"));
  EXPECT_TRUE(Names(faithful, "each revolution"));
  EXPECT_TRUE(Names(faithful, "turns, then steps aside (not said)"));
  EXPECT_TRUE(Names(DeviationsFromThesis(LoadExperiment("car", {"planner=thesis", "mission.max_scans=9"})),
                    "at most 9 scans"));
  const std::vector<std::pair<std::string, std::string>> changes = {
      {"mapper=se_atlas", "se_atlas (OctoMap)"}, {"mapper.resolution_m=0.1", "0.1 m (0.05)"},
      {"mapper.void_rays=clear", "void rays"},   {"mission.map_while_walking=true", "walk"},
      {"planner.nodes=75", "150 in 12 m"},       {"planner.too_close_threshold_m=1.1", "d_thres"},
      {"planner.visited_cost=false", "d_thres"}, {"planner.traversal=continuous", "traversal"}};
  for (const auto& [assignment, word] : changes) {
    const auto deviations = DeviationsFromThesis(LoadExperiment("car", {"planner=thesis", assignment}));
    EXPECT_GT(deviations.size(), faithful.size()) << assignment;
    EXPECT_TRUE(Names(deviations, word)) << assignment;
  }
  const auto outdoors = DeviationsFromThesis(LoadExperiment("facade_grass", {"planner=thesis"}));
  EXPECT_EQ(outdoors.size(), faithful.size()) << "75 nodes in 7 m, as the thesis's outdoors";
}

std::string ErrorOf(const std::vector<std::string>& assignments) {
  try {
    LoadExperiment("car", assignments);
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Kinds, RefuseParametersThatOthersHaveInOneLine) {
  EXPECT_EQ(
      ErrorOf({"mapper.hit_probability=0.8"}),
      "--set mapper.hit_probability=0.8: mapper.hit_probability: no parameter of mapper.name = se_atlas");
  EXPECT_EQ(ErrorOf({"mapper=octomap", "mapper.hit_nats=0.8"}),
            "--set mapper.hit_nats=0.8: mapper.hit_nats: no parameter of mapper.name = octomap");
  EXPECT_NE(ErrorOf({"planner=thesis", "planner.stop_ratio=0.1"}).find("planner.name = thesis"),
            std::string::npos);
  EXPECT_NE(ErrorOf({"planner.stop_utility=1"}).find("planner.name = greedy"), std::string::npos);
  EXPECT_EQ(ErrorOf({"planner=thesis", "mapper.hit_probability=0.8"}), "");
}

TEST(Kinds, ListOnlyWhatTheyHave) {
  const auto has = [](const ExperimentConfig& config, const std::string& path) {
    return std::any_of(config.rows.begin(), config.rows.end(),
                       [&](const core::ParamRow& row) { return row.path == path; });
  };
  const ExperimentConfig atlas = LoadExperiment("car", {}),
                         octomap = LoadExperiment("car", {"mapper=octomap"});
  for (const char* path : {"mapper.hit_nats", "mapper.lambda_r", "mapper.max_scale", "mapper.motion_aware"}) {
    EXPECT_TRUE(has(atlas, path)) << path;
    EXPECT_FALSE(has(octomap, path)) << path;
  }
  for (const char* path : {"mapper.hit_probability", "mapper.miss_probability", "mapper.clamp_min"}) {
    EXPECT_FALSE(has(atlas, path)) << path;
    EXPECT_TRUE(has(octomap, path)) << path;
  }
  for (const char* path :
       {"mapper.max_range_m", "mapper.void_rays", "mapper.void_range_m", "mapper.resolution_m"}) {
    EXPECT_TRUE(has(atlas, path) && has(octomap, path)) << path;
  }
}

}  // namespace
}  // namespace atlas::experiments
