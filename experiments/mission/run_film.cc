#include "experiments/mission/run_film.h"

#include <fmt/format.h>

#include "experiments/results/run_folder.h"
#include "experiments/video/run_video.h"
#include "experiments/video/video_writer.h"
#include "robots/robot_spec.h"
#include "scenes/catalog.h"

namespace atlas::experiments {
namespace {

constexpr double kStateRateHz = 25.0;  ///< a state a frame even at real-time speed

struct Stopped {};

}  // namespace

RunFilm::RunFilm(const ExperimentConfig& config, const RunOptions& options)
    : config_(config),
      options_(options),
      recording_(NameInFolder(config.scene.name, options.folder),
                 NameInFolder(config.robot.name, options.folder), config.mapper.resolution_m) {
  if (config.output.video) RequireVideoTools();
}

void RunFilm::Attach(sim::Simulator* simulator) {
  simulator_ = simulator;
  simulator->AddStateObserver([this](const sim::Snapshot& state) { recording_.AddState(state); },
                              kStateRateHz);
}

void RunFilm::ObserveMap(const std::vector<core::Vec3f>& occupied_map) {
  recording_.AddMap(simulator_->time_s(), occupied_map);
}

void RunFilm::ObservePlan(const planner::Decision& decision) {
  std::optional<ChosenView> view;
  std::vector<core::Vec2> path_map;
  if (const auto* go = std::get_if<planner::GoScan>(&decision)) {
    view = ChosenView{go->p_map, go->yaw_rad};
    path_map = go->path_map;
  }
  recording_.AddPlan(simulator_->time_s(), path_map, view);
  Save();
}

void RunFilm::Save() const {
  recording_.Save(options_.folder / kRecordingFile);
}

bool RunFilm::Finish(bool with_video) {
  Save();
  if (!config_.output.video || !with_video) return true;
  const RunRecording recording = LoadRecording(options_.folder / kRecordingFile);
  if (recording.states.empty()) return true;
  VideoParams params;
  params.speed = config_.output.video_speed;
  try {
    WriteRunVideo(scenes::LoadScene(recording.scene), robots::LoadRobot(recording.robot), recording, params,
                  options_.folder / "video.mp4", [this](double share) {
                    if (options_.should_stop()) throw Stopped();
                    options_.progress(fmt::format("video {:3.0f} %", 100.0 * share), false);
                  });
  } catch (const Stopped&) {
    return false;
  }
  return true;
}

}  // namespace atlas::experiments
