// Tasks beside the caller: order, priority, waiting, exceptions, and the same results without a thread.
#include "core/task_lanes.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <stdexcept>

namespace atlas::core {
namespace {

class TaskLanesBothWays : public ::testing::TestWithParam<bool> {};

TEST_P(TaskLanesBothWays, TasksOfALaneRunInTheirOrder) {
  TaskLanes lanes(2, GetParam());
  std::vector<int> order;  // only ever touched by tasks of lane 1
  for (int i = 0; i < 200; ++i) {
    lanes.Post(1, [&order, i] { order.push_back(i); });
  }
  lanes.Drain(1);
  ASSERT_EQ(order.size(), 200u);
  for (int i = 0; i < 200; ++i) EXPECT_EQ(order[static_cast<size_t>(i)], i);
}

TEST_P(TaskLanesBothWays, WaitingForATicketMeansThatAllBeforeItIsDone) {
  TaskLanes lanes(1, GetParam());
  int done = 0;
  TaskLanes::Ticket fifth = 0;
  for (int i = 1; i <= 5; ++i) fifth = lanes.Post(0, [&done] { ++done; });
  EXPECT_EQ(fifth, 5u);
  lanes.Wait(0, fifth);
  EXPECT_EQ(done, 5);
  lanes.Wait(0, 2);  // long over
}

TEST_P(TaskLanesBothWays, AnExceptionIsRethrownToWhoeverWaitsAndEndsItsLaneOnly) {
  TaskLanes lanes(2, GetParam());
  bool after = false, elsewhere = false;
  lanes.Post(0, [] { throw std::runtime_error("a task failed"); });
  lanes.Post(0, [&after] { after = true; });
  lanes.Post(1, [&elsewhere] { elsewhere = true; });
  EXPECT_THROW(lanes.Drain(0), std::runtime_error);
  EXPECT_THROW(lanes.Drain(0), std::runtime_error);
  lanes.Drain(1);
  EXPECT_FALSE(after);
  EXPECT_TRUE(elsewhere);
}

INSTANTIATE_TEST_SUITE_P(InlineAndThreaded, TaskLanesBothWays, ::testing::Bool());

TEST(TaskLanes, WithoutAThreadATaskIsOverWhenPostReturns) {
  TaskLanes lanes(1, false);
  bool done = false;
  lanes.Post(0, [&done] { done = true; });
  EXPECT_TRUE(done);
}

TEST(TaskLanes, TheLowestLaneOvertakesWhatWaits) {
  TaskLanes lanes(2, true);
  std::promise<void> started, release;
  std::atomic<int> slow_done = 0;
  lanes.Post(1, [&] {
    started.set_value();
    release.get_future().wait();
  });
  started.get_future().wait();
  int slow_before_urgent = -1;
  std::promise<void> urgent;
  for (int i = 0; i < 20; ++i) lanes.Post(1, [&] { ++slow_done; });
  lanes.Post(0, [&] {
    slow_before_urgent = slow_done;
    urgent.set_value();
  });
  release.set_value();
  urgent.get_future().wait();
  EXPECT_EQ(slow_before_urgent, 0);
  lanes.Drain(1);
  EXPECT_EQ(slow_done, 20);
}

TEST(TaskLanes, AWaitingCallerWorksWhereTheThreadIsBusyElsewhere) {
  TaskLanes lanes(2, true);
  std::promise<void> started, release;
  lanes.Post(1, [&] {
    started.set_value();
    release.get_future().wait();
  });
  started.get_future().wait();
  std::thread::id ran;
  lanes.Post(0, [&] { ran = std::this_thread::get_id(); });
  lanes.Drain(0);  // the background thread is held, so this returns only if the caller does the work
  EXPECT_EQ(ran, std::this_thread::get_id());
  release.set_value();
  lanes.Drain(1);
}

TEST(TaskLanes, AbandonedTasksNeverRun) {
  std::promise<void> started, release;
  std::atomic<int> ran = 0;
  {
    TaskLanes lanes(1, true);
    lanes.Post(0, [&] {
      started.set_value();
      release.get_future().wait();
      ++ran;
    });
    started.get_future().wait();
    lanes.Post(0, [&] { ran += 100; });
    auto ender = std::async(std::launch::async, [&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      release.set_value();
    });
    lanes.Abandon();
    ender.wait();
  }
  EXPECT_EQ(ran, 1);
}

}  // namespace
}  // namespace atlas::core
