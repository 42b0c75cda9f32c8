// A recorded LiDAR log, replayed as the sensor events that the simulator emits live.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/sensor_events.h"
#include "mapping/io/beam_table.h"

namespace atlas::mapping {

struct RecordedLogOptions {
  /// One cloud, an OctoMap scan graph (.graph binary, or text with NODE rows), a ROS 1 bag (FILE.bag or
  /// FILE.bag:/topic), "FOLDER/part*.pcd", or a folder of clouds, in it or in its scans/ (or velodyne/). Of a
  /// folder, poses.tum (or poses.txt), trajectory.tum, calib.txt and dataset.yaml are taken where they are
  /// not given below.
  std::string scans;
  /// TUM, KITTI or matrix file (ReadPoses); FILE.bag:/topic for poses of a bag. Empty: the data set's own,
  /// the bag's only topic of poses, the graph's, the viewpoints of PCD files, files T_<A>_<B>.txt beside
  /// clouds A and B, identity for one scan.
  std::string poses;
  /// TUM file at a high rate: where clouds tell the times of their points, each ray has its own pose.
  std::string trajectory;
  /// No poses are looked for: each scan's is the identity, its time that of its name or, by order, ten a
  /// second.
  bool without_poses = false;
  /// The LiDAR in the frame whose poses were recorded (ReadCalibration), where that is another.
  std::string calibration;
  /// Beams of organised clouds: "auto" (estimate; unorganised where the points are not a spinning LiDAR's),
  /// "estimate", "none" (take all clouds as unorganised), a name of core::LidarModelNames() or Ouster's
  /// FILE.json.
  std::string lidar = "auto";
  /// What a point without a return means where the file does not tell. Of an unknown log it is no evidence:
  /// the beam may have been absorbed, mirrored away, too near or filtered out before the file was written.
  core::ReturnKind no_return = core::ReturnKind::kDropout;
  /// A scan meets the poses within this of the time in its name.
  double max_dt_s = 0.05;
  /// Nearer returns carry no information (the robot itself). 0: the LiDAR's, where it is a known one.
  double min_range_m = 0.0;
  /// Farther returns become void: nothing was met within the range. 0: the LiDAR's, where it is a known one;
  /// else the farthest return of each scan.
  double max_range_m = 0.0;
};

/// The scans of a log in natural order (10 after 9), met with their poses when the log is opened, read one at
/// a time. Immutable once open; Read may be called from several threads.
class RecordedLog {
 public:
  /// Lists scans, meets poses, fits the beams to the first scans of an organised log. @throws InputError for
  /// whatever is missing or wrong, and where no scan has a pose.
  explicit RecordedLog(const RecordedLogOptions& options);
  ~RecordedLog();
  RecordedLog(RecordedLog&&) noexcept;
  RecordedLog& operator=(RecordedLog&&) noexcept;

  size_t size() const;                                ///< scans with a pose
  size_t scans_without_pose() const;                  ///< listed but left out
  std::string name(size_t index) const;               ///< "1583840211.123456789.pcd"
  double stamp_s(size_t index) const;                 ///< by the name, the pose it met, or ten scans a second
  const core::Pose& T_map_lidar(size_t index) const;  ///< at the stamp

  /// The scan as one event whose odom frame is the map. Organised: rows x columns, no-return pixels along the
  /// beam table. Unorganised: rows = 0, columns = number of returns (see core::LidarScan). Per-ray times
  /// where the cloud has them, and the poses of the trajectory while the scan lasted; else one pose.
  /// @throws InputError naming the file when it is unreadable or of another shape than the first.
  core::SpinEvent Read(size_t index) const;

  /// The beams of organised clouds; none for unorganised ones.
  const std::optional<BeamFit>& beams() const;
  /// "130 organised scans 64 x 1024 (beams estimated, residual 0.01 deg), poses of poses.tum by time": a line
  /// for the command to print.
  std::string Describe() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atlas::mapping
