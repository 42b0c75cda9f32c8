// What a mission is judged by. Of the loop this part sees the ground truth, besides it only the film and the
// localiser `truth`.
//
// The costly part (TakeCloud, ScoreClouds) touches only the meter and its own results, so
// that it may run beside the rest, one call at a time; AdoptScore and Finish read them once it is over.
#pragma once

#include <memory>

#include "core/stopwatch.h"
#include "experiments/identity/experiment_config.h"
#include "experiments/identity/run_options.h"
#include "experiments/judge/coverage.h"
#include "experiments/judge/explored_volume.h"
#include "experiments/judge/metric.h"
#include "experiments/results/ground_plan.h"
#include "experiments/results/map_series.h"
#include "experiments/results/run_recorder.h"
#include "mapping/map.h"
#include "scenes/catalog.h"
#include "sim/simulator.h"

namespace atlas::experiments {

class MissionMetrics {
 public:
  /// Samples the ground truth, finds what is attainable of it (cached between runs; where that is asked for)
  /// and opens the run folder.
  /// @throws InputError when the folder cannot be written.
  MissionMetrics(const ExperimentConfig& config, const RunOptions& options, const scenes::SceneSpec& scene,
                 const robots::RobotSpec& robot);
  /// Follows the true pose of `simulator`, which outlives the mission.
  void Attach(sim::Simulator* simulator);

  void BeginScan();
  void ObserveSweep(const core::Pose& T_map_base);
  void ObserveMap(size_t cloud_points, double integration_ms, size_t new_surface);

  /// A cloud in the map frame, which moves with its keyframe from now on.
  void TakeCloud(const mapping::ReturnCloud& cloud, core::KeyframeId keyframe, const core::PoseSource& poses);
  /// Scores all clouds so far, where their keyframes are now.
  void ScoreClouds(const mapping::Map& map, const core::PoseSource& poses);
  /// The scan's row takes the score.
  void AdoptScore();

  /// Where the localiser placed a revolution, with the truth of the moment.
  void ObservePlace(const core::Anchor& base, const core::Pose& T_map_base,
                    std::shared_ptr<const core::PoseSource> poses);
  void ObserveOdometry(const std::optional<mapping::OdometryHealth>& odometry) { odometry_ = odometry; }

  /// After each revolution that the map has taken.
  void ObserveMapped(const mapping::Map& map, core::KeyframeId keyframe) { series_.Observe(map, keyframe); }
  /// What mission.plan_after found; nothing where there is no way.
  void ObservePlannedWay(std::optional<double> length_m) { planned_m_ = length_m; }
  /// Where keyframes truly were when they began.
  const PlaceErrors& places() const { return places_; }

  void FinishScan(const planner::Decision& decision, const planner::DecisionLog& log);
  void ObserveWalk(const sim::WalkResult& walk, double wall_s);
  /// Ground that planning knows by now, and why it left some of it out.
  void ObserveGround(const mapping::TraversableGround& ground_map) { ground_.Learn(ground_map); }
  /// Writes the cloud, the map, log.txt and what else the folder holds, with numbers as of now; the status
  /// still says `interrupted`. @throws InputError when a file cannot be written.
  void Save(const mapping::Map& map);
  /// The last write of a run: its final status. @pre Save() has returned
  RunSummary Finish(RunStatus status, StopReason reason);

  /// A progress line: scan, simulated time, distance, coverage, what is going on.
  void Report(const std::string& stage, bool final = false);

  /// The one under way counts.
  int scans_begun() const { return scans_begun_; }
  ScanTimes& timing() { return scan_.times; }

  /// A line that stays, on the terminal and in log.txt.
  void Note(const std::string& line);

 private:
  void FindAttainable(const robots::RobotSpec& robot);
  /// Samples what stands around the object, once: the cloud's error leaves it out.
  void SampleSurroundings();
  /// All numbers as of now.
  void Summarise(double sim_time_s, double distance_m, double wall_time_s);
  void RecordBlockedWays(RunSummary* summary);

  const ExperimentConfig& config_;
  const RunOptions& options_;
  const scenes::SceneSpec& scene_;
  core::Stopwatch wall_;
  scenes::GroundTruth truth_;
  std::vector<uint8_t> attainable_;  ///< a truth point each; empty: not asked for
  std::unique_ptr<CoverageMeter> meter_;
  bool has_surroundings_ = false;
  std::unique_ptr<ExploredVolume> volume_;  ///< of scenes to explore
  CloudScore scored_, score_;               ///< the meter's latest answers, as computed, as adopted
  std::vector<std::unique_ptr<Metric>> metrics_;
  std::unique_ptr<RunRecorder> recorder_;
  sim::Simulator* simulator_ = nullptr;
  std::string log_;           ///< lines that stay
  double wall_time_s_ = 0.0;  ///< of the mission, without what Save does
  GroundPlan ground_;
  PlaceErrors places_;
  MapSeries series_;
  std::optional<double> planned_m_;
  std::shared_ptr<const core::PoseSource> poses_;  ///< the latest
  std::optional<mapping::OdometryHealth> odometry_;
  int scans_begun_ = 0, scans_finished_ = 0;
  double distance_m_ = 0.0;
  std::optional<double> attainable_share_;
  JudgedScan scan_;
  std::vector<planner::BlockedWay> blocked_;  ///< as of the latest plan
};

}  // namespace atlas::experiments
