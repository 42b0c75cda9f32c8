#include "experiments/bench/mapper_bench.h"

#include <fmt/format.h>
#include <unistd.h>

#include <ctime>
#include <fstream>
#include <memory>
#include <numeric>

#include "core/stopwatch.h"
#include "mapping/backends/octomap_peer.h"

namespace atlas::experiments {
namespace {

using mapping::CellState;

double ProcessCpuSeconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

size_t ResidentBytes() {
  std::ifstream statm("/proc/self/statm");
  size_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<size_t>(sysconf(_SC_PAGESIZE));
}

/// A mapper on the bench.
class Subject {
 public:
  virtual ~Subject() = default;
  virtual std::string name() const = 0;
  /// What is not part of the mapper's work, untimed.
  virtual void Prepare(const core::SpinEvent&) {}
  virtual void Integrate(const core::SpinEvent& spin) = 0;
  virtual CellState StateAt(const core::Vec3& p) const = 0;
  virtual size_t Bytes() const = 0;
};

class OctomapSubject : public Subject {
 public:
  explicit OctomapSubject(const MapperCase& setting) : setting_(setting), peer_(setting.resolution_m) {}
  std::string name() const override { return "OctoMap"; }
  void Prepare(const core::SpinEvent& spin) override {
    points_.clear();
    const core::LidarScan& scan = spin.scan;
    for (size_t i = 0; i < scan.size(); ++i) {
      if (scan.kind[i] != core::ReturnKind::kHit) continue;
      const core::Pose T = spin.T_odom_lidar.At(scan.stamp_s + static_cast<double>(scan.time_s[i]));
      points_.push_back((T * (scan.range_m[i] * scan.direction_lidar[i]).cast<double>()).cast<float>());
    }
    const double half = 0.5 * static_cast<double>(scan.time_s.back());
    origin_ = spin.T_odom_lidar.At(scan.stamp_s + half).translation();
  }
  void Integrate(const core::SpinEvent&) override { peer_.Insert(points_, origin_, setting_.max_range_m); }
  CellState StateAt(const core::Vec3& p) const override { return peer_.StateAt(p); }
  size_t Bytes() const override { return peer_.Bytes(); }

 private:
  MapperCase setting_;
  mapping::OctomapPeer peer_;
  std::vector<core::Vec3f> points_;
  core::Vec3 origin_ = core::Vec3::Zero();
};

template <typename Field>
class AtlasSubject : public Subject {
 public:
  AtlasSubject(const MapperCase& setting, const BenchDataset& dataset, const MapperBenchOptions& options)
      : map_(setting.resolution_m) {
    mapping::IntegratorParams params = options.integrator;
    params.max_range_m = setting.max_range_m;
    params.threads = options.threads;
    integrator_ = mapping::MakeConeIntegrator<Field>(params, dataset.lidar);
  }
  std::string name() const override { return fmt::format("SE-Atlas {}", Field::kName); }
  void Integrate(const core::SpinEvent& spin) override {
    integrator_->Integrate(spin, core::Pose::Identity(), &map_);
  }
  CellState StateAt(const core::Vec3& p) const override {
    const typename Field::Value value = map_.At(p);
    if (!Field::Known(value)) return CellState::kUnknown;
    return Field::Occupied(value) ? CellState::kOccupied : CellState::kFree;
  }
  size_t Bytes() const override { return map_.Bytes(); }

 private:
  mapping::Octree<Field> map_;
  std::unique_ptr<mapping::ScanIntegrator<Field>> integrator_;
};

double MeanOf(const std::vector<double>& values, size_t count) {
  return std::accumulate(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count), 0.0) /
         static_cast<double>(count);
}

/// Whether a mapper that is this slow or large should go on.
bool Hopeless(const MapperCourse& course, const MapperBenchOptions& options) {
  if (course.map_bytes.back() > options.octomap_bytes) return true;
  return static_cast<int>(course.cpu_ms.size()) >= options.octomap_scans &&
         MeanOf(course.cpu_ms, course.cpu_ms.size()) > 1e3 * options.octomap_patience_s;
}

void IntegrateTimed(const core::SpinEvent& spin, Subject* subject, MapperCourse* course) {
  subject->Prepare(spin);
  const size_t resident = ResidentBytes();
  const core::Stopwatch wall;
  const double cpu = ProcessCpuSeconds();
  subject->Integrate(spin);
  course->cpu_ms.push_back(1e3 * (ProcessCpuSeconds() - cpu));
  course->wall_ms.push_back(1e3 * wall.seconds());
  const size_t after = ResidentBytes();
  course->resident_growth_bytes += after > resident ? after - resident : 0;
  course->map_bytes.push_back(subject->Bytes());
}

MapQuality JudgeSubject(const QualityProbes& probes, const Subject& subject) {
  return probes.Judge([&](const core::Vec3& p) { return subject.StateAt(p); });
}

}  // namespace

std::vector<MapperCase> StandardMapperCases() {
  return {{"campus", 20.0, 0.26},
          {"campus", 60.0, 0.26},
          {"campus", 60.0, 0.065},
          {"rooms_small", 20.0, 0.26},
          {"rooms_small", 60.0, 0.065}};
}

MapperCaseResult RunMapperCase(const MapperCase& setting, const BenchDataset& dataset,
                               const MapperBenchOptions& options, const BenchProgress& progress) {
  std::vector<std::unique_ptr<Subject>> subjects;
  if (options.octomap) subjects.push_back(std::make_unique<OctomapSubject>(setting));
  subjects.push_back(std::make_unique<AtlasSubject<mapping::OccupancyField>>(setting, dataset, options));
  subjects.push_back(std::make_unique<AtlasSubject<mapping::TsdfField>>(setting, dataset, options));

  MapperCaseResult result{setting, dataset.spins.size(), dataset.spins.size(), {}};
  for (const auto& subject : subjects) result.courses.push_back({.mapper = subject->name()});
  QualityProbes probes(dataset, {.max_range_m = setting.max_range_m, .resolution_m = setting.resolution_m});
  bool octomap_runs = options.octomap;
  for (size_t scan = 0; scan < dataset.spins.size(); ++scan) {
    progress(fmt::format("{} {:.0f} m/{:.1f} cm: scan {} of {}", setting.scene, setting.max_range_m,
                         100.0 * setting.resolution_m, scan + 1, dataset.spins.size()));
    probes.AddScan(scan);
    for (size_t k = 0; k < subjects.size(); ++k) {
      if (k == 0 && options.octomap && !octomap_runs) continue;
      IntegrateTimed(dataset.spins[scan], subjects[k].get(), &result.courses[k]);
    }
    if (!octomap_runs) continue;
    if (scan + 1 < dataset.spins.size() && !Hopeless(result.courses[0], options)) continue;
    octomap_runs = false;
    result.common_scans = scan + 1;
    for (size_t k = 0; k < subjects.size(); ++k) {
      result.courses[k].early = JudgeSubject(probes, *subjects[k]);
    }
    result.courses[0].final = result.courses[0].early;
    subjects[0].reset();  // its memory is needed
  }
  for (size_t k = 0; k < subjects.size(); ++k) {
    if (subjects[k]) result.courses[k].final = JudgeSubject(probes, *subjects[k]);
  }
  return result;
}

}  // namespace atlas::experiments
