#include "experiments/bench/bench_dataset.h"

#include "experiments/record/recorder.h"

namespace atlas::experiments {

BenchDataset RecordBenchDataset(const std::string& scene, int max_scans, int threads,
                                const std::function<void(double)>& progress) {
  RecordOptions options;
  options.scene = scene;
  options.threads = threads;
  DatasetRecorder recorder(options);
  const size_t all = recorder.stamps_s().size();
  const size_t count = max_scans > 0 ? std::min(all, static_cast<size_t>(max_scans)) : all;
  BenchDataset dataset{scene, recorder.scene(), recorder.lidar(), {}};
  core::SpinEvent spin;
  while (dataset.spins.size() < count && recorder.Next(&spin)) {
    dataset.spins.push_back(std::move(spin));
    progress(static_cast<double>(dataset.spins.size()) / static_cast<double>(count));
  }
  return dataset;
}

}  // namespace atlas::experiments
