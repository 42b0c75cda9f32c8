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
  explicit CopyOnWrite(T value) : held_(std::make_shared<Held>(std::move(value))) {}

  std::shared_ptr<const T> Share() const {
    held_->readers.fetch_add(1, std::memory_order_relaxed);
    return {&held_->value,
            [held = held_](const T*) { held->readers.fetch_sub(1, std::memory_order_release); }};
  }
  const T& Read() const { return held_->value; }
  T& Write() {
    // Acquired, so that the reads of whoever let go last are over.
    if (held_->readers.load(std::memory_order_acquire) > 0) held_ = std::make_shared<Held>(Read().Clone());
    return held_->value;
  }

 private:
  struct Held {
    explicit Held(T v) : value(std::move(v)) {}
    T value;
    std::atomic<int> readers{0};
  };
  std::shared_ptr<Held> held_;
};

}  // namespace atlas::mapping
