// Data-parallel loops whose results never depend on the number of threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace atlas::core {

/// Calls `body(begin, end, worker)` on consecutive ranges that partition [0, count), one range a worker.
/// `body` writes only to slots of its own range; whatever it reduces across ranges must not depend on the
/// split. An exception in any range is rethrown here once all have ended.
template <typename Body>
void ParallelFor(int threads, size_t count, const Body& body) {
  const size_t workers =
      std::clamp<size_t>(static_cast<size_t>(std::max(threads, 1)), 1, std::max<size_t>(count, 1));
  if (workers == 1) {
    if (count > 0) body(size_t{0}, count, size_t{0});
    return;
  }
  std::vector<std::exception_ptr> errors(workers);
  const auto run = [&](size_t worker) {
    try {
      body(count * worker / workers, count * (worker + 1) / workers, worker);
    } catch (...) {
      errors[worker] = std::current_exception();
    }
  };
  std::vector<std::thread> pool;
  pool.reserve(workers - 1);
  for (size_t worker = 1; worker < workers; ++worker) pool.emplace_back(run, worker);
  run(0);
  for (std::thread& thread : pool) thread.join();
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace atlas::core
