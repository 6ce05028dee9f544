/// TcpProxy: a bad path for one TCP connection at a time. It limits the rate, delays what it passes, and cuts
/// the connection after a number of bytes.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

#include "stereo/net/tcp.h"

namespace farshade {

struct BadPath {
  double bytes_per_second = 1e9;  ///< from the server
  Duration delay{};               ///< from the server
  std::vector<std::uint64_t>
      cuts{};  ///< connection i is cut after this many bytes from the server; more are not cut
};

class TcpProxy {
 public:
  TcpProxy(const Peer& server, BadPath path);
  /// Ends the connection.
  ~TcpProxy();

  [[nodiscard]] Peer address() const { return listener_.local(); }
  [[nodiscard]] std::uint64_t passed_bytes() const {
    return passed_;
  }  ///< from the server, of all connections
  [[nodiscard]] std::size_t connections() const { return connections_; }

 private:
  void run(const std::stop_token& stop);
  void pass(TcpStream client, const std::stop_token& stop);

  Peer server_;
  BadPath path_;
  TcpListener listener_;
  std::atomic<std::uint64_t> passed_ = 0;
  std::atomic<std::size_t> connections_ = 0;
  std::jthread thread_;
};

}  // namespace farshade
