#include "tests/support/tcp_proxy.h"

#include <algorithm>
#include <deque>

namespace farshade {
namespace {

constexpr Duration kTick = std::chrono::milliseconds(1);
constexpr std::size_t kQueue_bytes = 1 << 20;  ///< of the bottleneck

Peer any_port() {
  return {{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 127, 0, 0, 1}, 0, 0};
}

struct Delayed {
  Time due;
  std::vector<std::byte> bytes;
};

/// Reads what has come, without waiting long. False at the end of the stream.
bool read_now(TcpStream& from, std::vector<std::byte>& into, std::size_t most, bool& closed) {
  into.resize(most);
  const Time until = SteadyClock().now() + kTick;
  const Expected<std::size_t> got = from.read_some(into, {until, {}});
  into.resize(got.value_or(0));
  closed = !got && SteadyClock().now() < until;
  return got.has_value();
}

}  // namespace

TcpProxy::TcpProxy(const Peer& server, BadPath path)
    : server_(server),
      path_(std::move(path)),
      listener_(TcpListener::listen(any_port()).value()),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

TcpProxy::~TcpProxy() {
  thread_.request_stop();
  thread_.join();
}

void TcpProxy::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    auto client = listener_.accept({SteadyClock().now() + std::chrono::milliseconds(50), {}});
    if (client) pass(*std::move(client), stop);
  }
}

void TcpProxy::pass(TcpStream client, const std::stop_token& stop) {
  const std::size_t index = connections_++;
  std::uint64_t left = index < path_.cuts.size() ? path_.cuts[index] : UINT64_MAX;
  const Waiting soon{SteadyClock().now() + std::chrono::seconds(600), [&] { return stop.stop_requested(); }};
  Expected<TcpStream> server = connect_tcp(server_, soon);
  std::deque<Delayed> queue;
  std::size_t queued = 0;
  Time free_at = SteadyClock().now();
  std::vector<std::byte> bytes;
  bool closed = !server, server_closed = false;
  while (!closed && !stop.stop_requested() && !(server_closed && queue.empty()) && left > 0) {
    if (read_now(client, bytes, 4096, closed) && !server->write(bytes, soon)) return;
    const Time now = SteadyClock().now();
    while (!server_closed && queued < kQueue_bytes && read_now(*server, bytes, 65536, server_closed)) {
      free_at = std::max(free_at, now) +
                duration_from_ms(static_cast<double>(bytes.size()) / path_.bytes_per_second * 1e3);
      queued += bytes.size();
      queue.push_back({free_at + path_.delay, bytes});
    }
    while (!queue.empty() && queue.front().due <= SteadyClock().now() && left > 0) {
      const auto size = std::min<std::uint64_t>(queue.front().bytes.size(), left);
      if (!client.write(std::span(queue.front().bytes).first(size), soon)) return;
      passed_ += size;
      left -= size;
      queued -= queue.front().bytes.size();
      queue.pop_front();
    }
  }
}

}  // namespace farshade
