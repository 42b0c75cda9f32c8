// False loop closures for testing robust back ends, of the four kinds of Suenderhauf and Protzel ("Switchable
// constraints for robust pose graph SLAM", IROS 2012).
#pragma once

#include "core/rng.h"
#include "mapping/slam/pose_graph.h"

namespace atlas::mapping {

enum class FalseLoopKind : uint8_t {
  kRandom,       ///< between any two nodes
  kLocal,        ///< between nodes that follow each other closely
  kRandomGroup,  ///< runs of loops between two stretches of the way, which agree with each other
  kLocalGroup,   ///< the same between stretches that follow each other closely
};

struct FalseLoopOptions {
  FalseLoopKind kind = FalseLoopKind::kRandom;
  double share = 0.1;         ///< of all loops, the false ones among them; in [0, 1)
  uint32_t group = 10;        ///< loops in a run
  uint32_t local_steps = 20;  ///< nodes that are as close to each other as this follow each other closely
  double sigma_m = 0.3;       ///< of the claimed relative pose, which says "the same place"
  double sigma_rad = 10.0 * core::kPi / 180.0;
  /// A loop is false if it is off by at least this much.
  double least_error_m = 1.0;
};

/// Appends false loops to `graph`, which must have true ones; their information is that of true loops. The
/// graph's poses must be about true: a claim that is nearly right is drawn again.
/// @returns how many were appended.
size_t AddFalseLoops(const FalseLoopOptions& options, core::Rng rng, PoseGraph* graph);

}  // namespace atlas::mapping
