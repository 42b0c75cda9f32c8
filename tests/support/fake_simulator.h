// A simulator that says what a test wants it to, and moves nothing.
#pragma once

#include "sim/simulator.h"

namespace atlas::tests {

class FakeSimulator : public sim::Simulator {
 public:
  void SetSink(core::SensorSink*) override {}
  void SetStop(std::function<bool()>) override {}
  void SetLocalisation(const core::Pose&) override {}
  sim::MotionStatus Stand(double) override { return sim::MotionStatus::kReached; }
  sim::WalkResult Walk(const sim::WalkPath&, const core::TerrainView*) override { return {}; }
  sim::MotionStatus RollSweep() override { return sim::MotionStatus::kReached; }
  double time_s() const override { return time; }
  core::Pose T_odom_base() const override { return T_odom_base_now; }
  const sim::SafetyCounts& safety() const override { return counts; }
  std::string render_backend() const override { return "none"; }
  core::Pose TrueBasePose() const override { return T_map_base_true; }
  sim::Snapshot TrueState() const override { return {time, {}}; }
  void AddStateObserver(std::function<void(const sim::Snapshot&)> observer, double) override {
    observers.push_back(std::move(observer));
  }

  double time = 0.0;
  core::Pose T_odom_base_now = core::Pose::Identity(), T_map_base_true = core::Pose::Identity();
  sim::SafetyCounts counts;
  std::vector<std::function<void(const sim::Snapshot&)>> observers;
};

}  // namespace atlas::tests
