#include "experiments/judge/explored_volume.h"

#include <algorithm>
#include <cmath>

#include "experiments/judge/sweep_aim.h"

namespace atlas::experiments {
namespace {

using core::Vec3;
using core::Vec3f;

/// A ray that stops this much before a cell's centre does not show it.
constexpr float kShort_m = 1e-3f;

std::vector<Vec3f> CentersIn(const core::Box3& box, double cell_m) {
  std::vector<Vec3f> centers;
  const Vec3 half = Vec3::Constant(0.5 * cell_m);
  for (Vec3 p = box.min + half; p.z() < box.max.z(); p.z() += cell_m) {
    for (p.y() = box.min.y() + half.y(); p.y() < box.max.y(); p.y() += cell_m) {
      for (p.x() = box.min.x() + half.x(); p.x() < box.max.x(); p.x() += cell_m)
        centers.push_back(p.cast<float>());
    }
  }
  return centers;
}

/// From one position: which of the open cells a sweep shows. They are taken out of `open`.
class Look {
 public:
  Look(const SweepAim& aim, const VolumeOptions& options, const CastRays& cast)
      : aim_(aim), options_(options), cast_(cast) {}

  void From(const Vec3& ground, uint64_t seed, std::vector<Vec3f>* open, std::vector<Vec3f>* seen) {
    rays_.clear();
    aimed_.clear();
    const Vec3f sensor = (ground + Vec3(0.0, 0.0, aim_.sensor_height_m())).cast<float>();
    const auto limit = static_cast<float>(options_.max_range_m);
    SweepAim::Shot shot;
    for (size_t i = 0; i < open->size(); ++i) {
      if (((*open)[i] - sensor).squaredNorm() > limit * limit) continue;
      if (!aim_.At(ground, (*open)[i], 0, &shot)) continue;
      rays_.push_back({shot.origin, shot.direction});
      aimed_.push_back({i, shot.distance_m});
    }
    range_.resize(rays_.size());
    cast_(rays_, limit, seed, range_);
    std::vector<uint8_t> shown(open->size(), 0);
    for (size_t k = 0; k < rays_.size(); ++k) {
      if (range_[k] < 0.0f || range_[k] > aimed_[k].distance_m - kShort_m) shown[aimed_[k].cell] = 1;
    }
    size_t kept = 0;
    for (size_t i = 0; i < open->size(); ++i) {
      if (shown[i]) {
        seen->push_back((*open)[i]);
      } else {
        (*open)[kept++] = (*open)[i];
      }
    }
    open->resize(kept);
  }

 private:
  struct Aimed {
    size_t cell;
    float distance_m;
  };
  const SweepAim& aim_;
  const VolumeOptions& options_;
  const CastRays& cast_;
  std::vector<core::Ray> rays_;
  std::vector<Aimed> aimed_;
  std::vector<float> range_;
};

}  // namespace

ExploredVolume::ExploredVolume(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                               const core::LidarModel& lidar, const VolumeOptions& options,
                               const CastRays& cast, const AttainableProgress& progress)
    : cell_m3_(std::pow(options.cell_m, 3)) {
  AttainableOptions reach;
  reach.max_range_m = options.max_range_m;
  reach.sweep_roll_deg = options.sweep_roll_deg;
  reach.reach = options.reach;
  const ReachableSet set = ReachableForScanning(scene, robot, lidar, reach);
  const std::vector<Vec3> positions =
      LatticePositions(set, scene.T_map_spawn.translation(), options.lattice_m);
  const SweepAim aim(robot, lidar, options.headings, core::Radians(options.sweep_roll_deg));
  Look look(aim, options, cast);
  std::vector<Vec3f> open = CentersIn(scene.object_box, options.cell_m);
  for (size_t i = 0; i < positions.size() && !open.empty(); ++i) {
    look.From(positions[i], i, &open, &centers_);
    progress(static_cast<double>(i + 1) / static_cast<double>(positions.size()));
  }
}

double ExploredVolume::ExploredM3(const mapping::MapView& map) const {
  const auto known = std::count_if(centers_.begin(), centers_.end(), [&](const Vec3f& p) {
    return map.StateAt(p.cast<double>()) != mapping::CellState::kUnknown;
  });
  return cell_m3_ * static_cast<double>(known);
}

}  // namespace atlas::experiments
