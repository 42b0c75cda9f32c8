// Loop detection over a way gone twice: precision and recall of the descriptor alone, of loops verified by
// sight, and of those that the graph's estimate allows too.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace atlas::experiments {

/// What was offered for one keyframe that looked back, the most likely first.
struct LoopOffer {
  double distance = 1.0;  ///< the descriptor's
  bool right =
      false;  ///< the pose offered is true: to 1.5 m and 10 degrees for a descriptor, 0.2 m for a check
};

struct PrecisionRecall {
  double distance = 0.0;  ///< offers up to it count
  double precision = 1.0, recall = 0.0;
};
/// For each distance at which another offer counts. A keyframe without an offer has none (distance above 1).
/// @param revisits keyframes that were near an older one, of which an offer is right or missed.
std::vector<PrecisionRecall> PrecisionRecallOf(const std::vector<LoopOffer>& offers, size_t revisits);

struct PlacesCase {
  std::string scene, lidar;
  size_t keyframes = 0, revisits = 0;
  std::vector<LoopOffer> by_descriptor, by_sight, in_gate;
  double describe_ms = 0.0, query_ms = 0.0, check_ms = 0.0;
};

/// Keyframes every 2 m along the scene's route and back, aside of it and turned; noise on. Repeats exactly,
/// times aside. The gate is that of an estimate 0.6 m and 2 degrees (standard deviations) off.
PlacesCase RunPlacesCase(const std::string& scene, const std::string& lidar, int threads,
                         const std::function<void(double)>& progress);

std::string PlacesTable(const std::vector<PlacesCase>& cases);
/// places.md, places.csv and places.svg, the curves.
void WritePlacesBench(const std::filesystem::path& folder, const std::vector<PlacesCase>& cases);

}  // namespace atlas::experiments
