#include "rt_server/log/log_sink.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spdlog/logger.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

namespace farshade {
namespace {

class Log : public testing::Test {
 protected:
  Log() { EXPECT_EQ(pipe2(ends_.data(), O_CLOEXEC), 0); }
  ~Log() override {
    close(ends_[0]);
    close(ends_[1]);
  }
  std::string read_all() {
    std::string text(std::size_t{1} << 20, '\0');
    const ssize_t size = read(ends_[0], text.data(), text.size());
    text.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
    return text;
  }

  std::array<int, 2> ends_{};
};

TEST_F(Log, LinesAreWritten) {
  spdlog::logger log("server", std::make_shared<LogSink>(ends_[1]));
  log.info("welcomed ada");
  EXPECT_NE(read_all().find("welcomed ada\n"), std::string::npos);
}

TEST_F(Log, APipeThatNobodyReadsHoldsNobodyUp) {
  spdlog::logger log("server", std::make_shared<LogSink>(ends_[1]));
  alarm(200);  // ends the test if a line waits
  const std::string line(999, 'x');
  for (int i = 0; i < 1000; ++i) log.info(line);
  const std::string kept = read_all();
  EXPECT_GT(kept.size(), 10'000u);
  EXPECT_LT(kept.size(), 500'000u);
  EXPECT_EQ(kept.back(), '\n');
  log.info("the next one");
  const std::string next = read_all();
  const auto lines = std::count(kept.begin(), kept.end(), '\n');
  EXPECT_TRUE(next.starts_with(std::to_string(1000 - lines) + " lines of the log were dropped")) << next;
  EXPECT_NE(next.find("the next one\n"), std::string::npos);
  log.info("and another");
  EXPECT_EQ(read_all().find("dropped"), std::string::npos) << "they are told once";
  alarm(0);
}

/// A pipe that takes anything takes PIPE_BUF bytes, and a write of more waits.
TEST_F(Log, ALineThatIsLongerThanTheRoomInThePipeIsCutOff) {
  ASSERT_GT(fcntl(ends_[1], F_SETPIPE_SZ, 8192), 0);
  spdlog::logger log("server", std::make_shared<LogSink>(ends_[1]));
  alarm(200);
  log.info(std::string(100'000, 'x'));
  EXPECT_EQ(read_all().size(), 4096u);
  alarm(0);
}

TEST_F(Log, AClosedFileIsNoFault) {
  spdlog::logger log("server", std::make_shared<LogSink>(-1));
  log.info("nobody hears this");
}

}  // namespace
}  // namespace farshade
