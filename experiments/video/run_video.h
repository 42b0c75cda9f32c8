// The video of a run: the robot in its scene, the growing map, the path and the chosen view.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "experiments/video/run_recording.h"
#include "robots/robot_spec.h"
#include "scenes/scene_spec.h"
#include "sim/render/scene_renderer.h"

namespace atlas::experiments {

struct VideoParams {
  int width = 960;
  int height = 540;
  double frames_per_second = 25.0;
  double speed = 8.0;                            ///< times real time
  int samples = 4;                               ///< a pixel: 1, 2 or 4
  std::optional<sim::RenderCamera> camera = {};  ///< stays here; without one a camera follows the robot
};

/// Renders a recording frame by frame.
class RunVideo {
 public:
  /// The recording outlives the video. @throws InputError where no renderer is to be had, or the recording
  /// has no states of this robot.
  RunVideo(const scenes::SceneSpec& scene, const robots::RobotSpec& robot, const RunRecording& recording,
           const VideoParams& params);
  ~RunVideo();

  int frames() const;
  /// @pre 0 <= frame < frames(), and not before the last one asked for: the camera moves on.
  sim::RgbImage Frame(int frame);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// @throws InputError, with the reason, where no video can be made: no renderer or no ffmpeg.
void RequireVideoTools();

/// Renders all of it into an mp4. `progress` hears the share that is done. @throws InputError as RunVideo and
/// VideoWriter do.
void WriteRunVideo(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                   const RunRecording& recording, const VideoParams& params, const std::filesystem::path& mp4,
                   const std::function<void(double)>& progress);

/// The scene alone, seen from outside its object box.
sim::RgbImage RenderScenePicture(const scenes::SceneSpec& scene, int width, int height);
/// The scene alone from `camera`. @throws InputError where no renderer is to be had.
sim::RgbImage RenderStill(const scenes::SceneSpec& scene, const sim::RenderCamera& camera, int width,
                          int height);

}  // namespace atlas::experiments
