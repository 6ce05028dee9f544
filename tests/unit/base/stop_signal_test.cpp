#include "stereo/base/stop_signal.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <thread>

namespace farshade {
namespace {

class StopSignalTest : public testing::TestWithParam<int> {};

TEST_P(StopSignalTest, IsRememberedOnceItHasCome) {
  StopSignal stop;
  EXPECT_FALSE(stop.has_come());
  EXPECT_EQ(stop.exit_status(), 0);
  raise(GetParam());
  EXPECT_TRUE(stop.has_come());
  EXPECT_TRUE(stop.has_come());
  EXPECT_EQ(stop.exit_status(), GetParam() == SIGINT ? 130 : 143);
  stop.wait();
}

TEST_P(StopSignalTest, EndsAWait) {
  StopSignal stop;
  raise(GetParam());
  stop.wait();
  EXPECT_TRUE(stop.has_come());
  EXPECT_EQ(stop.exit_status(), GetParam() == SIGINT ? 130 : 143);
}

TEST_P(StopSignalTest, SecondOneEndsTheProgram) {
  EXPECT_EXIT(
      {
        StopSignal stop;
        raise(GetParam());
        if (!stop.has_come()) std::_Exit(1);
        raise(GetParam());
      },
      testing::KilledBySignal(GetParam()), "");
}

TEST_P(StopSignalTest, AReportRequestEndsNothing) {
  StopSignal stop;
  raise(SIGUSR1);
  EXPECT_FALSE(stop.has_come());
  int told = 0;
  stop.wait([&] { raise(++told < 3 ? SIGUSR1 : GetParam()); });
  EXPECT_EQ(told, 3);
  EXPECT_TRUE(stop.has_come());
}

TEST_P(StopSignalTest, EndsWorkThatNobodyPolls) {
  const auto work = [](StopSignal::Ending ending) {
    StopSignal stop;
    const StopSignal::EndsAtOnce working(stop, ending);
    kill(getpid(), GetParam());
    std::this_thread::sleep_for(std::chrono::seconds(200));
  };
  EXPECT_EXIT(work(StopSignal::Ending::Success), testing::ExitedWithCode(0), "");
  EXPECT_EXIT(work(StopSignal::Ending::BySignal), testing::ExitedWithCode(128 + GetParam()), "");
}

TEST_P(StopSignalTest, ComesToTheProgramAgainAfterSuchWork) {
  StopSignal stop;
  { const StopSignal::EndsAtOnce working(stop, StopSignal::Ending::Success); }
  raise(GetParam());
  EXPECT_TRUE(stop.has_come());
}

TEST_P(StopSignalTest, RequestsDoNotKeepItFromLooking) {
  StopSignal stop;
  int reports = 0;
  raise(SIGUSR1);
  stop.wait(
      [&] {
        ++reports;
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        raise(SIGUSR1);
      },
      [] {}, [&] { raise(GetParam()); });
  EXPECT_GT(reports, 2);
}

INSTANTIATE_TEST_SUITE_P(Signals, StopSignalTest, testing::Values(SIGINT, SIGTERM));

}  // namespace
}  // namespace farshade
