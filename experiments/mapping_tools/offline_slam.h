// A map out of a recorded log that nobody posed: what `atlas slam` does between reading scans and writing
// files. LiDAR odometry places each scan in the odometry's frame, a pose graph with loops its keyframes in
// the map, and an atlas of submaps takes the scans.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "core/lidar_model.h"
#include "core/mesh.h"
#include "core/params.h"
#include "mapping/backends/catalog.h"
#include "mapping/slam/g2o_file.h"
#include "mapping/slam/lidar_odometry.h"
#include "mapping/slam/localiser.h"

namespace atlas::experiments {

/// The sections `lidar_odometry`, `slam` and `mapper` of `--set`.
struct OfflineSlamParams {
  mapping::LidarOdometryParams lidar_odometry;
  mapping::SlamParams slam;
  mapping::MapperParams mapper;
  OfflineSlamParams() { mapper.name = "atlas"; }
  void Visit(core::ParamVisitor& v);
};

/// A scan's place, and how sure that is.
struct SlamPose {
  double time_s = 0.0;
  core::Pose T_map_lidar = core::Pose::Identity();
  /// Of xi in T Exp(xi), [translation; rotation], the first scan held; absent where the graph has none.
  std::optional<core::Mat6> covariance;
};

class OfflineSlam {
 public:
  /// @param lidar  the beams of organised scans; none: scans are cast ray by ray.
  /// @param earlier  the folder of a saved atlas to go on from; empty: none.
  /// @throws InputError where that is damaged, or remembers no way.
  OfflineSlam(const OfflineSlamParams& params, const std::optional<core::LidarModel>& lidar,
              const std::filesystem::path& earlier = {});
  ~OfflineSlam();

  /// The next scan in time. `T_prior_lidar` is the user's own odometry while the scan lasted; none: the last
  /// motion goes on.
  void Add(core::LidarScan scan, const std::optional<core::PoseTrajectory>& T_prior_lidar);

  /// After the last scan: takes over the loops that are still being worked out.
  /// @throws InputError where a session that goes on from another was never located in it.
  void Settle();
  bool located() const;
  /// The atlas, and what a later session goes on from.
  void Save(const std::filesystem::path& folder) const;
  const mapping::OdometryHealth& health() const;
  size_t keyframes() const;
  size_t loops() const;  ///< accepted
  double way_m() const;  ///< along odometry
  const mapping::Map& map() const;
  /// As loops have it by now: one a scan, at its start.
  std::vector<SlamPose> Trajectory() const;
  mapping::G2oGraph Graph() const;
  /// Of all submaps, each where it lies by now.
  core::TriMesh Mesh(int threads) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atlas::experiments
