// A value that readers hold on to while its owner changes it.
#pragma once

#include <atomic>
#include <memory>
#include <utility>

namespace atlas::mapping {

/// One owner writes; what it shared before stays as it was, copied only where somebody still holds it. T has
/// a Clone().
template <typename T>
class CopyOnWrite {
 public:
  explicit CopyOnWrite(T value) : value_(std::make_shared<T>(std::move(value))) {}

  std::shared_ptr<const T> Share() const { return value_; }
  const T& Read() const { return *value_; }
  T& Write() {
    if (value_.use_count() > 1) {
      value_ = std::make_shared<T>(value_->Clone());
    } else {
      std::atomic_thread_fence(std::memory_order_acquire);  // after the reads of whoever let go last
    }
    return *value_;
  }

 private:
  std::shared_ptr<T> value_;
};

}  // namespace atlas::mapping
