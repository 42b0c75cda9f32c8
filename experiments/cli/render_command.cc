#include <fmt/format.h>

#include <charconv>
#include <iostream>

#include "core/errors.h"
#include "core/temporary_file.h"
#include "experiments/cli/commands.h"
#include "experiments/cli/progress_line.h"
#include "experiments/video/plan_picture.h"
#include "experiments/video/run_video.h"
#include "experiments/video/video_writer.h"
#include "robots/robot_spec.h"
#include "scenes/catalog.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;

constexpr int kMinSide = 16, kMaxSide = 8192;

/// "WIDTHxHEIGHT"; a video's sides are even.
void ReadSize(const RenderArguments& arguments, VideoParams* params) {
  const std::string& text = arguments.size;
  const char* end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, params->width);
  const bool cross = width.ec == std::errc{} && width.ptr != end && *width.ptr == 'x';
  const auto height = std::from_chars(cross ? width.ptr + 1 : end, end, params->height);
  if (!cross || height.ec != std::errc{} || height.ptr != end) {
    throw core::InputError("render: --size " + text + ": expected WIDTHxHEIGHT, such as 960x540");
  }
  for (const int side : {params->width, params->height}) {
    const bool odd = !arguments.still && side % 2 != 0;
    if (side < kMinSide || side > kMaxSide || odd) {
      throw core::InputError(fmt::format("render: --size {}: each side is from {} to {}{}", text, kMinSide,
                                         kMaxSide, odd ? " and even" : ""));
    }
  }
}

std::optional<sim::RenderCamera> CameraOf(const RenderArguments& arguments) {
  if (arguments.eye.empty() && arguments.target.empty()) return std::nullopt;
  if (arguments.eye.size() != 3 || arguments.target.size() != 3) {
    throw core::InputError("render: --eye and --target go together, each X Y Z in the map frame");
  }
  const core::Vec3 eye(arguments.eye.data()), target(arguments.target.data());
  if ((eye - target).head<2>().norm() < 1e-6) {
    throw core::InputError("render: --eye: must not stand straight above or below --target");
  }
  sim::RenderCamera camera;
  camera.T_map_camera = sim::LookAt(eye, target);
  return camera;
}

fs::path OutputOf(const RenderArguments& arguments, const fs::path& otherwise) {
  const fs::path out = arguments.out.empty() ? otherwise : arguments.out;
  const std::string wanted = arguments.still || arguments.plan ? ".png" : ".mp4";
  if (out.extension() != wanted) {
    throw core::InputError(fmt::format("render: --out {}: expected a name ending {}", out.string(), wanted));
  }
  core::RemoveStaleTemporaries(out.parent_path());
  return out;
}

sim::RgbImage StillOf(const RunRecording& recording, const RenderArguments& arguments, VideoParams params) {
  params.speed = 1.0;
  RunVideo video(scenes::LoadScene(recording.scene), robots::LoadRobot(recording.robot), recording, params);
  const double start_s = recording.states.front().time_s, end_s = recording.states.back().time_s;
  const double time_s = arguments.still_time_s.value_or(end_s);
  if (time_s < start_s || time_s > end_s) {
    throw core::InputError(
        fmt::format("render: --still {}: the run goes from {:.1f} to {:.1f} s", time_s, start_s, end_s));
  }
  const int frame = static_cast<int>(std::floor((time_s - start_s) * params.frames_per_second));
  return video.Frame(std::min(frame, video.frames() - 1));
}

void RenderVideo(const RunRecording& recording, const VideoParams& params, const fs::path& out) {
  ProgressLine line;
  WriteRunVideo(
      scenes::LoadScene(recording.scene), robots::LoadRobot(recording.robot), recording, params, out,
      [&line](double share) { line.Show(fmt::format("rendering {:3.0f} %", 100.0 * share), share >= 1.0); });
}

void RenderSceneAlone(const scenes::SceneSpec& scene, const VideoParams& params, const fs::path& out) {
  WritePng(out, params.camera ? RenderStill(scene, *params.camera, params.width, params.height)
                              : RenderScenePicture(scene, params.width, params.height));
}

}  // namespace

int RenderCommand(const RenderArguments& arguments) {
  VideoParams params;
  params.speed = arguments.speed;
  ReadSize(arguments, &params);
  params.camera = CameraOf(arguments);
  const fs::path run = arguments.what, file = run / kRecordingFile;
  fs::path out;
  std::error_code error;
  if (arguments.plan) {
    if (!fs::is_directory(run, error))
      throw core::InputError("render: " + run.string() + ": no such run folder");
    out = OutputOf(arguments, run / "plan.png");
    WritePng(out, PlanPicture(run));
  } else if (fs::exists(run, error) && run.extension() != ".yaml") {
    const RunRecording recording = LoadRecording(file);
    out = OutputOf(arguments, run / (arguments.still ? "still.png" : "video.mp4"));
    if (arguments.still) {
      WritePng(out, StillOf(recording, arguments, params));
    } else {
      RenderVideo(recording, params, out);
    }
  } else if (arguments.still && (run.extension() == ".yaml" || !run.has_parent_path())) {
    const scenes::SceneSpec scene = scenes::LoadScene(arguments.what);
    out = OutputOf(arguments, run.stem().string() + ".png");
    RenderSceneAlone(scene, params, out);
  } else {
    throw core::InputError("render: " + run.string() + ": no such run folder (a scene by itself: --still)");
  }
  std::cout << out.string() << "\n";
  return 0;
}

}  // namespace atlas::experiments
