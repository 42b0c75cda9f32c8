#include "experiments/judge/mission_metrics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "core/errors.h"
#include "core/files.h"
#include "core/safe_text.h"
#include "experiments/identity/run_identity.h"
#include "experiments/identity/run_labels.h"
#include "experiments/identity/thesis_deviations.h"
#include "experiments/identity/version.h"
#include "experiments/judge/attainable.h"
#include "experiments/judge/scene_surface.h"
#include "experiments/results/map_slice.h"
#include "experiments/results/scored_files.h"

namespace atlas::experiments {
namespace {

constexpr double kPoseLogRateHz = 10.0;
constexpr double kSliceHeightM = 0.5;  ///< of map_slice.pgm above the spawn: below tables, above kerbs

RunSummary SummaryOf(const ExperimentConfig& config) {
  const RunIdentity identity = IdentityOf(config);
  RunSummary s;
  s.experiment = config.experiment;
  s.scene = std::filesystem::path(config.scene.name).stem().string();
  s.robot = std::filesystem::path(config.robot.name).stem().string();
  s.locomotion = config.sim.locomotion.name;
  s.terrain = TerrainLabel(config.sim.locomotion);
  s.localisation = LocalisationLabel(config.localisation);
  s.odometry = OdometryLabel(config.sim.odometry);
  s.mapper = config.mapper.name;
  s.planner = config.planner.name;
  s.gain = config.planner.own->gain();
  s.worth = config.planner.own->worth();
  s.deviations = fmt::format("{}", fmt::join(DeviationsFromThesis(config), "; "));
  s.version = Version();
  s.commit = identity.commit;
  s.config_hash = identity.config_hash;
  s.scene_hash = identity.settings.at("scene.name");
  s.robot_hash = identity.settings.at("robot.name");
  s.seed = static_cast<uint64_t>(config.seed);
  return s;
}

/// What was to be had of each part, where that is known, and what was had: coverage_by_part.csv.
std::string PartsCsv(const scenes::GroundTruth& truth, const std::vector<uint8_t>& attainable,
                     const std::vector<uint8_t>& covered, const std::vector<uint8_t>& outer) {
  std::vector<uint8_t> attained(attainable.size());
  std::transform(attainable.begin(), attainable.end(), outer.begin(), attained.begin(),
                 std::bit_and<uint8_t>());
  const std::vector<PartCoverage> got = CoverageByPart(truth, covered), front = CoverageByPart(truth, outer);
  std::vector<PartCoverage> reach, both;
  if (!attainable.empty()) {
    reach = CoverageByPart(truth, attainable);
    both = CoverageByPart(truth, attained);
  }
  std::string csv = "part,area_m2,attainable,coverage,coverage_outer,coverage_of_attainable\n";
  for (size_t k = 0; k < got.size(); ++k) {
    std::string reachable, share;
    if (!reach.empty()) {
      const PartCoverage of_attainable{.name = "", .points = reach[k].covered, .covered = both[k].covered};
      reachable = fmt::format("{:.4f}", reach[k].share());
      share = fmt::format("{:.4f}", of_attainable.share());
    }
    csv += fmt::format("{},{:.4f},{},{:.4f},{:.4f},{}\n", core::CsvCell(truth.part_names[k]),
                       truth.part_area_m2[k], reachable, got[k].share(), front[k].share(), share);
  }
  return csv;
}

}  // namespace

MissionMetrics::MissionMetrics(const ExperimentConfig& config, const RunOptions& options,
                               const scenes::SceneSpec& scene, const robots::RobotSpec& robot)
    : config_(config),
      options_(options),
      scene_(scene),
      recorder_(std::make_unique<RunRecorder>(options.folder, SummaryOf(config),
                                              RunColumns{StepColumns(), TimesColumns()})),
      ground_(config.planner.terrain.cell_m, robot.half_width_m, robot.footprint_radius_m) {
  core::WriteFileAtomically(options.folder / "config.yaml", core::DumpYaml(config.rows));
  options_.progress("sampling the ground truth", false);
  truth_ = scenes::SampleGroundTruth(scene, config.mission.truth_spacing_m);
  if (truth_.points.empty()) {
    throw core::InputError(
        fmt::format("{}: no surface in object_box, so nothing to cover", config.scene.name));
  }
  meter_ = std::make_unique<CoverageMeter>(
      truth_, CoverageMeter::Options{.radius_m = config.mission.coverage_radius_m});
  score_.covered.assign(truth_.points.size(), 0);
  score_.covered_outer = score_.covered;
  if (config.mission.attainable) FindAttainable(robot);
  const MetricSetup setup{config.mission.flat_coverage, config.mission.flat_scans};
  for (const MetricEntry& entry : MetricCatalog()) metrics_.push_back(entry.build(setup));
  Summarise(0.0, 0.0, 0.0);
  WriteScoredTruth(options.folder / "ground_truth.ply", truth_, attainable_);
}

void MissionMetrics::FindAttainable(const robots::RobotSpec& robot) {
  attainable_ = AttainableFor(config_, options_, scene_, robot, truth_);
  volume_ = ExploredVolumeFor(config_, options_, scene_, robot);
  const auto attained = static_cast<double>(std::count(attainable_.begin(), attainable_.end(), uint8_t{1}));
  attainable_share_ = attained / static_cast<double>(truth_.points.size());
}

void MissionMetrics::Attach(sim::Simulator* simulator) {
  simulator_ = simulator;
  recorder_->mutable_summary()->render_backend = simulator->render_backend();
  recorder_->mutable_summary()->render_problem = simulator->render_problem();
  if (!simulator->render_problem().empty()) Note("no depth camera: " + simulator->render_problem());
  simulator->AddStateObserver(
      [this](const sim::Snapshot& state) {
        recorder_->AddPose(state.time_s, simulator_->TrueBasePose(), simulator_->T_odom_base());
      },
      kPoseLogRateHz);
  wall_ = core::Stopwatch();
}

void MissionMetrics::BeginScan() {
  ++scans_begun_;
  const double walk_wall_s = scan_.times.walk_wall_s;
  scan_ = JudgedScan{};
  scan_.scan = scans_begun_;
  scan_.times.walk_wall_s = walk_wall_s;
}

void MissionMetrics::ObserveSweep(const core::Pose& T_map_base) {
  scan_.sim_time_s = simulator_->time_s();
  scan_.distance_m = distance_m_;
  scan_.T_map_base = T_map_base;
}

void MissionMetrics::ObserveMap(size_t cloud_points, double integration_ms, size_t new_surface) {
  scan_.cloud_points = cloud_points;
  scan_.new_surface_voxels = new_surface;
  scan_.times.integration_ms = integration_ms;
}

void MissionMetrics::SampleSurroundings() {
  if (std::exchange(has_surroundings_, true)) return;
  meter_->SetSurroundings(SampleBackground(scene_, scene_.object_box.Inflated(0.3), 0.02));
}

void MissionMetrics::ObservePlace(const core::Anchor& base, const core::Pose& T_map_base,
                                  std::shared_ptr<const core::PoseSource> poses) {
  places_.Observe({base, T_map_base, simulator_->T_odom_base(), simulator_->TrueBasePose()});
  poses_ = std::move(poses);
}

void MissionMetrics::TakeCloud(const mapping::ReturnCloud& cloud, core::KeyframeId keyframe,
                               const core::PoseSource& poses) {
  const core::Stopwatch measuring;
  meter_->Take(cloud, keyframe, poses);
  scored_.seconds += measuring.seconds();
}

void MissionMetrics::ScoreClouds(const mapping::Map& map, const core::PoseSource& poses) {
  const core::Stopwatch measuring;
  SampleSurroundings();
  meter_->Correct(poses);
  meter_->Align();
  scored_.coverage_raw = meter_->coverage_raw();
  scored_.coverage = meter_->coverage();
  scored_.covered = meter_->covered();
  scored_.covered_outer = meter_->covered_outer();
  scored_.coverage_outer = meter_->coverage_outer();
  if (attainable_share_) scored_.of_attainable = ShareOf(meter_->covered_outer(), attainable_);
  scored_.error = meter_->MeasureCloudError(scene_.object_box);
  scored_.returns = meter_->kept().points.size();
  scored_.T_truth_cloud = meter_->T_truth_cloud_counted();
  scored_.map_bytes = map.Bytes();
  scored_.submaps = map.SubmapCount();
  scored_.submap_members = map.Submaps();
  if (volume_) scored_.explored_m3 = volume_->ExploredM3(*map.Snapshot());
  scored_.seconds += measuring.seconds();
}

void MissionMetrics::AdoptScore() {
  score_ = std::move(scored_);
  scored_ = CloudScore{};
  scan_.times.map_bytes = score_.map_bytes;
  scan_.times.metrics_ms = 1e3 * score_.seconds;
}

void MissionMetrics::FinishScan(const planner::Decision& decision, const planner::DecisionLog& log) {
  ++scans_finished_;
  scan_.score = score_;
  scan_.decision = decision;
  scan_.log = log;
  blocked_ = log.blocked.value_or(std::vector<planner::BlockedWay>{});
  scan_.safety = simulator_->safety();
  scan_.times.wall_time_s = wall_.seconds();
  core::Row step, times;
  for (const auto& metric : metrics_) metric->OnScan(scan_, &step, &times);
  Summarise(scan_.sim_time_s, scan_.distance_m, scan_.times.wall_time_s);
  recorder_->AddDecision(scan_.scan, log, config_.planner.own->extra_gains());
  recorder_->AddStep(step, times);
  scan_.times.walk_wall_s = 0.0;
  Report("scanned", true);
}

void MissionMetrics::Summarise(double sim_time_s, double distance_m, double wall_time_s) {
  const JudgedRun run{.scans = scans_finished_,
                      .sim_time_s = sim_time_s,
                      .distance_m = distance_m,
                      .wall_time_s = wall_time_s,
                      .attainable = attainable_share_,
                      .attainable_m3 = volume_ ? std::optional(volume_->attainable_m3()) : std::nullopt,
                      .safety = simulator_ != nullptr ? simulator_->safety() : sim::SafetyCounts{},
                      .score = score_,
                      .trajectory = poses_ ? places_.Errors(*poses_) : std::nullopt,
                      .submaps = score_.submaps,
                      .odometry = odometry_,
                      .rooms = ScoreRooms(scene_, places_.places(), score_.submap_members),
                      .planned_m = planned_m_};
  core::Row measured;
  for (const auto& metric : metrics_) metric->Summarise(run, &measured);
  core::Row* numbers = &recorder_->mutable_summary()->numbers;
  for (const core::Column& column : SummaryColumns()) numbers->Set(column.name, measured.At(column.name));
}

void MissionMetrics::ObserveWalk(const sim::WalkResult& walk, double wall_s) {
  distance_m_ += walk.distance_m;
  scan_.times.walk_wall_s = wall_s;
}

void MissionMetrics::Save(const mapping::Map& map) {
  wall_time_s_ = wall_.seconds();
  RunSummary& summary = *recorder_->mutable_summary();
  Summarise(simulator_->time_s(), distance_m_, wall_time_s_);
  RecordBlockedWays(&summary);
  ground_.Write(options_.folder);
  // What came after the last score, on the way to a scan that never was, is not in the summary either.
  WriteScoredCloud(options_.folder / "cloud.ply", meter_->kept(), score_.returns);
  WriteAlignment(options_.folder / "alignment.txt", score_.T_truth_cloud);
  core::WriteFileAtomically(options_.folder / "coverage_by_part.csv",
                            PartsCsv(truth_, attainable_, score_.covered, score_.covered_outer));
  map.Save(options_.folder);
  core::WriteFileAtomically(options_.folder / kMapSeriesFile, series_.Csv());
  if (const auto view = map.Snapshot()) {
    const double height_m = scene_.T_map_spawn.translation().z() + kSliceHeightM;
    WriteMapSlice(options_.folder, *view, scene_.object_box, height_m);
  }
  core::WriteFileAtomically(options_.folder / "log.txt", log_);
}

void MissionMetrics::RecordBlockedWays(RunSummary* summary) {
  core::WriteFileAtomically(options_.folder / kBlockedWaysFile, BlockedWaysCsv(blocked_));
  const auto* done = std::get_if<planner::Done>(&scan_.decision);
  if (done == nullptr || done->reason != planner::Done::Reason::kBlockedNarrow) return;
  for (const planner::BlockedWay& way : blocked_) {
    if (!way.promises) continue;
    Note("blocked_narrow " + TextOf(way));
    summary->blocked_at += (summary->blocked_at.empty() ? "" : "; ") + TextOf(way);
  }
}

RunSummary MissionMetrics::Finish(RunStatus status, StopReason reason) {
  Summarise(simulator_->time_s(), distance_m_, wall_time_s_);
  return recorder_->Finish(status, reason);
}

void MissionMetrics::Note(const std::string& line) {
  log_ += line + "\n";
  options_.progress(line, true);
}

void MissionMetrics::Report(const std::string& stage, bool final) {
  const double time_s = simulator_->time_s();
  const std::string of_attainable =
      attainable_share_ ? fmt::format("  of attainable {:5.1f} %", 100.0 * score_.of_attainable.value_or(0.0))
                        : "";
  const std::string line =
      fmt::format("scan {:2d}  {:02d}:{:02d}  {:6.2f} m  coverage {:5.1f} %{}  {:.1f} x real time  {}",
                  scans_begun_, static_cast<int>(time_s) / 60, static_cast<int>(time_s) % 60, distance_m_,
                  100.0 * score_.coverage, of_attainable, time_s / std::max(1e-3, wall_.seconds()), stage);
  final ? Note(line) : options_.progress(line, false);
}

}  // namespace atlas::experiments
