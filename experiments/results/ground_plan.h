// The ground as planning knew it over a whole mission, and why it left some of it out: terrain.pgm.
//
// The terrain map rolls with the robot; the plan keeps what it knew everywhere. Files of the run folder:
//   terrain.pgm        a byte a cell (GroundCode), row 0 = greatest y: an image that any viewer opens
//   terrain.yaml       resolution, origin of the lower left corner, and what the bytes mean (the form of ROS
//                      map_server)
//   blocked_ways.csv   ways thought too narrow
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "mapping/terrain/traversable_ground.h"
#include "planner/decision.h"

namespace atlas::experiments {

inline constexpr const char* kGroundImageFile = "terrain.pgm";
inline constexpr const char* kGroundLegendFile = "terrain.yaml";
inline constexpr const char* kBlockedWaysFile = "blocked_ways.csv";

/// What a cell of the plan holds: mapping::GroundKind, and where the ground is free but not the robot.
enum class GroundCode : uint8_t {
  kUnknown,
  kFree,
  kObstacle,
  kStep,
  kSlope,
  kRoughness,
  kDrop,
  kOverhang,
  kCutOff,
  kTight,   ///< free; the robot fits but cannot turn
  kNarrow,  ///< free; nearer to what is not than half the robot's width
};
inline constexpr int kGroundCodes = 11;

/// "free", "narrow".
const char* NameOf(GroundCode code);

/// A grid in the map frame: row-major, row = y from `origin` upwards.
struct GroundImage {
  int rows = 0, cols = 0;
  double cell_m = 0.0;
  core::Vec2 origin = core::Vec2::Zero();
  std::vector<GroundCode> code;
};

class GroundPlan {
 public:
  /// Widths in metres: of the footprint's half across, and of the circle in which it turns.
  GroundPlan(double cell_m, double half_width_m, double turning_radius_m)
      : cell_m_(cell_m), half_width_m_(half_width_m), turning_radius_m_(turning_radius_m) {}

  /// Later knowledge wins; where the window knows nothing (or no way joins the place to the robot any more)
  /// stays what was known.
  void Learn(const mapping::TraversableGround& ground);
  /// All ground so far.
  GroundImage Image() const;
  /// Writes terrain.pgm and terrain.yaml. @throws InputError where they cannot be written.
  void Write(const std::filesystem::path& folder) const;

 private:
  void Cover(int min_x, int min_y, int cols, int rows);

  double cell_m_, half_width_m_, turning_radius_m_;
  int min_x_ = 0, min_y_ = 0, cols_ = 0, rows_ = 0;  ///< in cells of the map frame
  std::vector<mapping::GroundKind> kind_;
};

/// Reads what Write wrote. @throws InputError for a missing or malformed file.
GroundImage LoadGroundImage(const std::filesystem::path& folder);

/// "at (3.2, 1.0): 0.55 m wide, 0.66 m needed".
std::string TextOf(const planner::BlockedWay& way);
/// x_m, y_m, width_m, needed_m, worth_share (empty where no plan judged it); a line a way.
std::string BlockedWaysCsv(const std::vector<planner::BlockedWay>& ways);
/// Reads them back (without the places beyond). @throws InputError for a missing or malformed file.
std::vector<planner::BlockedWay> LoadBlockedWays(const std::filesystem::path& folder);

}  // namespace atlas::experiments
