#include "experiments/bench/places_bench.h"

#include <algorithm>
#include <map>
#include <optional>

#include "core/parallel_for.h"
#include "core/rng.h"
#include "core/stopwatch.h"
#include "experiments/record/recorder.h"
#include "mapping/slam/loop_check.h"
#include "mapping/slam/places.h"
#include "sim/sensors/lidar.h"

namespace atlas::experiments {
namespace {

using core::Pose;
using core::Vec3f;

constexpr double kSpacing_m = 2.0, kNear_m = 3.0;
constexpr size_t kSkipYoungest = 10;
constexpr size_t kChecked = 4;  // keyframes looked at for each query

struct PlaceKeyframe {
  Pose T_map_here;  ///< level
  std::vector<Vec3f> p_here;
};

/// There and back: the way back runs up to 0.3 m aside, and everywhere the LiDAR is turned at random.
std::vector<Pose> PosesThereAndBack(const core::PoseTrajectory& way, core::Rng* rng) {
  std::vector<Pose> poses;
  for (const core::StampedPose& pose : way.poses()) {
    const bool far =
        poses.empty() || (pose.T.translation() - poses.back().translation()).norm() >= kSpacing_m;
    if (far) poses.push_back(core::PoseFromXyzYaw(pose.T.translation(), rng->Uniform(-core::kPi, core::kPi)));
  }
  for (size_t i = poses.size(); i-- > 0;) {
    const core::Vec3 aside(rng->Uniform(-0.2, 0.2), rng->Uniform(-0.2, 0.2), 0.0);
    poses.push_back(
        core::PoseFromXyzYaw(poses[i].translation() + aside, rng->Uniform(-core::kPi, core::kPi)));
  }
  return poses;
}

std::vector<PlaceKeyframe> Keyframes(const std::string& scene, const std::string& lidar_name, int threads) {
  RecordOptions options;
  options.scene = scene;
  options.lidar = lidar_name;
  DatasetRecorder recorder(options);
  sim::Raycaster raycaster(recorder.scene());
  raycaster.CommitPoses();
  sim::Lidar lidar(recorder.lidar(), core::Rng(1).Split("places_lidar"));
  core::Rng rng = core::Rng(1).Split("places_way");
  std::vector<PlaceKeyframe> keyframes;
  for (const Pose& T : PosesThereAndBack(recorder.trajectory(), &rng)) {
    core::PoseTrajectory standing;
    standing.Add(0.0, T);
    const core::LidarScan scan = lidar.Spin(
        &raycaster, 0.0, standing, [](double) {}, threads);
    keyframes.push_back({T, {}});
    for (size_t i = 0; i < scan.size(); ++i) {
      if (scan.kind[i] == core::ReturnKind::kHit)
        keyframes.back().p_here.push_back(scan.range_m[i] * scan.direction_lidar[i]);
    }
  }
  return keyframes;
}

bool PoseIsRight(const Pose& found, const Pose& truth, double within_m, double within_deg) {
  const Pose error = truth.inverse() * found;
  return error.translation().head<2>().norm() <= within_m &&
         Eigen::AngleAxisd(error.linear()).angle() <= core::Radians(within_deg);
}

/// What a graph might believe: the truth, off by what its covariance says.
mapping::LoopEstimate EstimateOf(const Pose& truth, core::Rng* rng) {
  mapping::Vector6 sigma, off;
  sigma << 0.6, 0.6, 0.1, core::Radians(1.0), core::Radians(1.0), core::Radians(2.0);
  for (int k = 0; k < 6; ++k) off[k] = sigma[k] * rng->Normal();
  mapping::LoopEstimate estimate;
  estimate.T_a_b = mapping::Perturbed(truth, off);
  estimate.covariance = mapping::Matrix6(sigma.cwiseAbs2().asDiagonal());
  return estimate;
}

/// The first keyframe, by distance, whose loop is accepted.
LoopOffer FirstAccepted(const std::vector<mapping::PlaceCandidate>& candidates, size_t query,
                        const std::vector<PlaceKeyframe>& keyframes,
                        const std::vector<mapping::LoopScan>& scans, core::Rng* gate_rng, int threads) {
  mapping::LoopCheckParams params;
  params.registration.threads = threads;
  std::vector<uint32_t> order;
  std::map<uint32_t, std::vector<Pose>> starts;
  std::map<uint32_t, double> distance;
  for (const mapping::PlaceCandidate& candidate : candidates) {
    if (starts.count(candidate.id) == 0) {
      order.push_back(candidate.id);
      distance[candidate.id] = candidate.distance;
    }
    starts[candidate.id].push_back(candidate.T_candidate_query);
  }
  for (size_t k = 0; k < std::min(order.size(), kChecked); ++k) {
    const uint32_t id = order[k];
    const Pose truth = keyframes[id].T_map_here.inverse() * keyframes[query].T_map_here;
    std::optional<mapping::LoopEstimate> estimate;
    if (gate_rng != nullptr) estimate = EstimateOf(truth, gate_rng);
    const auto found = mapping::CheckLoop(scans[id], scans[query], starts[id], estimate, params);
    if (found.accepted()) return {distance[id], PoseIsRight(found.T_a_b, truth, 0.2, 1.0)};
  }
  return {2.0, false};
}

bool SeenBefore(const std::vector<PlaceKeyframe>& keyframes, size_t query) {
  for (size_t i = 0; i + kSkipYoungest < query; ++i) {
    const core::Vec3 between =
        keyframes[i].T_map_here.translation() - keyframes[query].T_map_here.translation();
    if (between.norm() <= kNear_m) return true;
  }
  return false;
}

void DescribeAll(const std::vector<PlaceKeyframe>& keyframes, int threads, PlacesCase* result,
                 std::vector<mapping::PlaceDescriptor>* places, std::vector<mapping::LoopScan>* scans) {
  mapping::SurfaceCloudParams cloud;
  cloud.threads = threads;
  core::Stopwatch watch;
  for (const PlaceKeyframe& keyframe : keyframes) places->push_back(mapping::DescribePlace(keyframe.p_here));
  result->describe_ms = 1e3 * watch.seconds() / static_cast<double>(keyframes.size());
  for (const PlaceKeyframe& keyframe : keyframes)
    scans->push_back(mapping::PrepareLoopScan(keyframe.p_here, cloud));
}

}  // namespace

PlacesCase RunPlacesCase(const std::string& scene, const std::string& lidar, int threads,
                         const std::function<void(double)>& progress) {
  const std::vector<PlaceKeyframe> keyframes = Keyframes(scene, lidar, threads);
  PlacesCase result;
  result.scene = scene;
  result.lidar = lidar;
  result.keyframes = keyframes.size();
  std::vector<mapping::PlaceDescriptor> places;
  std::vector<mapping::LoopScan> scans;
  DescribeAll(keyframes, threads, &result, &places, &scans);
  core::Rng gate = core::Rng(1).Split("places_gate");
  mapping::PlaceDatabase database;
  mapping::PlaceQueryParams query;
  query.skip_youngest = kSkipYoungest;
  for (size_t i = 0; i < keyframes.size(); ++i) {
    core::Stopwatch watch;
    const auto candidates = database.Query(places[i], query);
    result.query_ms += 1e3 * watch.seconds() / static_cast<double>(keyframes.size());
    result.revisits += SeenBefore(keyframes, i);
    LoopOffer first{2.0, false};
    if (!candidates.empty()) {
      const Pose truth = keyframes[candidates[0].id].T_map_here.inverse() * keyframes[i].T_map_here;
      first = {candidates[0].distance, PoseIsRight(candidates[0].T_candidate_query, truth, 1.5, 10.0)};
    }
    result.by_descriptor.push_back(first);
    core::Stopwatch checks;
    result.by_sight.push_back(FirstAccepted(candidates, i, keyframes, scans, nullptr, threads));
    result.check_ms += 1e3 * checks.seconds() / static_cast<double>(keyframes.size());
    result.in_gate.push_back(FirstAccepted(candidates, i, keyframes, scans, &gate, threads));
    database.Add(static_cast<uint32_t>(i), places[i]);
    progress(static_cast<double>(i + 1) / static_cast<double>(keyframes.size()));
  }
  return result;
}

std::vector<PrecisionRecall> PrecisionRecallOf(const std::vector<LoopOffer>& offers, size_t revisits) {
  std::vector<LoopOffer> sorted = offers;
  std::erase_if(sorted, [](const LoopOffer& offer) { return offer.distance > 1.0; });
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const LoopOffer& a, const LoopOffer& b) { return a.distance < b.distance; });
  std::vector<PrecisionRecall> curve;
  size_t right = 0;
  for (size_t k = 0; k < sorted.size(); ++k) {
    right += sorted[k].right;
    if (k + 1 < sorted.size() && sorted[k + 1].distance == sorted[k].distance) continue;
    const auto share = static_cast<double>(right);
    curve.push_back({sorted[k].distance, share / static_cast<double>(k + 1),
                     share / static_cast<double>(std::max<size_t>(revisits, 1))});
  }
  return curve;
}

}  // namespace atlas::experiments
