#include "experiments/judge/room_scores.h"

#include <algorithm>
#include <map>
#include <string>

namespace atlas::experiments {
namespace {

using Counts = std::map<int, std::map<int, size_t>>;  ///< by one label, then by the other

struct Main {
  int label = 0;
  size_t count = 0;
};

Main MainOf(const std::map<int, size_t>& counts) {
  Main main;
  for (const auto& [label, count] : counts) {
    if (count > main.count) main = {label, count};
  }
  return main;
}

double MeanShare(const Counts& counts) {
  double sum = 0.0;
  for (const auto& [label, others] : counts) {
    const Main main = MainOf(others);
    size_t all = 0;
    for (const auto& [other, count] : others) all += count;
    sum += static_cast<double>(main.count) / static_cast<double>(all);
  }
  return sum / static_cast<double>(counts.size());
}

double PairsOf(size_t n) {
  return 0.5 * static_cast<double>(n) * (static_cast<double>(n) - 1.0);
}

double PairsInRows(const Counts& counts) {
  double pairs = 0.0;
  for (const auto& [label, others] : counts) {
    size_t all = 0;
    for (const auto& [other, count] : others) all += count;
    pairs += PairsOf(all);
  }
  return pairs;
}

}  // namespace

RoomScores ScorePartition(const std::vector<int>& submap, const std::vector<int>& room) {
  Counts by_submap, by_room;
  for (size_t i = 0; i < submap.size(); ++i) {
    ++by_submap[submap[i]][room[i]];
    ++by_room[room[i]][submap[i]];
  }
  RoomScores scores{.precision = MeanShare(by_submap), .recall = MeanShare(by_room), .rooms = by_room.size()};
  double together = 0.0;
  for (const auto& [label, others] : by_submap) {
    for (const auto& [other, count] : others) together += PairsOf(count);
  }
  const double in_submaps = PairsInRows(by_submap), in_rooms = PairsInRows(by_room);
  const double all = PairsOf(submap.size());
  const double expected = all > 0.0 ? in_submaps * in_rooms / all : 0.0;
  const double most = 0.5 * (in_submaps + in_rooms);
  // Where both are one cluster, or all singletons, they agree.
  scores.adjusted_rand = most - expected > 1e-12 ? (together - expected) / (most - expected) : 1.0;
  std::map<int, size_t> rooms_of_main;
  for (const auto& [label, others] : by_room) ++rooms_of_main[MainOf(others).label];
  for (const auto& [label, count] : rooms_of_main) scores.rooms_shared += count > 1 ? count : 0;
  return scores;
}

std::optional<int> RoomAt(const scenes::SceneSpec& scene, const core::Vec3& p_map) {
  std::vector<std::string> names;
  for (const scenes::Room& room : scene.rooms) {
    auto at = std::find(names.begin(), names.end(), room.name);
    if (at == names.end()) at = names.insert(names.end(), room.name);
    if (room.box.Contains(p_map)) return static_cast<int>(at - names.begin());
  }
  return std::nullopt;
}

std::optional<RoomScores> ScoreRooms(const scenes::SceneSpec& scene,
                                     const std::vector<PlaceErrors::Place>& places,
                                     const std::vector<mapping::SubmapMembers>& submaps) {
  std::map<core::KeyframeId, int> submap_of;
  for (const mapping::SubmapMembers& members : submaps) {
    for (const core::KeyframeId keyframe : members.keyframes)
      submap_of[keyframe] = static_cast<int>(members.id);
  }
  std::vector<int> submap, room;
  for (const PlaceErrors::Place& place : places) {
    const auto held = submap_of.find(place.base.keyframe);
    const auto in = RoomAt(scene, place.T_map_base_true.translation());
    if (held == submap_of.end() || !in) continue;
    submap.push_back(held->second);
    room.push_back(*in);
  }
  if (submap.empty()) return std::nullopt;
  return ScorePartition(submap, room);
}

}  // namespace atlas::experiments
