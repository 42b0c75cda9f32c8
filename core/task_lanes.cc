#include "core/task_lanes.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace atlas::core {

TaskLanes::TaskLanes(int lanes, bool threaded) : lanes_(static_cast<size_t>(lanes)), threaded_(threaded) {
  if (threaded_) thread_ = std::thread([this] { Work(); });
}

TaskLanes::~TaskLanes() {
  Abandon();
  if (!threaded_) return;
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

TaskLanes::Ticket TaskLanes::Post(int lane, Task task) {
  assert(lane >= 0 && static_cast<size_t>(lane) < lanes_.size());
  std::unique_lock lock(mutex_);
  Lane& to = lanes_[static_cast<size_t>(lane)];
  const Ticket ticket = ++to.posted;
  to.waiting.push_back(std::move(task));
  if (threaded_) {
    lock.unlock();
    changed_.notify_all();
  } else {
    RunNext(&to, &lock);
  }
  return ticket;
}

void TaskLanes::RunNext(Lane* lane, std::unique_lock<std::mutex>* lock) {
  Task task = std::move(lane->waiting.front());
  lane->waiting.pop_front();
  lane->running = true;
  const bool skip = lane->error != nullptr;
  lock->unlock();
  std::exception_ptr error;
  try {
    if (!skip) task();
  } catch (...) {
    error = std::current_exception();
  }
  task = nullptr;  // what it holds goes before the lock is taken
  lock->lock();
  if (error) lane->error = error;
  lane->running = false;
  ++lane->over;
  changed_.notify_all();
}

void TaskLanes::Work() {
  std::unique_lock lock(mutex_);
  while (true) {
    const auto next = std::find_if(lanes_.begin(), lanes_.end(),
                                   [](const Lane& lane) { return !lane.waiting.empty() && !lane.running; });
    if (next != lanes_.end()) {
      RunNext(&*next, &lock);
    } else if (ending_) {
      return;
    } else {
      changed_.wait(lock);
    }
  }
}

void TaskLanes::Wait(int lane, Ticket ticket) {
  Lane& of = lanes_[static_cast<size_t>(lane)];
  std::unique_lock lock(mutex_);
  while (of.over < ticket) {
    if (!of.running && !of.waiting.empty()) {
      RunNext(&of, &lock);
    } else {
      changed_.wait(lock);
    }
  }
  if (of.error) std::rethrow_exception(of.error);
}

void TaskLanes::Drain(int lane) {
  Wait(lane, lanes_[static_cast<size_t>(lane)].posted);  // only the caller's thread posts
}

void TaskLanes::Abandon() {
  std::unique_lock lock(mutex_);
  for (Lane& lane : lanes_) {
    lane.over += lane.waiting.size();
    lane.waiting.clear();
  }
  changed_.wait(lock, [this] {
    return std::none_of(lanes_.begin(), lanes_.end(), [](const Lane& lane) { return lane.running; });
  });
}

}  // namespace atlas::core
