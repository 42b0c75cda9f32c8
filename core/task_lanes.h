// Work that goes on beside the caller: lanes of tasks on one background thread.
//
// Tasks of one lane run one after another in the order they were posted; lanes know nothing of each other, so
// tasks of different lanes share no data. The background thread takes from the lowest lane that has work:
// lane 0 overtakes the rest between two tasks, never within one. Without a thread every task runs inside
// Post(), and since a lane's order is the same either way, so are the results.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace atlas::core {

class TaskLanes {
 public:
  using Task = std::function<void()>;
  /// Names a task within its lane: the number of tasks posted up to and with it.
  using Ticket = uint64_t;

  /// @param threaded  false: tasks run inside Post(). @pre lanes >= 1
  TaskLanes(int lanes, bool threaded);
  /// Ends the task that runs, drops those that wait.
  ~TaskLanes();
  TaskLanes(const TaskLanes&) = delete;
  TaskLanes& operator=(const TaskLanes&) = delete;

  /// @pre lane < lanes; called from one thread, which is not a task's.
  Ticket Post(int lane, Task task);
  /// Until this task and those before it in the lane are over; the caller takes a hand in the lane where the
  /// background thread is busy elsewhere. Rethrows the first exception of the lane's tasks, after which none
  /// of its tasks runs any more.
  void Wait(int lane, Ticket ticket);
  /// Waits for all that was posted to the lane.
  void Drain(int lane);
  /// Ends the tasks that run and drops those that wait, in all lanes; swallows their exceptions.
  void Abandon();

 private:
  struct Lane {
    std::deque<Task> waiting;
    bool running = false;
    Ticket posted = 0, over = 0;
    std::exception_ptr error;
  };

  void Work();
  /// Runs the lane's next task. @pre the lock is held, one waits and none runs; held again on return.
  void RunNext(Lane* lane, std::unique_lock<std::mutex>* lock);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Lane> lanes_;
  bool threaded_, ending_ = false;
  std::thread thread_;
};

}  // namespace atlas::core
