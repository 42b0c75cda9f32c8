#include "sim/simulator.h"

#include "sim/locomotion/locomotion.h"
#include "sim/locomotion/path_tracker.h"
#include "sim/locomotion/roll_profile.h"
#include "sim/walking/odometry.h"
#include "sim/walking/sensor_suite.h"

namespace atlas::sim {
namespace {

constexpr double kControlPeriodS = 0.02;
constexpr double kStandTimeoutS = 4.0;
constexpr double kRollReturnRate = 0.8;  ///< rad/s, after a sweep that was stopped
constexpr double kDistanceSpacingM = 0.02;
constexpr double kTickEps = 1e-6;

/// Length of a way on the ground, in steps long enough that swaying does not add to it.
class Odometer {
 public:
  Odometer() = default;
  explicit Odometer(const core::Pose& start) : last_(start.translation().head<2>()) {}

  void Observe(const core::Pose& pose) {
    const core::Vec2 p = pose.translation().head<2>();
    const double step_m = (p - last_).norm();
    if (step_m < kDistanceSpacingM) return;
    distance_m_ += step_m;
    last_ = p;
  }
  double distance_m() const { return distance_m_; }

 private:
  core::Vec2 last_ = core::Vec2::Zero();
  double distance_m_ = 0.0;
};

class WalkingSimulator : public Simulator {
 public:
  WalkingSimulator(const scenes::SceneSpec& scene, const robots::RobotSpec& robot, const SimParams& params,
                   const core::Rng& rng)
      : params_(params),
        locomotion_(MakeLocomotion(scene, robot, params, rng.Split("locomotion"))),
        odometry_(params.odometry, scene.T_map_spawn, locomotion_->T_map_base(), rng.Split("odometry")),
        T_map_odom_(scene.T_map_spawn),
        sensors_(scene, robot, params.sensors, *locomotion_, rng.Split("sensors")) {}

  void SetSink(core::SensorSink* sink) override { sink_ = sink; }
  void SetLocalisation(const core::Pose& T_map_odom) override { T_map_odom_ = T_map_odom; }
  void SetStop(std::function<bool()> should_stop) override { should_stop_ = std::move(should_stop); }

  MotionStatus Stand(double duration_s) override;
  WalkResult Walk(const WalkPath& path, const core::TerrainView* terrain) override;
  MotionStatus RollSweep() override;

  double time_s() const override { return locomotion_->time_s(); }
  core::Pose T_odom_base() const override { return odometry_.T_odom_base(); }
  const SafetyCounts& safety() const override { return locomotion_->safety(); }
  std::string render_backend() const override { return sensors_.render_backend(); }
  std::string render_problem() const override { return sensors_.render_problem(); }
  core::Pose TrueBasePose() const override { return locomotion_->T_map_base(); }
  Snapshot TrueState() const override { return {time_s(), locomotion_->world().qpos()}; }
  void AddStateObserver(std::function<void(const Snapshot&)> observer, double rate_hz) override {
    observers_.push_back({std::move(observer), 1.0 / rate_hz, time_s()});
  }

 private:
  /// What a motion says at each control tick: nothing to go on, or how it ended.
  using Tick = std::function<std::optional<MotionStatus>(double now_s)>;

  core::Pose BelievedBase() const { return T_map_odom_ * odometry_.T_odom_base(); }
  MotionStatus Run(const Tick& tick);
  Tick Follow(const WalkPath& path);
  Tick BeCarried(const WalkPath& path);
  MotionStatus ComeToStand();
  void Step();
  void Measure(double now_s);
  void ReturnRoll();

  SimParams params_;
  std::unique_ptr<Locomotion> locomotion_;
  Odometry odometry_;
  core::Pose T_map_odom_;  ///< as it was told
  SensorSuite sensors_;
  core::SensorSink* sink_ = nullptr;
  std::function<bool()> should_stop_;
  struct StateObserver {
    std::function<void(const Snapshot&)> hear;
    double period_s, next_s;
  };
  std::vector<StateObserver> observers_;

