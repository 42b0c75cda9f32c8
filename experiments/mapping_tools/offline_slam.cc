#include "experiments/mapping_tools/offline_slam.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/errors.h"
#include "mapping/atlas/saved_atlas.h"
#include "mapping/atlas/saved_slam.h"
#include "mapping/meshing/marching_cubes.h"
#include "mapping/slam/graph_covariance.h"
#include "mapping/slam/lidar_front_end.h"

namespace atlas::experiments {

namespace fs = std::filesystem;
using core::Mat6;
using core::Pose;

namespace {

/// Every keyframe of the atlas is a node of the graph.
void CheckFit(const fs::path& folder, const mapping::SavedAtlas& atlas, const mapping::SlamMemory& memory) {
  for (const mapping::SavedSubmap& submap : atlas.submaps) {
    for (const mapping::HeldKeyframe& held : submap.keyframes) {
      if (held.sensor.keyframe < memory.graph.size() && submap.root < memory.graph.size()) continue;
      throw core::InputError(fmt::format("{}: keyframe {} of submap {}, must be below {} (slam/graph.g2o)",
                                         (folder / "keyframes.csv").string(), held.sensor.keyframe, submap.id,
                                         memory.graph.size()));
    }
  }
}

}  // namespace

void OfflineSlamParams::Visit(core::ParamVisitor& v) {
  v.Section("lidar_odometry", &lidar_odometry);
  v.Section("slam", &slam);
  v.Section("mapper", &mapper);
}

struct OfflineSlam::Impl {
  Impl(const OfflineSlamParams& p, const std::optional<core::LidarModel>& lidar, const fs::path& earlier)
      : params(p), odometry(p.lidar_odometry) {
    std::shared_ptr<const mapping::SlamMemory> memory;
    std::shared_ptr<const mapping::SavedAtlas> atlas;
    if (!earlier.empty()) {
      atlas = std::make_shared<const mapping::SavedAtlas>(mapping::LoadAtlas(earlier));
      memory = std::make_shared<const mapping::SlamMemory>(
          mapping::LoadSlamMemory(mapping::SlamFolderOf(earlier)));
      CheckFit(earlier, *atlas, *memory);
    }
    mapping::LocalisationParams localisation;
    localisation.name = "slam";
    localisation.slam = p.slam;
    mapping::LocaliserStart start;
    start.threads = p.lidar_odometry.threads;
    start.edge_covariance = [this](double edge_m) {
      return motion.Take(Pose::Identity(), edge_m, params.lidar_odometry.edge_floor_m,
                         params.lidar_odometry.edge_floor_deg);
    };
    start.earlier = std::move(memory);
    localiser = mapping::MakeLocaliser(localisation, start, core::Rng(1));
    map = mapping::MakeMap(p.mapper, {.lidar = lidar, .earlier = std::move(atlas)});
  }

  OfflineSlamParams params;
  mapping::LidarOdometry odometry;
  mapping::MotionCovariance motion;
  std::unique_ptr<mapping::Localiser> localiser;
  std::unique_ptr<mapping::Map> map;
  struct Placed {
    double time_s;
    core::Anchor lidar;
  };
  std::vector<Placed> placed;
  std::optional<core::StampedPose> last;  ///< T_odom_lidar at the end of the last scan
  mapping::OdometryHealth health;
  double way_m = 0.0;
  std::vector<core::AnchoredSpin> waiting;  ///< until it is known where they lie
  uint64_t version = 0;                     ///< of the graph whose loops were counted
  size_t loops = 0;

  /// Scans go to the map once it is known where they lie in it.
  void Integrate(core::AnchoredSpin spin) {
    constexpr size_t kMostWaiting = 2000;
    waiting.push_back(std::move(spin));
    if (!localiser->located() && waiting.size() < kMostWaiting) return;
    IntegrateWaiting();
  }
  void IntegrateWaiting() {
    if (!localiser->located()) {
      throw core::InputError(fmt::format(
          "the session was not recognised in the atlas to go on from, after {} scans and {:.1f} m: begin "
          "where the earlier one has been",
          waiting.size(), way_m));
    }
    for (const core::AnchoredSpin& spin : std::exchange(waiting, {}))
      map->Integrate(spin, *localiser->poses());
  }

