// `localisation.name: truth`. Each fix of T_map_base begins a keyframe, which holds what is seen until the
// next. A robot that scans stands: all revolutions of a scanning action belong to the keyframe that it began
// in.
#include "mapping/slam/builders.h"
#include "mapping/slam/fixed_poses.h"

namespace atlas::mapping {
namespace {

using core::Pose;
using core::Vec3;

constexpr double kTimeEps = 1e-6;  ///< clocks add up steps

/// A keyframe is the odometry's frame as a fix placed it, so that T_keyframe_odom is the identity.
class TruthLocaliser final : public Localiser {
 public:
  TruthLocaliser(const LocalisationParams& params, const LocaliserStart& start, const core::Rng& rng)
      : params_(params),
        T_map_base_true_(start.T_map_base_true),
        rng_(rng.Split("localisation")),
        keyframes_(params.sigma_m) {
    Fix(start.T_odom_base);
  }

  void OnState(const core::StateEvent& state) override {
    if (state.time_s < next_fix_s_ - kTimeEps) return;
    next_fix_s_ += params_.period_s;
    Fix(state.T_odom_base);
  }

  core::AnchoredSpin Place(std::shared_ptr<const core::SpinEvent> spin) override {
    const bool goes_on = std::exchange(scanning_, spin->scanning) && spin->scanning;
    if (!goes_on) BeginKeyframe();
    return {.spin = std::move(spin), .keyframe = static_cast<core::KeyframeId>(keyframes_.size() - 1)};
  }

  Pose T_map_odom() const override { return T_map_odom_; }

  std::shared_ptr<const core::PoseSource> poses() const override {
    if (!snapshot_) snapshot_ = keyframes_.Snapshot();
    return snapshot_;
  }

 private:
  void Fix(const Pose& T_odom_base) {
    const auto draw = [this](double sigma) {
      return Vec3(sigma * rng_.Normal(), sigma * rng_.Normal(), sigma * rng_.Normal());
    };
    const Pose T_map_base = T_map_base_true_();
    const Vec3 shift = draw(params_.sigma_m);
    const Vec3 turn = draw(core::Radians(params_.sigma_deg));
    const core::Mat3 R = core::RotationFromYawPitchRoll(turn.z(), turn.y(), turn.x()) * T_map_base.linear();
    T_map_odom_ = core::MakePose(R, T_map_base.translation() + shift) * T_odom_base.inverse();
    fixed_ = true;
  }

  /// At the latest fix, where that has none yet.
  void BeginKeyframe() {
    if (!std::exchange(fixed_, false)) return;
    keyframes_.Add(T_map_odom_);
    snapshot_.reset();
  }

  LocalisationParams params_;
  std::function<Pose()> T_map_base_true_;
  core::Rng rng_;
  Pose T_map_odom_;
  double next_fix_s_ = 0.0;
  bool fixed_ = false, scanning_ = false;
  KeyframeList keyframes_;
  mutable std::shared_ptr<const FixedPoses> snapshot_;
};

}  // namespace

std::unique_ptr<Localiser> BuildTruthLocaliser(const LocalisationParams& params, const LocaliserStart& start,
                                               const core::Rng& rng) {
  return std::make_unique<TruthLocaliser>(params, start, rng);
}

}  // namespace atlas::mapping
