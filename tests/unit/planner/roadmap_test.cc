#include "planner/graph/roadmap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "core/rng.h"
#include "tests/support/moved_keyframes.h"

namespace atlas::planner {
namespace {

using core::Vec2;

constexpr double kSpacing = 0.5;

/// A random tree over lattice cells of a square whose corner is `corner`, grown from its middle.
CandidateTree RandomTree(const Vec2& corner, int side, core::Rng* rng) {
  CandidateTree tree;
  std::vector<std::pair<int, int>> cells = {{side / 2, side / 2}};
  const Vec2 middle = corner + kSpacing * Vec2(side / 2, side / 2);
  tree.nodes.push_back({middle, -1, 0.0, 0.1 * middle.x()});
  for (int attempt = 0; attempt < 20 * side * side; ++attempt) {
    const int parent = rng->UniformInt(static_cast<int>(cells.size()));
    std::pair<int, int> cell = cells[static_cast<size_t>(parent)];
    cell.first += rng->UniformInt(3) - 1;
    cell.second += rng->UniformInt(3) - 1;
    if (cell.first < 0 || cell.second < 0 || cell.first >= side || cell.second >= side) continue;
    if (std::find(cells.begin(), cells.end(), cell) != cells.end()) continue;
    const Vec2 p = corner + kSpacing * Vec2(cell.first, cell.second);
    const CandidateNode& from = tree.nodes[static_cast<size_t>(parent)];
    tree.nodes.push_back({p, parent, from.path_length_m + (p - from.p_map).norm(), 0.1 * p.x()});
    cells.push_back(cell);
  }
  return tree;
}

TEST(Roadmap, ExtendsATreeByTheShortestKnownWays) {
  core::Rng rng(3);
  const std::vector<CandidateTree> trees = {RandomTree({0, 0}, 9, &rng), RandomTree({3, 1}, 9, &rng),
                                            RandomTree({6, 2}, 9, &rng)};
  Roadmap roadmap;
  for (const CandidateTree& tree : trees) roadmap.Learn(tree, tests::MovedKeyframes());
  CandidateTree extended = trees[2];
  roadmap.Extend(&extended);

  // Oracle: relaxation of all steps of all trees until nothing changes, from the last tree's nodes.
  struct Step {
    Vec2 a, b;
  };
  std::vector<Step> steps;
  std::vector<Vec2> places;
  for (const CandidateTree& tree : trees) {
    for (const CandidateNode& node : tree.nodes) {
      if (node.parent >= 0) steps.push_back({node.p_map, tree.nodes[static_cast<size_t>(node.parent)].p_map});
      const auto same = [&](const Vec2& p) { return (p - node.p_map).norm() < 1e-9; };
      if (std::none_of(places.begin(), places.end(), same)) places.push_back(node.p_map);
    }
  }
  std::vector<double> length(places.size(), std::numeric_limits<double>::infinity());
  const auto index = [&](const Vec2& p) {
    const auto at =
        std::find_if(places.begin(), places.end(), [&](const Vec2& q) { return (p - q).norm() < 1e-9; });
    return static_cast<size_t>(at - places.begin());
  };
  for (const CandidateNode& node : trees[2].nodes) length[index(node.p_map)] = node.path_length_m;
  for (bool changed = true; changed;) {
    changed = false;
    for (const Step& step : steps) {
      for (const auto& [from, to] : {std::pair(step.a, step.b), std::pair(step.b, step.a)}) {
        const bool fixed = std::any_of(trees[2].nodes.begin(), trees[2].nodes.end(),
                                       [&](const CandidateNode& n) { return (n.p_map - to).norm() < 1e-9; });
        const double through = length[index(from)] + (to - from).norm();
        if (fixed || through >= length[index(to)] - 1e-9) continue;
        length[index(to)] = through;
        changed = true;
      }
    }
  }

  EXPECT_EQ(extended.nodes.size(), places.size());
  for (size_t i = 0; i < extended.nodes.size(); ++i) {
    const CandidateNode& node = extended.nodes[i];
    EXPECT_NEAR(node.path_length_m, length[index(node.p_map)], 1e-6);
    EXPECT_LT(node.parent, static_cast<int>(i));
    EXPECT_NEAR(node.ground_m, 0.1 * node.p_map.x(), 1e-12);
  }
}

TEST(Roadmap, RemembersWhichStepsArePassages) {
  CandidateTree there;
  there.nodes = {
      {Vec2(0, 0), -1, 0.0, 0.0}, {Vec2(0.37, 0.21), 0, 0.4, 0.0}, {Vec2(0.37, 1.71), 1, 1.9, 0.0, true}};
  Roadmap roadmap;
  roadmap.Learn(there, tests::MovedKeyframes());
  EXPECT_EQ(roadmap.size(), 3u) << "places beside the lattice are places of their own";
  for (const Vec2& start : {Vec2(0, 0), Vec2(0.37, 1.71)}) {
    CandidateTree here;
    here.nodes = {{start, -1, 0.0, 0.0}};
    roadmap.Extend(&here);
    ASSERT_EQ(here.nodes.size(), 3u);
    for (const CandidateNode& node : here.nodes) {
      if (node.parent < 0) continue;
      const double rise = node.p_map.y() - here.nodes[static_cast<size_t>(node.parent)].p_map.y();
      EXPECT_EQ(node.narrow, std::abs(rise) > 1.0);
    }
  }
}

TEST(Roadmap, LeavesOutWhatNoKnownStepJoins) {
  core::Rng rng(5);
  const CandidateTree here = RandomTree({0, 0}, 5, &rng), apart = RandomTree({50, 0}, 5, &rng);
  Roadmap roadmap;
  roadmap.Learn(here, tests::MovedKeyframes());
  roadmap.Learn(apart, tests::MovedKeyframes());
  CandidateTree extended = here;
  roadmap.Extend(&extended);
  EXPECT_EQ(extended.nodes.size(), here.nodes.size());
  EXPECT_EQ(roadmap.size(), here.nodes.size() + apart.nodes.size());
}

/// The same places and lengths as without a correction, moved as a whole.
TEST(Roadmap, MovesWithTheKeyframesThatItsPlacesWereFoundFrom) {
  CandidateTree row;
  for (int i = 0; i < 8; ++i) row.nodes.push_back({Vec2(0.5 * i, 1.0), i - 1, 0.5 * i, 0.25, i == 3});
  Roadmap roadmap;
  roadmap.Learn(row, tests::MovedKeyframes({core::PoseFromXyzYaw({4.0, 2.0, 0.5}, 0.7)}));
  const core::Pose moved = core::PoseFromXyzYaw({4.3, 1.2, 0.9}, 1.0),
                   T = moved * core::PoseFromXyzYaw({4.0, 2.0, 0.5}, 0.7).inverse();
  roadmap.Correct(tests::MovedKeyframes({moved}, 1));
  const auto at = [&](int i) -> core::Vec3 { return T * core::Vec3(0.5 * i, 1.0, 0.25); };
  CandidateTree tree;
  tree.nodes.push_back({at(0).head<2>(), -1, 0.0, at(0).z(), false});
  roadmap.Extend(&tree);
  ASSERT_EQ(tree.nodes.size(), 8u);
  for (int i = 0; i < 8; ++i) {
    const CandidateNode& node = tree.nodes[static_cast<size_t>(i)];
    EXPECT_LT((node.p_map - at(i).head<2>()).norm(), 1e-9);
    EXPECT_NEAR(node.ground_m, at(i).z(), 1e-9);
    EXPECT_NEAR(node.path_length_m, 0.5 * i, 1e-9);
    EXPECT_EQ(node.narrow, i == 3);
  }
}

/// After a correction, places of the lattice fall between those that are known.
TEST(Roadmap, JoinsNewPlacesToThoseThatACorrectionMovedOffTheLattice) {
  CandidateTree behind, ahead;
  for (int i = 0; i < 4; ++i) behind.nodes.push_back({Vec2(0.5 * i, 0.0), i - 1, 0.5 * i, 0.0, false});
  for (int i = 0; i < 3; ++i) ahead.nodes.push_back({Vec2(1.5 + 0.5 * i, 0.0), i - 1, 0.5 * i, 0.0, false});
  for (const bool corrected : {false, true}) {
    Roadmap roadmap;
    roadmap.Learn(behind, tests::MovedKeyframes());
    const core::Pose shift = core::PoseFromXyzYaw({0.12, -0.1, 0.0}, 0.0);
    const tests::MovedKeyframes now({corrected ? shift : core::Pose::Identity()}, corrected ? 1 : 0);
    roadmap.Learn(ahead, now);
    CandidateTree tree = ahead;
    roadmap.Extend(&tree);
    ASSERT_EQ(tree.nodes.size(), corrected ? 7u : 6u);
    EXPECT_NEAR(tree.nodes.back().p_map.x(), corrected ? 0.12 : 0.0, 1e-9);
  }
}

/// Two rows of places that no step joins, until a correction lays the end of one on the beginning of the
/// other.
TEST(Roadmap, PlacesThatACorrectionBringsTogetherAreOneWay) {
  const core::Pose first = core::Pose::Identity(), second = core::PoseFromXyzYaw({20.0, 0.0, 0.0}, 0.0),
                   second_moved = core::PoseFromXyzYaw({10.0, 0.0, 0.0}, 0.0);
  CandidateTree here, there;
  for (int i = 0; i < 3; ++i) {
    here.nodes.push_back({Vec2(0.5 * i, 0.0), i - 1, 0.5 * i, 0.0});
    there.nodes.push_back({Vec2(11.0 + 0.5 * i, 0.0), i - 1, 0.5 * i, 0.0});
  }
  for (const bool corrected : {false, true}) {
    Roadmap roadmap;
    roadmap.Learn(here, tests::MovedKeyframes({first}));
    roadmap.Learn(there, tests::MovedKeyframes({first, second}));
    if (corrected) roadmap.Correct(tests::MovedKeyframes({first, second_moved}, 1));
    CandidateTree tree;
    tree.nodes.push_back({Vec2(0.0, 0.0), -1, 0.0, 0.0});
    roadmap.Extend(&tree);
    double farthest_m = 0.0;
    for (const CandidateNode& node : tree.nodes) farthest_m = std::max(farthest_m, node.p_map.x());
    EXPECT_NEAR(farthest_m, corrected ? 2.0 : 1.0, 1e-9);
    EXPECT_NEAR(tree.nodes.back().path_length_m, corrected ? 2.0 : 1.0, 1e-9);
  }
}

/// A lower floor, a ramp beside it, and an upper floor right above: places at the same (x, y), 3 m apart.
CandidateTree UpTheRamp() {
  CandidateTree tree;
  const auto add = [&tree](const Vec2& p, double ground_m) {
    const int parent = static_cast<int>(tree.nodes.size()) - 1;
    const double before = parent < 0 ? 0.0 : tree.nodes.back().path_length_m;
    const double length = parent < 0 ? 0.0 : (p - tree.nodes.back().p_map).norm();
    tree.nodes.push_back({p, parent, before + length, ground_m});
  };
  for (double x = 0.0; x <= 4.0; x += kSpacing) add({x, 0.0}, 0.0);
  for (double x = 4.0; x >= -4.0; x -= kSpacing) add({x, 1.0}, 3.0 * (4.0 - x) / 8.0);
  for (double x = -4.0; x <= 4.0; x += kSpacing) add({x, 0.0}, 3.0);
  return tree;
}

TEST(Roadmap, PlacesAboveOneAnotherAreTwo) {
  const CandidateTree tree = UpTheRamp();
  Roadmap roadmap;
  tests::MovedKeyframes poses;
  roadmap.Learn(tree, poses);
  EXPECT_EQ(roadmap.size(), tree.nodes.size());
  roadmap.Learn(tree, poses);
  EXPECT_EQ(roadmap.size(), tree.nodes.size()) << "learnt anew";
}

TEST(Roadmap, TheWayToTheFloorAboveGoesByTheRamp) {
  const CandidateTree tree = UpTheRamp();
  Roadmap roadmap;
  roadmap.Learn(tree, tests::MovedKeyframes());
  CandidateTree there;
  there.nodes.push_back({Vec2(2.0, 0.0), -1, 0.0, 0.0});
  roadmap.Extend(&there);
  const auto place = [&](double ground_m) {
    return std::find_if(there.nodes.begin(), there.nodes.end(), [&](const CandidateNode& node) {
      return (node.p_map - Vec2(2.0, 0.0)).norm() < 1e-9 && std::abs(node.ground_m - ground_m) < 1e-9;
    });
  };
  const auto above = place(3.0);
  ASSERT_NE(above, there.nodes.end());
  EXPECT_NEAR(above->path_length_m, 2.0 + 1.0 + 8.0 + 1.0 + 6.0, 1e-9);
  EXPECT_NE(place(0.0), there.nodes.end());
  EXPECT_EQ(there.nodes.size(), tree.nodes.size());
}

}  // namespace
}  // namespace atlas::planner