  void CountLoops() {
    if (std::exchange(version, localiser->poses()->version()) == localiser->poses()->version()) return;
    const mapping::PoseGraph graph = *localiser->InlierGraph();
    loops = static_cast<size_t>(std::count_if(graph.edges.begin(), graph.edges.end(), [](const auto& edge) {
      return edge.kind == mapping::EdgeKind::kLoop;
    }));
  }
};

OfflineSlam::OfflineSlam(const OfflineSlamParams& params, const std::optional<core::LidarModel>& lidar,
                         const fs::path& earlier)
    : impl_(std::make_unique<Impl>(params, lidar, earlier)) {}
OfflineSlam::~OfflineSlam() = default;

void OfflineSlam::Add(core::LidarScan scan, const std::optional<core::PoseTrajectory>& T_prior_lidar) {
  Impl& m = *impl_;
  auto spin = std::make_shared<core::SpinEvent>();
  spin->scan = std::move(scan);
  mapping::LidarOdometryResult found;
  if (T_prior_lidar) {
    spin->T_odom_lidar = *T_prior_lidar;
    found = m.odometry.Add(*spin);
  } else {
    found = m.odometry.Add(spin->scan);
  }
  spin->T_odom_lidar = found.trajectory;
  ++m.health.revolutions;
  if (m.last) {
    const Pose T_last_now = m.last->T.inverse() * found.T_odom_lidar;
    m.motion.Add(T_last_now, found.information);
    m.way_m += T_last_now.translation().norm();
    m.health.lost += !found.tracked;
    m.health.degenerate += found.tracked && found.degenerate;
  }
  core::StateEvent state;
  state.time_s = found.time_s;
  state.T_odom_base = found.T_odom_lidar;
  m.localiser->OnState(state);
  const double time_s = spin->scan.stamp_s;
  Pose T_odom_stamp = spin->T_odom_lidar.At(time_s);
  // Where scans follow one another, the end of the last is this start, measured twice.
  constexpr double kSameTime_s = 0.005;
  if (m.last && std::abs(m.last->time_s - time_s) < kSameTime_s)
    T_odom_stamp = m.last->T * core::Exp(0.5 * core::Log(m.last->T.inverse() * T_odom_stamp));
  m.last = core::StampedPose{found.time_s, found.T_odom_lidar};
  const core::AnchoredSpin anchored = m.localiser->Place(std::move(spin));
  m.placed.push_back({time_s, {anchored.keyframe, anchored.T_keyframe_odom * T_odom_stamp}});
  m.CountLoops();
  m.Integrate(anchored);
}

void OfflineSlam::Settle() {
  impl_->localiser->Settle();
  impl_->CountLoops();
  impl_->IntegrateWaiting();
  impl_->map->Correct(*impl_->localiser->poses());
}

bool OfflineSlam::located() const {
  return impl_->localiser->located();
}

void OfflineSlam::Save(const fs::path& folder) const {
  const fs::path atlas = folder / impl_->map->Save(folder);
  const auto memory = impl_->localiser->Memory();
  if (memory && !memory->graph.edges.empty()) mapping::WriteSlamMemory(mapping::SlamFolderOf(atlas), *memory);
}

const mapping::OdometryHealth& OfflineSlam::health() const {
  return impl_->health;
}
size_t OfflineSlam::keyframes() const {
  return impl_->localiser->poses()->latest() + size_t{1};
}
size_t OfflineSlam::loops() const {
  return impl_->loops;
}
double OfflineSlam::way_m() const {
  return impl_->way_m;
}
const mapping::Map& OfflineSlam::map() const {
  return *impl_->map;
}

std::vector<SlamPose> OfflineSlam::Trajectory() const {
  const auto poses = impl_->localiser->poses();
  const auto covariance = mapping::GraphCovariance::Of(*impl_->localiser->InlierGraph());
  std::vector<SlamPose> trajectory;
  std::optional<core::KeyframeId> keyframe;
  Mat6 of_keyframe = Mat6::Zero();
  for (const Impl::Placed& placed : impl_->placed) {
    SlamPose pose{placed.time_s, placed.lidar.T_map_here(*poses), std::nullopt};
    if (covariance) {
      if (keyframe != placed.lidar.keyframe) of_keyframe = covariance->Marginal(placed.lidar.keyframe);
      keyframe = placed.lidar.keyframe;
      const Mat6 A = core::Adjoint(placed.lidar.T_keyframe_here.inverse());
      pose.covariance = A * of_keyframe * A.transpose();
    }
    trajectory.push_back(pose);
  }
  return trajectory;
}

mapping::G2oGraph OfflineSlam::Graph() const {
  mapping::G2oGraph file;
  file.graph = *impl_->localiser->InlierGraph();
  for (uint32_t node = 0; node < file.graph.size(); ++node) file.id.push_back(node);
  return file;
}

core::TriMesh OfflineSlam::Mesh(int threads) const {
  impl_->map->Correct(*impl_->localiser->poses());
  mapping::MeshOptions options;
  options.threads = threads;
  const auto view = std::dynamic_pointer_cast<const mapping::AtlasView>(impl_->map->Snapshot());
  return mapping::ExtractMesh(*view, options);
}

}  // namespace atlas::experiments
