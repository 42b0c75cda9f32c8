// Films a run: a recording of what the robot did, knew and wanted, and the video where one is asked for.
#pragma once

#include "experiments/identity/experiment_config.h"
#include "experiments/identity/run_options.h"
#include "experiments/video/run_recording.h"
#include "planner/decision.h"

namespace atlas::experiments {

/// Keeps `recording.bin` in the run folder (what `atlas render` takes), renewed after every plan.
class RunFilm {
 public:
  /// @throws InputError where `output.video` is set and no video can be made on this machine.
  RunFilm(const ExperimentConfig& config, const RunOptions& options);
  /// Follows the true state of `simulator`, which outlives the film.
  void Attach(sim::Simulator* simulator);

  void ObserveMap(const std::vector<core::Vec3f>& occupied_map);
  void ObservePlan(const planner::Decision& decision);
  /// Saves the recording and, where asked for and `with_video`, renders video.mp4. False when stopped
  /// meanwhile, without a video. @throws InputError when that fails.
  bool Finish(bool with_video);

 private:
  void Save() const;

  const ExperimentConfig& config_;
  const RunOptions& options_;
  RecordingWriter recording_;
  sim::Simulator* simulator_ = nullptr;
};

}  // namespace atlas::experiments
