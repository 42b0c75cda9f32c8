// `localisation.name: none`. One keyframe: where the odometry began.
#include "mapping/slam/builders.h"
#include "mapping/slam/fixed_poses.h"

namespace atlas::mapping {
namespace {

class NoLocaliser final : public Localiser {
 public:
  explicit NoLocaliser(const core::Pose& T_map_odom)
      : T_map_odom_(T_map_odom), poses_(std::make_shared<FixedPoses>(std::vector<core::Pose>{T_map_odom})) {}

  void OnState(const core::StateEvent&) override {}
  core::AnchoredSpin Place(std::shared_ptr<const core::SpinEvent> spin) override {
    return {.spin = std::move(spin), .keyframe = 0};
  }
  core::Pose T_map_odom() const override { return T_map_odom_; }
  std::shared_ptr<const core::PoseSource> poses() const override { return poses_; }

 private:
  core::Pose T_map_odom_;
  std::shared_ptr<const FixedPoses> poses_;
};

}  // namespace

std::unique_ptr<Localiser> BuildNoLocaliser(const LocalisationParams&, const LocaliserStart& start,
                                            const core::Rng&) {
  return std::make_unique<NoLocaliser>(start.T_map_odom);
}

}  // namespace atlas::mapping
