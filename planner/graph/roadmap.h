// Ground that plans found walkable, kept beyond the window of the terrain map.
//
// The terrain map rolls with the robot; what lies behind it is forgotten. The roadmap keeps the lattice
// places of earlier plans and the steps between them, so that a view in another room stays a candidate, and
// the way there is known (thesis 3.5 plans in the window only; 4.1 asks for the whole environment). Places
// are kept relative to keyframes: a correction of the map moves them, and the steps between them stay.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/keyframe.h"
#include "planner/views/candidates.h"

namespace atlas::planner {

class Roadmap {
 public:
  /// Places nearer to each other than this, on one floor, are one.
  static constexpr double kSamePlace_m = 0.05;

  /// Moves every place to where its keyframe lies now.
  void Correct(const core::PoseSource& poses);
  /// Learns the places of a plan's tree and the steps of it. Once a correction has moved places off the
  /// lattice, new ones are joined to those within kNear_m.
  void Learn(const CandidateTree& tree, const core::PoseSource& poses);

  /// Appends to `tree` every place that known steps join to it, each by its shortest way. Indices and order
  /// of the nodes before stay.
  void Extend(CandidateTree* tree) const;

  size_t size() const { return places_.size(); }

 private:
  static constexpr double kNear_m = 0.3;
  using Cell = std::pair<int, int>;
  struct Step {
    size_t to;    ///< index of a place
    bool narrow;  ///< through a passage
  };
  struct Place {
    core::AnchoredPoint anchor;  ///< the ground
    core::Vec2 p_map = core::Vec2::Zero();
    double ground_m = 0.0;
    std::vector<Step> steps;  ///< both ways
  };
  static constexpr size_t kNone = static_cast<size_t>(-1);
  static Cell CellOf(const core::Vec2& p_map);
  static bool SameFloor(double a_m, double b_m);
  /// The place of a cell on the floor at this height, or kNone.
  size_t PlaceAt(const core::Vec2& p_map, double ground_m) const;
  void Join(size_t a, size_t b, bool narrow);
  void JoinToNear(size_t place);

  std::vector<Place> places_;
  std::map<Cell, std::vector<size_t>> at_;  ///< of places in one cell the oldest on each floor
  uint64_t version_ = 0;                    ///< of the poses that places are posed by
  bool corrected_ = false;
};

}  // namespace atlas::planner
