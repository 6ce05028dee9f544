#include "stereo/net/tcp.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <asio/ip/tcp.hpp>
#include <asio/ip/v6_only.hpp>
#include <asio/write.hpp>
#include <iterator>
#include <thread>

#include "stereo/net/endpoints.h"

namespace farshade {

using asio::ip::tcp;

struct TcpStream::State {
  asio::io_context context;
  tcp::socket socket{context};
};

struct TcpListener::State {
  asio::io_context context;
  tcp::acceptor acceptor{context};
};

namespace {

/// Runs `context` until the operation on `socket` that was started has set `result`. Cancels it at the
/// deadline or when the caller wants to stop.
asio::error_code finish(asio::io_context& context, auto& socket,
                        const std::optional<asio::error_code>& result, const Waiting& waiting) {
  context.restart();
  while (!result) {
    const Time now = SteadyClock().now();
    const bool late = now >= waiting.until;
    if (late || (waiting.stopped && waiting.stopped())) {
      asio::error_code ignored;
      // A write that has done a part starts another one, which must be cancelled, too.
      while (!result) {
        socket.cancel(ignored);
        context.run_one_for(kStopPoll);
      }
      // It may have ended before it was cancelled.
      if (*result != asio::error::operation_aborted) return *result;
      return late ? asio::error::timed_out : asio::error::interrupted;
    }
    context.run_one_for(std::min(waiting.until - now, kStopPoll));
  }
  return *result;
}

tl::unexpected<Error> broken(const asio::error_code& error, const std::string& what) {
  const bool cut = error == asio::error::eof || error == asio::error::connection_reset ||
                   error == asio::error::broken_pipe;
  return fail(error == asio::error::interrupted ? Fault::Unavailable : Fault::Missing,
              what + (cut ? "the other side closed the connection" : error.message()));
}

}  // namespace

TcpStream::TcpStream(std::unique_ptr<State> state) : state_(std::move(state)) {}
TcpStream::TcpStream(TcpStream&&) noexcept = default;
TcpStream& TcpStream::operator=(TcpStream&&) noexcept = default;
TcpStream::~TcpStream() = default;

Peer TcpStream::peer() const {
  asio::error_code error;
  const tcp::endpoint endpoint = state_->socket.remote_endpoint(error);
  return error ? Peer{} : peer_of(endpoint);
}

Expected<std::size_t> TcpStream::read_some(std::span<std::byte> into, const Waiting& waiting) {
  std::optional<asio::error_code> result;
  std::size_t count = 0;
  state_->socket.async_read_some(asio::buffer(into.data(), into.size()),
                                 [&](const asio::error_code& error, std::size_t size) {
                                   result = error;
                                   count = size;
                                 });
  if (const asio::error_code error = finish(state_->context, state_->socket, result, waiting); error)
    return broken(error, "");
  return count;
}

Expected<void> TcpStream::write(std::span<const std::byte> bytes, const Waiting& waiting) {
  std::optional<asio::error_code> result;
  asio::async_write(state_->socket, asio::buffer(bytes.data(), bytes.size()),
                    [&](const asio::error_code& error, std::size_t) { result = error; });
  if (const asio::error_code error = finish(state_->context, state_->socket, result, waiting); error)
    return broken(error, "");
  return {};
}

void TcpStream::let_others_pass() {
  const int kCs1 = 0x20, kBulk = 2;  // TC_PRIO_BULK
  const int socket = state_->socket.native_handle();
  // Each fails without harm where the system does not know it.
  setsockopt(socket, IPPROTO_IP, IP_TOS, &kCs1, sizeof kCs1);
  setsockopt(socket, IPPROTO_IPV6, IPV6_TCLASS, &kCs1, sizeof kCs1);
  setsockopt(socket, SOL_SOCKET, SO_PRIORITY, &kBulk, sizeof kBulk);
}

Expected<std::vector<Peer>> resolve_tcp(std::string_view address, std::uint16_t without_port) {
  asio::io_context context;
  return resolve_all<tcp>(context, address, without_port).map(peers_of<tcp>);
}

Expected<TcpStream> connect_tcp(const Peer& server, const Waiting& waiting) {
  auto state = std::make_unique<TcpStream::State>();
  const asio::ip::address_v6 wide(server.address, server.scope);
  const tcp::endpoint endpoint = endpoint_of(server, wide.is_v4_mapped() ? tcp::v4() : tcp::v6());
  std::optional<asio::error_code> result;
  state->socket.async_connect(endpoint, [&](const asio::error_code& error) { result = error; });
  asio::error_code error = finish(state->context, state->socket, result, waiting);
  if (!error) state->socket.set_option(tcp::no_delay(true), error);
  if (error) return broken(error, to_string(server) + " (TCP): ");
  return TcpStream(std::move(state));
}

Expected<TcpStream> connect_tcp(std::span<const Peer> servers, const Waiting& waiting) {
  check(!servers.empty(), "a stream goes to an address");
  std::string failed;
  for (std::size_t left = servers.size(); true; --left) {
    const Time now = SteadyClock().now();
    const Duration share = (waiting.until - now) / static_cast<Duration::rep>(left);
    Expected<TcpStream> stream = connect_tcp(servers[servers.size() - left], {now + share, waiting.stopped});
    if (stream || left == 1 || (waiting.stopped && waiting.stopped())) {
      if (!stream) stream.error().what.insert(0, failed);
      return stream;
    }
    failed += stream.error().what + ", ";
  }
}

TcpListener::TcpListener(std::unique_ptr<State> state) {
  states_.push_back(std::move(state));
}
TcpListener::TcpListener(TcpListener&&) noexcept = default;
TcpListener& TcpListener::operator=(TcpListener&&) noexcept = default;
TcpListener::~TcpListener() = default;

Expected<TcpListener> TcpListener::listen(const Peer& address) {
  auto state = std::make_unique<State>();
  tcp::acceptor& acceptor = state->acceptor;
  const asio::ip::address_v6 wide(address.address, address.scope);
  const tcp::endpoint endpoint = endpoint_of(address, wide.is_v4_mapped() ? tcp::v4() : tcp::v6());
  asio::error_code error, ignored;
  acceptor.open(endpoint.protocol(), error);
  if (endpoint.protocol() == tcp::v6()) acceptor.set_option(asio::ip::v6_only(false), ignored);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.non_blocking(true, error);
  if (!error) acceptor.listen(tcp::acceptor::max_listen_connections, error);
  if (error) return tl::unexpected(listen_error(address, " (TCP)", error));
  return TcpListener(std::move(state));
}

void TcpListener::join(TcpListener other) {
  std::ranges::move(other.states_, std::back_inserter(states_));
}

Expected<TcpServer> listen_tcp(std::span<const std::string> addresses, std::uint16_t without_port) {
  asio::io_context context;
  const auto own = resolve_own<tcp>(context, addresses, without_port).map(peers_of<tcp>);
  if (!own) return tl::unexpected(own.error());
  std::optional<TcpListener> all;
  std::vector<Peer> locals;
  for (const Peer& address : *own) {
    Expected<TcpListener> listener = TcpListener::listen(address);
    if (!listener) return tl::unexpected(listener.error());
    locals.push_back(listener->local());
    if (all)
      all->join(*std::move(listener));
    else
      all.emplace(*std::move(listener));
  }
  return TcpServer{*std::move(all), std::move(locals)};
}

Peer TcpListener::local() const {
  asio::error_code error;
  return peer_of(states_.front()->acceptor.local_endpoint(error));
}

std::optional<TcpStream> TcpListener::accept(const Waiting& waiting) {
  std::vector<pollfd> watched;
  for (const auto& state : states_) watched.push_back({state->acceptor.native_handle(), POLLIN, 0});
  std::chrono::milliseconds wait{};
  while (true) {
    poll(watched.data(), watched.size(), static_cast<int>(wait.count()));
    bool failed = false;
    for (std::size_t tried = 0; tried < states_.size(); ++tried) {
      const std::size_t one = next_;
      next_ = (next_ + 1) % states_.size();
      if (watched[one].revents == 0) continue;
      try {
        auto stream = std::make_unique<TcpStream::State>();
        asio::error_code ignored;
        states_[one]->acceptor.accept(stream->socket);
        stream->socket.set_option(tcp::no_delay(true), ignored);
        return TcpStream(std::move(stream));
      } catch (const asio::system_error&) {  // no descriptor is left, or whoever connected has gone again
        failed = true;
      }
    }
    // What waits still waits, so another poll would return at once.
    if (failed) std::this_thread::sleep_for(kStopPoll);
    const Time now = SteadyClock().now();
    if (now >= waiting.until || (waiting.stopped && waiting.stopped())) return std::nullopt;
    wait = std::chrono::ceil<std::chrono::milliseconds>(std::min(waiting.until - now, kStopPoll));
  }
}

}  // namespace farshade
