// A parallel loop whose workers take the next item as they come free, and a clock for its callers.
#pragma once

#include <algorithm>
#include <atomic>
#include <ctime>

#include "core/parallel_for.h"

namespace atlas::mapping {

/// CPU milliseconds of the calling thread.
inline double ThreadCpuMs() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

/// Calls body(i, worker) once for each i below count. Items must not depend on each other.
template <typename Body>
void ForEachDynamic(int threads, size_t count, const Body& body) {
  std::atomic<size_t> next{0};
  const size_t workers = std::min(static_cast<size_t>(std::max(threads, 1)), std::max<size_t>(count, 1));
  core::ParallelFor(static_cast<int>(workers), workers, [&](size_t, size_t, size_t worker) {
    for (size_t i = next.fetch_add(1, std::memory_order_relaxed); i < count;
         i = next.fetch_add(1, std::memory_order_relaxed)) {
      body(i, static_cast<int>(worker));
    }
  });
}

}  // namespace atlas::mapping
