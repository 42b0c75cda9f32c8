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
#include "experiments/results/scored_files.h"

namespace atlas::experiments {
namespace {

constexpr double kPoseLogRateHz = 10.0;

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
  s.gain = config.planner.name == "route" ? "none" : config.planner.gain;
  s.worth = WorthLabel(config.planner);
  s.deviations = fmt::format("{}", fmt::join(DeviationsFromThesis(config), "; "));
  s.version = Version();
  s.commit = identity.commit;
  s.config_hash = identity.config_hash;
  s.scene_hash = identity.settings.at("scene.name");
  s.robot_hash = identity.settings.at("robot.name");
  s.seed = static_cast<uint64_t>(config.seed);
  return s;
}

/// What was to be had of each part, and what was had: coverage_by_part.csv.
std::string PartsCsv(const scenes::GroundTruth& truth, const std::vector<uint8_t>& attainable,
                     const std::vector<uint8_t>& covered, const std::vector<uint8_t>& outer) {
  std::vector<uint8_t> attained(outer.size());
  std::transform(outer.begin(), outer.end(), attainable.begin(), attained.begin(), std::bit_and<uint8_t>());
  const std::vector<PartCoverage> reach = CoverageByPart(truth, attainable),
                                  got = CoverageByPart(truth, covered), front = CoverageByPart(truth, outer),
                                  both = CoverageByPart(truth, attained);
  std::string csv = "part,area_m2,attainable,coverage,coverage_outer,coverage_of_attainable\n";
  for (size_t k = 0; k < reach.size(); ++k) {
    const PartCoverage of_attainable{.name = "", .points = reach[k].covered, .covered = both[k].covered};
    csv += fmt::format("{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f}\n", core::CsvCell(truth.part_names[k]),
                       truth.part_area_m2[k], reach[k].share(), got[k].share(), front[k].share(),
                       of_attainable.share());
  }
  return csv;
}

}  // namespace

MissionMetrics::MissionMetrics(const ExperimentConfig& config, const RunOptions& options,
                               const scenes::SceneSpec& scene, const robots::RobotSpec& robot)
    : config_(config),
      options_(options),
      scene_(scene),
      recorder_(std::make_unique<RunRecorder>(options.folder, SummaryOf(config))),
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
  attainable_ = AttainableFor(config, options, scene, robot, truth_);
  score_.covered.assign(truth_.points.size(), 0);
  score_.covered_outer = score_.covered;
  volume_ = ExploredVolumeFor(config, options, scene, robot);
  const auto attained = static_cast<double>(std::count(attainable_.begin(), attainable_.end(), uint8_t{1}));
  recorder_->mutable_summary()->coverage_attainable = attained / static_cast<double>(truth_.points.size());
  WriteScoredTruth(options.folder / "ground_truth.ply", truth_, attainable_);
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
  ++scans_;
  step_ = StepRow{};
  timing_ = TimingRow{.walk_wall_s = timing_.walk_wall_s};
  step_.scan = timing_.scan = scans_;
}

void MissionMetrics::ObserveSweep(const core::Pose& T_map_base) {
  step_.sim_time_s = simulator_->time_s();
  step_.distance_m = distance_m_;
  step_.T_map_base = T_map_base;
}

void MissionMetrics::ObserveMap(size_t cloud_points, double integration_ms, size_t new_surface) {
  step_.cloud_points = cloud_points;
  step_.new_surface_voxels = new_surface;
  timing_.integration_ms = integration_ms;
}

void MissionMetrics::SampleSurroundings() {
  if (std::exchange(has_surroundings_, true)) return;
  meter_->SetSurroundings(SampleBackground(scene_, scene_.object_box.Inflated(0.3), 0.02));
}

void MissionMetrics::TakeCloud(const mapping::ReturnCloud& cloud) {
  const core::Stopwatch measuring;
  meter_->Take(cloud);
  scored_.seconds += measuring.seconds();
}

void MissionMetrics::ScoreClouds(const mapping::Map& map) {
  const core::Stopwatch measuring;
  SampleSurroundings();
  meter_->Align();
  scored_.coverage_raw = meter_->coverage_raw();
  scored_.coverage = meter_->coverage();
  scored_.covered = meter_->covered();
  scored_.covered_outer = meter_->covered_outer();
  scored_.coverage_outer = meter_->coverage_outer();
  scored_.of_attainable = ShareOf(meter_->covered_outer(), attainable_);
  scored_.error = meter_->MeasureCloudError(scene_.object_box);
  scored_.returns = meter_->kept().points.size();
  scored_.T_truth_cloud = meter_->T_truth_cloud_counted();
  scored_.map_bytes = map.Bytes();
  if (volume_) scored_.explored_m3 = volume_->ExploredM3(*map.Snapshot());
  scored_.seconds += measuring.seconds();
}

void MissionMetrics::AdoptScore() {
  score_ = std::move(scored_);
  scored_ = Score{};
  coverage_.push_back(score_.coverage);
  step_.coverage_raw = score_.coverage_raw;
  step_.coverage = score_.coverage;
  step_.coverage_outer = score_.coverage_outer;
  step_.coverage_of_attainable = score_.of_attainable;
  if (score_.error.points > 0) {
    step_.cloud_error_m_mean = score_.error.mean_m;
    step_.cloud_error_m_p95 = score_.error.p95_m;
  }
  step_.flat_by_truth = CoverageIsFlat();
  step_.explored_m3 = score_.explored_m3;
  timing_.map_bytes = score_.map_bytes;
  timing_.metrics_ms = 1e3 * score_.seconds;
}