  BodyRoll roll_;
  std::optional<RollProfile> profile_;  ///< while sweeping
  double sweep_start_s_ = 0.0;
  Odometer walked_, walked_by_odometry_;
};

void WalkingSimulator::ReturnRoll() {
  const double limit = kRollReturnRate * locomotion_->step_s();
  const double before = roll_.roll_rad;
  roll_.roll_rad -= std::clamp(before, -limit, limit);
  roll_.rate_radps = (roll_.roll_rad - before) / locomotion_->step_s();
  roll_.level -= std::min(roll_.level, locomotion_->step_s());
}

void WalkingSimulator::Measure(double now_s) {
  const core::Pose T_map_base = locomotion_->T_map_base();
  odometry_.Update(T_map_base);
  sensors_.Observe(*locomotion_, odometry_, sink_);
  walked_.Observe(T_map_base);
  walked_by_odometry_.Observe(odometry_.T_odom_base());
  for (StateObserver& observer : observers_) {
    if (now_s < observer.next_s - kTickEps) continue;
    observer.next_s += observer.period_s;
    observer.hear(TrueState());
  }
}

void WalkingSimulator::Step() {
  locomotion_->BeginStep();
  const double now = time_s();
  Measure(now);
  if (profile_) {
    roll_ = profile_->At(now - sweep_start_s_);
  } else {
    ReturnRoll();
  }
  locomotion_->SetRoll(roll_);
  locomotion_->FinishStep();
}

MotionStatus WalkingSimulator::Run(const Tick& tick) {
  double next_tick_s = time_s();
  while (true) {
    if (time_s() >= next_tick_s - kTickEps) {
      next_tick_s += kControlPeriodS;
      if (locomotion_->fallen()) return MotionStatus::kFell;
      if (should_stop_ && should_stop_()) return MotionStatus::kStopped;
      locomotion_->SetOdometry(odometry_.T_odom_base());
      if (const std::optional<MotionStatus> end = tick(time_s())) return *end;
    }
    Step();
  }
}

MotionStatus WalkingSimulator::ComeToStand() {
  locomotion_->SetCommand({});
  const double start = time_s();
  return Run([&](double now) -> std::optional<MotionStatus> {
    if (locomotion_->standing() || now - start > kStandTimeoutS) return MotionStatus::kReached;
    return std::nullopt;
  });
}

MotionStatus WalkingSimulator::Stand(double duration_s) {
  sensors_.SetActivity(Activity::kStanding);
  locomotion_->SetCommand({});
  const double end = time_s() + duration_s;
  return Run([&](double now) -> std::optional<MotionStatus> {
    if (now >= end - kTickEps) return MotionStatus::kReached;
    return std::nullopt;
  });
}

WalkingSimulator::Tick WalkingSimulator::Follow(const WalkPath& path) {
  auto tracker =
      std::make_shared<PathTracker>(path.waypoints_map, path.final_yaw_rad, params_.locomotion.speed_mps);
  return [this, tracker](double now) -> std::optional<MotionStatus> {
    const core::Pose T_map_base =
        params_.locomotion.name == "rail" ? locomotion_->T_map_base() : BelievedBase();
    const PathTracker::Output out =
        tracker->Update(now, T_map_base.translation().head<2>(), core::YawOf(T_map_base.linear()));
    locomotion_->SetCommand(out.command);
    if (out.status == PathTracker::Status::kArrived) return MotionStatus::kReached;
    if (out.status == PathTracker::Status::kStuck) return MotionStatus::kStuck;
    return std::nullopt;
  };
}

/// Whatever lies between, the route leads to the path's end.
WalkingSimulator::Tick WalkingSimulator::BeCarried(const WalkPath& path) {
  const bool passes = !path.waypoints_map.empty() && locomotion_->CarryTo(path.waypoints_map.back());
  return [this, passes](double) -> std::optional<MotionStatus> {
    if (!passes) return MotionStatus::kStuck;
    if (locomotion_->standing()) return MotionStatus::kReached;
    return std::nullopt;
  };
}

WalkResult WalkingSimulator::Walk(const WalkPath& path, const core::TerrainView* terrain) {
  const bool truth = terrain == nullptr || params_.locomotion.terrain == "truth";
  locomotion_->SetTerrain(truth ? GroundSource::kTruth : GroundSource::kPerceived, terrain);
  sensors_.SetActivity(Activity::kWalking);
  const double start = time_s();
  walked_ = Odometer(locomotion_->T_map_base());
  walked_by_odometry_ = Odometer(odometry_.T_odom_base());

  WalkResult result;
  result.status = Run(locomotion_->carried() ? BeCarried(path) : Follow(path));
  locomotion_->SetCommand({});
  if (result.status == MotionStatus::kReached || result.status == MotionStatus::kStuck) {
    const MotionStatus stand = ComeToStand();
    if (stand != MotionStatus::kReached) result.status = stand;
  }
  locomotion_->SetTerrain(GroundSource::kPlane, nullptr);  // `terrain` may not outlive this call
  sensors_.SetActivity(Activity::kStanding);
  result.distance_m = walked_.distance_m();
  result.odometry_distance_m = walked_by_odometry_.distance_m();
  result.duration_s = time_s() - start;
  return result;
}

MotionStatus WalkingSimulator::RollSweep() {
  sensors_.SetActivity(Activity::kStanding);
  if (const MotionStatus stand = ComeToStand(); stand != MotionStatus::kReached) return stand;
  sensors_.SetActivity(Activity::kSweeping);  // from the next revolution on
  while (!sensors_.AtSpinStart(time_s())) Step();

  sweep_start_s_ = time_s();
  profile_.emplace(core::Radians(params_.locomotion.sweep_roll_deg), params_.locomotion.sweep_period_s);
  // What is carried does not roll: a revolution where it stands.
  const double sweep_s = locomotion_->carried() ? sensors_.revolution_s() : profile_->period_s();
  const MotionStatus status = Run([&](double now) -> std::optional<MotionStatus> {
    if (now - sweep_start_s_ >= sweep_s - kTickEps) return MotionStatus::kReached;
    return std::nullopt;
  });
  if (status == MotionStatus::kReached) {
    while (!sensors_.AtSpinStart(time_s())) Step();
    sensors_.SetActivity(Activity::kStanding);
    Step();  // the observation that ends the last revolution
  }
  profile_.reset();
  sensors_.SetActivity(Activity::kStanding);
  return status;
}

}  // namespace

std::unique_ptr<Simulator> MakeSimulator(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                         const SimParams& params, const core::Rng& rng) {
  return std::make_unique<WalkingSimulator>(scene, robot, params, rng);
}

}  // namespace atlas::sim
