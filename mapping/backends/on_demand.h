// Work that waits until someone asks for its result.
#pragma once

#include <mutex>

namespace atlas::mapping {

/// Runs once after each Request(), on the thread that asks first, while others that ask wait for it: what
/// the work wrote is visible to every thread whose Ensure() returned. Request() itself is for the one thread
/// that writes, while nobody asks.
class OnDemand {
 public:
  void Request() { wanted_ = true; }

  template <typename Work>
  void Ensure(const Work& work) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!wanted_) return;
    work();
    wanted_ = false;
  }

 private:
  mutable std::mutex mutex_;
  mutable bool wanted_ = false;
};

}  // namespace atlas::mapping
