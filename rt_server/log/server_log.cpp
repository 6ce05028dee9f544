#include "rt_server/log/server_log.h"

#include <spdlog/async.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <future>
#include <thread>

#include "rt_server/log/log_sink.h"

namespace farshade {
namespace {

constexpr std::size_t kQueued = 8192;  ///< lines; of more, the oldest are dropped
constexpr auto kPatience = std::chrono::seconds(1);
constexpr const char* kOutput = "output";
std::weak_ptr<spdlog::details::thread_pool> the_writer;

}  // namespace

ServerLog::ServerLog() : writer_(std::make_shared<spdlog::details::thread_pool>(kQueued, 1)) {
  the_writer = writer_;
  const auto log_to = [&](const char* name, int file) {
    return std::make_shared<spdlog::async_logger>(name, std::make_shared<LogSink>(file), writer_,
                                                  spdlog::async_overflow_policy::overrun_oldest);
  };
  spdlog::set_default_logger(log_to("rt_server", STDERR_FILENO));
  const auto output = log_to(kOutput, STDOUT_FILENO);
  output->set_pattern("%v");
  spdlog::register_logger(output);
}

ServerLog::~ServerLog() {
  spdlog::drop_all();
  std::promise<void> written;
  const std::future<void> all = written.get_future();
  std::thread last([&] {
    writer_.reset();  // waits for its thread, which writes what is left
    written.set_value();
  });
  if (all.wait_for(kPatience) == std::future_status::timeout) std::_Exit(EXIT_FAILURE);
  last.join();
}

void flush_log() {
  constexpr auto kStep = std::chrono::milliseconds(10);
  const auto writer = the_writer.lock();
  for (auto left = kPatience / kStep; writer && left > 0 && writer->queue_size() > 0; --left)
    std::this_thread::sleep_for(kStep);
  std::this_thread::sleep_for(kStep);  // for the line that was taken from the queue last
}

void say(std::string_view line) {
  if (const auto output = spdlog::get(kOutput)) output->info(line);
}

}  // namespace farshade
