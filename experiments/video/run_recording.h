// What a run leaves for its video: the robot's states and what it knew and wanted at each scan.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "sim/simulator.h"

namespace atlas::experiments {

/// In a run folder.
inline constexpr const char* kRecordingFile = "recording.bin";

/// The view that was chosen: where the robot goes next.
struct ChosenView {
  core::Vec2 p_map = core::Vec2::Zero();
  double yaw_rad = 0.0;
};

/// The map and the plan from `time_s` on, until the next keyframe.
struct VideoKeyframe {
  double time_s = 0.0;
  std::vector<core::Vec3f> occupied_map;  ///< voxel centres (mapping::OccupiedCenters)
  std::vector<core::Vec2> path_map;       ///< planned; may be empty
  std::optional<ChosenView> view;
};

/// States every 20 to 100 ms of simulated time (Simulator::AddStateObserver), a keyframe after each sweep and
/// each plan; all by ascending time.
struct RunRecording {
  std::string scene;  ///< as LoadScene takes it
  std::string robot;  ///< as LoadRobot takes it
  double resolution_m = 0.05;
  std::vector<sim::Snapshot> states;
  std::vector<VideoKeyframe> keyframes;
};

/// Builds a recording file as the run goes, in the file's own compact form: voxels as differences between
/// keyframes, about a tenth of a megabyte a minute.
class RecordingWriter {
 public:
  RecordingWriter(const std::string& scene, const std::string& robot, double resolution_m);

  /// @pre the same number of coordinates every time; ascending time.
  void AddState(const sim::Snapshot& state);
  /// The map as it is from now on. @pre ascending time.
  void AddMap(double time_s, const std::vector<core::Vec3f>& occupied_map);
  /// The plan as it is from now on, over the last map.
  void AddPlan(double time_s, const std::vector<core::Vec2>& path_map, const std::optional<ChosenView>& view);

  /// Writes what there is so far, whole or not at all. @throws InputError when that fails.
  void Save(const std::filesystem::path& path) const;

 private:
  using Key = std::array<int16_t, 3>;

  void PutKeyframe(double time_s, std::vector<Key> keys, const std::vector<core::Vec2>& path_map,
                   const std::optional<ChosenView>& view);
  friend void SaveRecording(const std::filesystem::path& path, const RunRecording& recording);

  std::string header_, states_, keyframes_;
  uint32_t coordinates_ = 0, state_count_ = 0, keyframe_count_ = 0;
  double resolution_m_;
  std::vector<Key> keys_;  ///< of the last map, sorted
};

/// A whole recording at once. @throws InputError when that fails.
void SaveRecording(const std::filesystem::path& path, const RunRecording& recording);
/// Scene and robot files that are kept beside the recording are named by where they lie now.
/// @throws InputError for a file that is missing, cut short or of another kind.
RunRecording LoadRecording(const std::filesystem::path& path);

}  // namespace atlas::experiments
