// Ground that plans found walkable, kept beyond the window of the terrain map.
//
// The terrain map rolls with the robot; what lies behind it is forgotten. The roadmap keeps the lattice
// places of earlier plans and the steps between them, so that a view in another room stays a candidate, and
// the way there is known (thesis 3.5 plans in the window only; 4.1 asks for the whole environment).
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "planner/views/candidates.h"

namespace atlas::planner {

class Roadmap {
 public:
  /// Places nearer to each other than this are one.
  static constexpr double kSamePlace_m = 0.05;

  /// Learns the places of a plan's tree and the steps of it.
  void Learn(const CandidateTree& tree);

  /// Appends to `tree` every place that known steps join to it, each by its shortest way. Indices and order
  /// of the nodes before stay.
  void Extend(CandidateTree* tree) const;

  size_t size() const { return places_.size(); }

 private:
  using Cell = std::pair<int, int>;
  struct Step {
    Cell to;
    bool narrow;  ///< through a passage
  };
  struct Place {
    core::Vec2 p_map = core::Vec2::Zero();
    double ground_m = 0.0;
    std::vector<Step> steps;  ///< both ways
  };
  static Cell CellOf(const core::Vec2& p_map);
  void Join(const Cell& a, const Cell& b, bool narrow);

  std::map<Cell, Place> places_;
};

}  // namespace atlas::planner
