// Do submaps tell rooms apart? Keyframes, each in a submap and, truly, in a room of the scene.
#pragma once

#include <optional>
#include <vector>

#include "experiments/judge/place_errors.h"
#include "mapping/map.h"
#include "scenes/scene_spec.h"

namespace atlas::experiments {

struct RoomScores {
  /// Hydra (Hughes et al. 2022), over keyframes: the share of a submap's keyframes that lie in the room that
  /// most of them lie in, mean over submaps.
  double precision = 0.0;
  /// The share of a room's keyframes that are in the submap that most of them are in, mean over rooms.
  double recall = 0.0;
  /// Adjusted Rand index of the two partitions (Hubert and Arabie 1985): 1 where they agree, 0 by chance.
  double adjusted_rand = 0.0;
  size_t rooms = 0;         ///< with a keyframe
  size_t rooms_shared = 0;  ///< whose main submap is another room's main submap, too
};

/// `submap[i]` and `room[i]` of keyframe i. Ties go to the lower number. @pre equally many, at least one
RoomScores ScorePartition(const std::vector<int>& submap, const std::vector<int>& room);

/// Index of the name of the room at a place among the scene's room names in their first order; nothing
/// outside all rooms.
std::optional<int> RoomAt(const scenes::SceneSpec& scene, const core::Vec3& p_map);

/// Of the keyframes that a submap holds and that lie in a room; nothing where there are none.
std::optional<RoomScores> ScoreRooms(const scenes::SceneSpec& scene,
                                     const std::vector<PlaceErrors::Place>& places,
                                     const std::vector<mapping::SubmapMembers>& submaps);

}  // namespace atlas::experiments
