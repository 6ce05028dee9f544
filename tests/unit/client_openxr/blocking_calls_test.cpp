#include "vr_client/openxr/blocking_calls.h"

#include <gtest/gtest.h>

#include <future>

namespace farshade::openxr {
namespace {

TEST(BlockingCalls, RunsEachCallOnItsOwnThreadAndWaitsForIt) {
  BlockingCalls calls;
  for (int call = 0; call < 100; ++call) {
    std::thread::id thread;
    ASSERT_TRUE(calls.run([&] { thread = std::this_thread::get_id(); }, [] { return true; }));
    EXPECT_NE(thread, std::this_thread::get_id());
  }
}

TEST(BlockingCalls, AsksWhileACallBlocks) {
  BlockingCalls calls;
  std::promise<void> opened;
  int requested = 0;
  EXPECT_TRUE(calls.run([&] { opened.get_future().wait(); },
                        [&] {
                          if (++requested == 2) opened.set_value();
                          return true;
                        }));
  EXPECT_GE(requested, 2);
}

TEST(BlockingCalls, LeavesACallThatBlocks) {
  const auto opened = std::make_shared<std::promise<void>>(), ended = std::make_shared<std::promise<void>>();
  {
    BlockingCalls calls;
    EXPECT_FALSE(calls.run(
        [opened, ended] {
          opened->get_future().wait();
          ended->set_value();
        },
        [] { return false; }));
  }  // does not wait for the call
  opened->set_value();
  ended->get_future().wait();
}

}  // namespace
}  // namespace farshade::openxr
