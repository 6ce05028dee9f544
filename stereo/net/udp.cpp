#include "stereo/net/udp.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <asio/ip/udp.hpp>
#include <asio/ip/v6_only.hpp>
#include <atomic>
#include <cstring>
#include <ctime>

#include "stereo/base/check.h"
#include "stereo/messages/messages.h"
#include "stereo/net/arrival_clock.h"
#include "stereo/net/endpoints.h"

namespace farshade {
namespace {

using asio::ip::udp;
using Endpoint = udp::endpoint;

/// Most datagrams from strangers to drop in one call, so that a flood does not delay the caller for long.
constexpr int kMostDropsACall = 1024;

/// An event that poll() can wait for and any thread can raise.
class WakeEvent {
 public:
  WakeEvent() : fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    check(fd_ >= 0, "the system has a free descriptor");
  }
  WakeEvent(const WakeEvent&) = delete;
  WakeEvent& operator=(const WakeEvent&) = delete;
  ~WakeEvent() { close(fd_); }

  [[nodiscard]] int fd() const { return fd_; }
  void raise() { check(eventfd_write(fd_, 1) == 0, "a wake event can be raised"); }
  void clear() {
    eventfd_t ignored;
    static_cast<void>(eventfd_read(fd_, &ignored));
  }

 private:
  int fd_;
};

/// Room for the control messages of a datagram: a time stamp and an own address.
struct ControlBuffer {
  alignas(cmsghdr) std::array<std::byte, 128> bytes;
};

/// The first control message of a kind, copied; no value without one.
template <class Content>
std::optional<Content> control_message(msghdr& header, int level, int type) {
  for (const cmsghdr* part = CMSG_FIRSTHDR(&header); part != nullptr;
       part = CMSG_NXTHDR(&header, const_cast<cmsghdr*>(part))) {
    if (part->cmsg_level != level || part->cmsg_type != type) continue;
    Content content;
    std::memcpy(&content, CMSG_DATA(part), sizeof content);
    return content;
  }
  return std::nullopt;
}

/// Adds a control message to a header that has none yet.
template <class Content>
void set_control_message(msghdr& header, ControlBuffer& control, int level, int type,
                         const Content& content) {
  static_assert(CMSG_SPACE(sizeof content) <= sizeof control.bytes);
  control.bytes.fill(std::byte{0});
  header.msg_control = control.bytes.data();
  header.msg_controllen = CMSG_SPACE(sizeof content);
  cmsghdr* const part = CMSG_FIRSTHDR(&header);
  part->cmsg_level = level;
  part->cmsg_type = type;
  part->cmsg_len = CMSG_LEN(sizeof content);
  std::memcpy(CMSG_DATA(part), &content, sizeof content);
}

/// The own address that the datagram of `header` was sent to, as in Peer::via. RFC 3542, 6.1; ip(7).
std::array<std::uint8_t, 16> own_address_of(msghdr& header) {
  Peer own;
  if (const auto v6 = control_message<in6_pktinfo>(header, IPPROTO_IPV6, IPV6_PKTINFO)) {
    std::memcpy(own.address.data(), &v6->ipi6_addr, own.address.size());
  } else if (const auto v4 = control_message<in_pktinfo>(header, IPPROTO_IP, IP_PKTINFO)) {
    own.address[10] = own.address[11] = 0xff;
    std::memcpy(own.address.data() + 12, &v4->ipi_addr, 4);
  }
  return own.address;
}

/// Lets the datagram of `header` leave from the own address `to.via`.
void set_own_address(msghdr& header, ControlBuffer& control, const Peer& to, const udp& family) {
  if (to.via == decltype(to.via){}) return;
  if (family == udp::v6()) {
    in6_pktinfo own{};
    std::memcpy(&own.ipi6_addr, to.via.data(), to.via.size());
    own.ipi6_ifindex = to.scope;
    set_control_message(header, control, IPPROTO_IPV6, IPV6_PKTINFO, own);
  } else {
    in_pktinfo own{};
    std::memcpy(&own.ipi_spec_dst, to.via.data() + 12, 4);
    set_control_message(header, control, IPPROTO_IP, IP_PKTINFO, own);
  }
}

Duration duration_of(const timespec& time) {
  return std::chrono::seconds(time.tv_sec) + Duration(time.tv_nsec);
}

/// Reads the wall clock first: a pause between the two clocks can make an arrival later, but never earlier
/// than the event that caused it. Returns the steady clock's time.
Time read_clocks(ArrivalClock& clock) {
  timespec wall{};
  clock_gettime(CLOCK_REALTIME, &wall);
  const Time now = SteadyClock().now();
  clock.read(duration_of(wall), now);
  return now;
}

/// The arrival of the datagram of `header`. The kernel's time stamp is on the wall clock; without one, now.
Time arrival_of(msghdr& header, ArrivalClock& clock) {
  const Time now = read_clocks(clock);
  const auto stamp = control_message<timespec>(header, SOL_SOCKET, SCM_TIMESTAMPNS);
  return stamp ? clock.arrival(duration_of(*stamp)) : now;
}

struct Incoming {
  Endpoint from;
  std::array<std::uint8_t, 16> via{};  ///< as in Peer
  std::size_t size = 0;                ///< size of the datagram, also if the buffer is shorter
  Time arrived;
};

/// Takes the next datagram of `socket` and copies what fits into `into`. Returns nothing if there is none.
std::optional<Incoming> take_datagram(int socket, std::span<std::byte> into, ArrivalClock& clock) {
  Incoming incoming;
  iovec buffer{into.data(), into.size()};
  ControlBuffer control;
  msghdr header{};
  header.msg_name = incoming.from.data();
  header.msg_namelen = narrow<socklen_t>(incoming.from.capacity());
  header.msg_iov = &buffer;
  header.msg_iovlen = 1;
  header.msg_control = control.bytes.data();
  header.msg_controllen = control.bytes.size();
  // With MSG_TRUNC the kernel returns the full size of the datagram.
  const ssize_t size = recvmsg(socket, &header, MSG_TRUNC | MSG_DONTWAIT);
  if (size < 0) return std::nullopt;
  incoming.from.resize(header.msg_namelen);
  incoming.size = static_cast<std::size_t>(size);
  incoming.arrived = arrival_of(header, clock);
  incoming.via = own_address_of(header);
  return incoming;
}

/// Sends one datagram without blocking. False if the system does not take it.
bool put_datagram(int socket, const Peer& to, const udp& family, std::span<const std::byte> bytes) {
  Endpoint endpoint = endpoint_of(to, family);
  if (endpoint.address().is_unspecified()) return false;  // the family cannot reach it
  iovec buffer{const_cast<std::byte*>(bytes.data()), bytes.size()};
  ControlBuffer control;
  msghdr header{};
  header.msg_name = endpoint.data();
  header.msg_namelen = narrow<socklen_t>(endpoint.size());
  header.msg_iov = &buffer;
  header.msg_iovlen = 1;
  set_own_address(header, control, to, family);
  return sendmsg(socket, &header, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0;
}

/// A socket and the address that it listens on.
struct BoundSocket {
  udp::socket socket;
  udp family;
  Peer local;

  [[nodiscard]] int number() { return socket.native_handle(); }
  /// A socket of [::] speaks IPv4, too.
  [[nodiscard]] bool reaches(const Peer& to) const {
    return is_v4(to) == is_v4(local) || (is_unspecified(local) && family == udp::v6());
  }
};

class UdpPort final : public DatagramPort {
 public:
  /// No address of `sockets`, at least one, includes another one.
  UdpPort(std::unique_ptr<asio::io_context> context, std::vector<BoundSocket> sockets)
      : context_(std::move(context)), sockets_(std::move(sockets)) {
    for (BoundSocket& one : sockets_) watched_.push_back({one.number(), POLLIN, 0});
    watched_.push_back({wake_.fd(), POLLIN, 0});
    read_clocks(arrivals_);
  }

  /// Receives only from `peer` from now on.
  void talk_to(const Peer& peer) { partner_ = peer; }

  [[nodiscard]] Peer local() const override { return sockets_.front().local; }

  bool send(const Peer& to, std::span<const std::byte> bytes) override {
    check(bytes.size() <= kMaxDatagram_bytes, "a datagram fits kMaxDatagram_bytes");
    BoundSocket& from = socket_to(to);
    if (!put_datagram(from.number(), to, from.family, bytes)) {
      ++unsent_;
      return false;
    }
    ++sent_;
    sent_bytes_ += bytes.size();
    return true;
  }

  [[nodiscard]] std::optional<Datagram> receive(std::span<std::byte> into, Duration wait) override {
    const Stopwatch waited;
    for (int dropped = 0; dropped < kMostDropsACall;) {
      const std::optional<Incoming> incoming = take_next(into);
      if (!incoming) {
        if (!readable_within(wait - waited.elapsed())) break;
        continue;
      }
      Peer peer = peer_of(incoming->from);
      peer.via = incoming->via;
      if (!partner_ || peer == *partner_) {
        if (incoming->size <= into.size()) {
          ++received_;
          received_bytes_ += incoming->size;
          return Datagram{peer, into.first(incoming->size), incoming->arrived};
        }
        ++oversized_;
      } else {
        ++strangers_;
      }
      ++dropped;
    }
    return std::nullopt;
  }

  void wake() override { wake_.raise(); }

  [[nodiscard]] PortCounters counters() const override {
    return {sent_, sent_bytes_, received_, received_bytes_, unsent_, oversized_, strangers_};
  }

 private:
  /// The socket that listens on the address from which `to` is answered; otherwise the first that reaches it.
  BoundSocket& socket_to(const Peer& to) {
    auto found = std::ranges::find_if(sockets_, [&](const auto& one) { return one.local.address == to.via; });
    if (found == sockets_.end())
      found = std::ranges::find_if(sockets_, [&](const auto& one) { return one.reaches(to); });
    return found == sockets_.end() ? sockets_.front() : *found;
  }

  /// The sockets take turns, so that a flood at one does not silence the others.
  std::optional<Incoming> take_next(std::span<std::byte> into) {
    for (std::size_t tried = 0; tried < sockets_.size(); ++tried) {
      BoundSocket& one = sockets_[next_];
      next_ = (next_ + 1) % sockets_.size();
      if (auto incoming = take_datagram(one.number(), into, arrivals_)) return incoming;
    }
    return std::nullopt;
  }

  bool readable_within(Duration wait) {
    if (wait <= Duration::zero()) return false;
    const auto whole_s = std::chrono::duration_cast<std::chrono::seconds>(wait);
    const timespec timeout{whole_s.count(), (wait - whole_s).count()};
    const int ready = ppoll(watched_.data(), watched_.size(), &timeout, nullptr);
    if (ready > 0 && watched_.back().revents != 0) {
      wake_.clear();
      return false;
    }
    return ready != 0;  // after a signal (-1) the caller checks its deadline
  }

  std::unique_ptr<asio::io_context> context_;
  std::vector<BoundSocket> sockets_;
  std::optional<Peer> partner_;
  WakeEvent wake_;
  // Used by the thread that receives.
  ArrivalClock arrivals_;
  std::vector<pollfd> watched_;  ///< the sockets, then wake_
  std::size_t next_ = 0;         ///< socket to read first
  std::atomic<std::uint64_t> sent_ = 0, sent_bytes_ = 0, received_ = 0, received_bytes_ = 0;
  std::atomic<std::uint64_t> unsent_ = 0, oversized_ = 0, strangers_ = 0;
};

Expected<BoundSocket> bound_socket(asio::io_context& context, const Endpoint& endpoint) {
  udp::socket socket(context);
  asio::error_code error;
  socket.open(endpoint.protocol(), error);
  asio::error_code ignored;  // a smaller buffer, or an IPv6 socket without IPv4, is acceptable
  if (endpoint.protocol() == udp::v6()) socket.set_option(asio::ip::v6_only(false), ignored);
  socket.set_option(asio::socket_base::receive_buffer_size(kSocketBuffer_bytes), ignored);
  socket.set_option(asio::socket_base::send_buffer_size(kSocketBuffer_bytes), ignored);
  const int on = 1;  // if this fails, the arrival is the time of reading
  setsockopt(socket.native_handle(), SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
  // A server with several addresses answers from the one that was asked. A socket of IPv6 takes both options.
  setsockopt(socket.native_handle(), IPPROTO_IP, IP_PKTINFO, &on, sizeof on);
  if (endpoint.protocol() == udp::v6())
    setsockopt(socket.native_handle(), IPPROTO_IPV6, IPV6_RECVPKTINFO, &on, sizeof on);
  // The kernel splits no datagram and believes no ICMP message about sizes (PathMtu).
  const int v4_whole = IP_PMTUDISC_PROBE, v6_whole = IPV6_PMTUDISC_PROBE;
  setsockopt(socket.native_handle(), IPPROTO_IP, IP_MTU_DISCOVER, &v4_whole, sizeof v4_whole);
  if (endpoint.protocol() == udp::v6())
    setsockopt(socket.native_handle(), IPPROTO_IPV6, IPV6_MTU_DISCOVER, &v6_whole, sizeof v6_whole);
  if (!error) socket.non_blocking(true, error);
  if (!error) socket.bind(endpoint, error);
  const Endpoint local = error ? endpoint : socket.local_endpoint(error);
  if (error) return tl::unexpected(listen_error(peer_of(endpoint), "", error));
  return BoundSocket{std::move(socket), local.protocol(), peer_of(local)};
}

}  // namespace

Expected<UdpServer> listen_udp(std::span<const std::string> addresses) {
  auto context = std::make_unique<asio::io_context>();
  const auto endpoints = resolve_own<udp>(*context, addresses, kDefaultPort);
  if (!endpoints) return tl::unexpected(endpoints.error());
  std::vector<BoundSocket> sockets;
  std::vector<Peer> locals;
  for (const Endpoint& endpoint : *endpoints) {
    Expected<BoundSocket> bound = bound_socket(*context, endpoint);
    if (!bound) return tl::unexpected(bound.error());
    locals.push_back(bound->local);
    sockets.push_back(*std::move(bound));
  }
  return UdpServer{std::make_unique<UdpPort>(std::move(context), std::move(sockets)), std::move(locals)};
}

Expected<std::unique_ptr<DatagramPort>> listen_udp(std::string_view address) {
  const std::string one(address);
  return listen_udp(std::span(&one, 1)).map([](UdpServer&& server) { return std::move(server.port); });
}

Expected<std::vector<Peer>> resolve_udp(std::string_view address) {
  asio::io_context context;
  const auto endpoints = resolve_all<udp>(context, address);
  if (!endpoints) return tl::unexpected(endpoints.error());
  std::vector<Peer> peers;
  for (const Endpoint& endpoint : *endpoints) {
    if (endpoint.port() == 0 || endpoint.address().is_unspecified())
      return fail(Fault::Malformed,
                  "'" + std::string(address) + "' is no address to talk to: name a host and its port");
    peers.push_back(peer_of(endpoint));
  }
  return peers;
}

Expected<UdpClient> connect_udp(const Peer& server) {
  const udp family = is_v4(server) ? udp::v4() : udp::v6();
  auto context = std::make_unique<asio::io_context>();
  Expected<BoundSocket> bound = bound_socket(*context, Endpoint(family, 0));
  if (!bound) return tl::unexpected(bound.error());
  std::vector<BoundSocket> sockets;
  sockets.push_back(*std::move(bound));
  auto port = std::make_unique<UdpPort>(std::move(context), std::move(sockets));
  port->talk_to(server);
  return UdpClient{std::move(port), server};
}

Expected<UdpClient> connect_udp(std::string_view address) {
  return resolve_udp(address).and_then([](const std::vector<Peer>& all) { return connect_udp(all.front()); });
}

}  // namespace farshade