void MissionMetrics::FinishScan(const planner::NbvDecision& decision) {
  step_.outcome = NameOf(decision.outcome);
  step_.candidates = static_cast<int>(decision.candidates.size());
  step_.nodes = decision.nodes_obtained;
  step_.rays = decision.rays_traced;
  step_.utility_ratio = decision.utility_ratio;
  step_.path_length_m = decision.path_length_m;
  if (decision.best >= 0) {
    const planner::Candidate& best = decision.candidates[static_cast<size_t>(decision.best)];
    step_.gain = best.gain;
    step_.utility = best.utility;
  }
  const sim::SafetyCounts& safety = simulator_->safety();
  if (safety.measured) {
    step_.falls = safety.falls;
    step_.collisions = safety.collisions;
    step_.shank_brushes = safety.shank_brushes;
    step_.footholds = safety.footholds;
    step_.footholds_off_solid = safety.footholds_off_solid;
    step_.worst_foot_drop_m = safety.worst_foot_drop_m;
  }
  timing_.wall_time_s = wall_.seconds();
  blocked_ = decision.blocked;
  recorder_->AddDecision(scans_, decision, config_.planner.extra_gains);
  recorder_->AddStep(step_, timing_);
  timing_.walk_wall_s = 0.0;
  Report("scanned", true);
}

void MissionMetrics::ObserveWalk(const sim::WalkResult& walk, double wall_s) {
  distance_m_ += walk.distance_m;
  timing_.walk_wall_s = wall_s;
}

void MissionMetrics::Save(const mapping::Map& map) {
  wall_time_s_ = wall_.seconds();
  RunSummary& summary = *recorder_->mutable_summary();
  if (score_.error.points > 0) {
    summary.cloud_error_m_mean = score_.error.mean_m;
    summary.cloud_error_m_p95 = score_.error.p95_m;
  }
  if (const sim::SafetyCounts& safety = simulator_->safety(); safety.measured) {
    summary.falls = safety.falls;
    summary.collisions = safety.collisions;
    summary.footholds_off_solid = safety.footholds_off_solid;
    summary.worst_foot_drop_m = safety.worst_foot_drop_m;
  }
  if (volume_ && score_.explored_m3) {
    summary.explored_volume_m3 = score_.explored_m3;
    summary.explored_volume_attainable_m3 = volume_->attainable_m3();
    summary.explored_of_attainable = *score_.explored_m3 / std::max(1e-9, volume_->attainable_m3());
  }
  RecordBlockedWays(&summary);
  ground_.Write(options_.folder);
  // What came after the last score, on the way to a scan that never was, is not in the summary either.
  WriteScoredCloud(options_.folder / "cloud.ply", meter_->kept(), score_.returns);
  WriteAlignment(options_.folder / "alignment.txt", score_.T_truth_cloud);
  core::WriteFileAtomically(options_.folder / "coverage_by_part.csv",
                            PartsCsv(truth_, attainable_, score_.covered, score_.covered_outer));
  map.Save(options_.folder);
  core::WriteFileAtomically(options_.folder / "log.txt", log_);
}

void MissionMetrics::RecordBlockedWays(RunSummary* summary) {
  core::WriteFileAtomically(options_.folder / kBlockedWaysFile, BlockedWaysCsv(blocked_));
  summary->blocked_ways = static_cast<double>(blocked_.size());
  if (step_.outcome != NameOf(planner::NbvOutcome::kBlockedNarrow)) return;
  for (const planner::BlockedWay& way : blocked_) {
    if (way.worth_share.value_or(0.0) < config_.planner.blocked_share) continue;
    Note("blocked_narrow " + TextOf(way));
    summary->blocked_at += (summary->blocked_at.empty() ? "" : "; ") + TextOf(way);
  }
}

RunSummary MissionMetrics::Finish(RunStatus status, StopReason reason) {
  return recorder_->Finish(status, reason, simulator_->time_s(), distance_m_, wall_time_s_);
}

void MissionMetrics::Note(const std::string& line) {
  log_ += line + "\n";
  options_.progress(line, true);
}

void MissionMetrics::Report(const std::string& stage, bool final) {
  const double time_s = simulator_->time_s();
  const std::string line = fmt::format(
      "scan {:2d}  {:02d}:{:02d}  {:6.2f} m  coverage {:5.1f} %  of attainable {:5.1f} %  {:.1f} "
      "x real time  {}",
      scans_, static_cast<int>(time_s) / 60, static_cast<int>(time_s) % 60, distance_m_,
      100.0 * score_.coverage, 100.0 * score_.of_attainable, time_s / std::max(1e-3, wall_.seconds()), stage);
  final ? Note(line) : options_.progress(line, false);
}

bool MissionMetrics::CoverageIsFlat() const {
  const auto rounds = static_cast<size_t>(config_.mission.flat_scans);
  if (coverage_.size() <= rounds) return false;
  const double added = coverage_.back() - coverage_[coverage_.size() - 1 - rounds];
  return added < static_cast<double>(rounds) * config_.mission.flat_coverage;
}

}  // namespace atlas::experiments
