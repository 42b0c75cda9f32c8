#include "experiments/mission/closed_loop.h"

#include <optional>
#include <variant>

#include "core/files.h"
#include "core/stopwatch.h"
#include "experiments/mission/ending.h"
#include "experiments/mission/map_pictures.h"
#include "experiments/mission/mission.h"
#include "experiments/mission/run_localiser.h"
#include "experiments/results/run_folder.h"

namespace atlas::experiments {
namespace {

using core::Pose;

/// Sweeps while the map takes the walk that led here and what the sweep sees; the robot stands until both are
/// integrated, and the planner learns how much surface was new.
std::optional<Ending> SweepAndIntegrate(Mission* m) {
  m->feed.SetMapping(SensorFeed::Mapping::kScanning);
  const core::Stopwatch sweeping;
  const sim::MotionStatus status = m->simulator->RollSweep();
  m->feed.SetMapping(SensorFeed::Mapping::kNothing);
  if (const auto ending = EndingOf(status)) return ending;
  m->metrics.timing().sweep_wall_s = sweeping.seconds();
  m->metrics.ObserveSweep(m->T_map_base());
  m->feed.RefreshTerrain();
  const Pose T_map_base = m->T_map_base();
  const sim::MotionStatus stood = m->simulator->Stand(m->config.mission.integration_latency_s);

  const SensorFeed::Mapped mapped = m->feed.DrainMap();
  const auto poses = m->localiser->poses();
  m->map->Correct(*poses);
  m->film.ObserveMap(mapping::OccupiedCenters(*m->map->Snapshot(), m->region));
  const core::Stopwatch updating;
  m->feed.AdoptTerrain();
  m->metrics.timing().terrain_ms = 1e3 * updating.seconds();
  const size_t new_surface = m->surface.CountNew(m->returns_map, m->Ground());
  m->returns_map.clear();
  m->planner->OnScan({T_map_base, new_surface}, *poses);
  m->metrics.ObserveMap(mapped.cloud_points, 1e3 * mapped.integration_s, new_surface);
  m->lanes.Post(kMapLane, [m, poses] { m->metrics.ScoreClouds(*m->map, *poses); });
  return EndingOf(stood);
}

/// After this scan.
planner::Budget BudgetLeft(const Mission& m) {
  const MissionParams& most = m.config.mission;
  return {.scans = most.max_scans - m.metrics.scans_begun(),
          .time_s = most.max_time_s - m.simulator->time_s(),
          .distance_m = most.max_distance_m - m.odometry_distance_m};
}

/// Plans while the metrics are scored.
planner::Decision PlanNextView(Mission* m, planner::DecisionLog* log) {
  const core::Stopwatch planning;
  const mapping::PosedGround ground = m->Ground();
  const auto map = m->map->Snapshot();
  const auto poses = m->localiser->poses();
  const planner::Belief belief{*map, ground, *poses, m->T_map_base(), BudgetLeft(*m)};
  const planner::Decision decision = m->planner->Plan(belief, log);
  m->metrics.timing().nbv_time_s = planning.seconds();
  m->metrics.ObserveGround(ground);
  m->lanes.Drain(kMapLane);
  m->metrics.AdoptScore();
  return decision;
}

/// Own criterion or a budget; nothing if the mission goes on.
std::optional<Ending> StopAfterPlanning(const Mission& m, const planner::Decision& decision) {
  if (const auto ending = EndingOf(decision)) return ending;
  const planner::Budget left = BudgetLeft(m);
  if (left.scans <= 0) return Ending{RunStatus::kBudget, StopReason::kScanBudget};
  if (left.time_s <= 0.0) return Ending{RunStatus::kBudget, StopReason::kTimeBudget};
  if (left.distance_m <= 0.0) return Ending{RunStatus::kBudget, StopReason::kDistanceBudget};
  return std::nullopt;
}

std::optional<Ending> WalkTo(Mission* m, const planner::GoScan& go, FailedWalks* failed_walks) {
  using Mapping = SensorFeed::Mapping;
  m->feed.SetMapping(m->config.mission.map_while_walking ? Mapping::kEverything : Mapping::kNothing);
  const core::Stopwatch walking;
  const sim::WalkResult walk = m->simulator->Walk({go.path_map, go.yaw_rad}, &m->terrain);
  m->feed.SetMapping(Mapping::kNothing);
  m->metrics.ObserveWalk(walk, walking.seconds());
  m->odometry_distance_m += walk.odometry_distance_m;
  if (const auto ending = EndingOf(walk.status)) return ending;
  return failed_walks->Observe(walk.status);
}

Ending RunMission(Mission* m) {
  FailedWalks failed_walks;
  while (true) {
    m->metrics.BeginScan();
    m->metrics.Report("sweeping");
    if (const auto ending = SweepAndIntegrate(m)) return *ending;
    m->metrics.Report("planning");
    planner::DecisionLog log;
    const planner::Decision decision = PlanNextView(m, &log);
    const auto ending = StopAfterPlanning(*m, decision);
    m->metrics.FinishScan(decision, log);
    m->film.ObservePlan(decision);
    if (ending) return *ending;
    if (const auto stopped = EndingOf(m->simulator->Stand(m->config.mission.planning_latency_s)))
      return *stopped;
    m->metrics.Report("walking");
    if (const auto stopped = WalkTo(m, std::get<planner::GoScan>(decision), &failed_walks)) return *stopped;
  }
}

void SaveWhatCanBe(Mission* m) {
  try {
    m->metrics.Save(*m->map);
  } catch (const std::exception&) {
    // Of two errors the first is told.
  }
}

}  // namespace

RunSummary RunClosedLoop(const ExperimentConfig& given, const RunOptions& options) {
  core::RemoveStaleTemporaries(core::CacheDirectory());
  const ExperimentConfig config = KeepInputs(given, options.folder);  // what is run is what is kept
  Mission mission(config, options);
  options.prepared();
  Ending ending{RunStatus::kFailed, StopReason::kError};
  try {
    ending = RunMission(&mission);
    mission.lanes.Drain(kTerrainLane);
    mission.lanes.Drain(kMapLane);
  } catch (...) {
    mission.lanes.Abandon();
    SaveWhatCanBe(&mission);
    throw;  // past the recorder, which says that the run failed
  }
  FinishWithPictures(&mission);
  mission.metrics.Save(*mission.map);
  SaveSession(options.folder, mission.localiser.get());
  const bool interrupted = ending.status == RunStatus::kInterrupted;
  if (!mission.film.Finish(!interrupted)) ending = {RunStatus::kInterrupted, StopReason::kSignal};
  return mission.metrics.Finish(ending.status, ending.reason);
}

}  // namespace atlas::experiments
