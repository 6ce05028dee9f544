#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <thread>
#include <vector>

#include "stereo/net/tcp.h"
#include "stereo/net/udp.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
constexpr Duration kPatience = 60s;  // not reached if datagrams arrive

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> result;
  for (const int value : values) result.push_back(static_cast<std::byte>(value));
  return result;
}

struct Pair {
  std::unique_ptr<DatagramPort> server;
  UdpClient client;
};

Pair connected(const char* listen_address) {
  auto server = listen_udp(listen_address);
  EXPECT_TRUE(server.has_value()) << server.error().what;
  auto client = connect_udp(to_string((*server)->local()));
  EXPECT_TRUE(client.has_value()) << client.error().what;
  return {std::move(*server), std::move(*client)};
}

void expect_round_trip(Pair& pair) {
  std::array<std::byte, 1500> buffer;
  ASSERT_TRUE(pair.client.port->send(pair.client.server, bytes({1, 2, 3})));
  const auto request = pair.server->receive(buffer, kPatience);
  ASSERT_TRUE(request.has_value());
  EXPECT_TRUE(std::ranges::equal(request->bytes, bytes({1, 2, 3})));
  ASSERT_TRUE(pair.server->send(request->from, bytes({9, 8})));
  const auto answered = pair.client.port->receive(buffer, kPatience);
  ASSERT_TRUE(answered.has_value());
  EXPECT_EQ(answered->from, pair.client.server);
  EXPECT_TRUE(std::ranges::equal(answered->bytes, bytes({9, 8})));
}

/// The value of an option of the socket that is bound to `port`; nothing if there is none.
std::optional<int> option_of(std::uint16_t port, int family, int level, int option) {
  for (int file = 0; file < 1024; ++file) {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    if (getsockname(file, reinterpret_cast<sockaddr*>(&address), &size) != 0 || address.ss_family != family)
      continue;
    const std::uint16_t bound = family == AF_INET6 ? reinterpret_cast<const sockaddr_in6&>(address).sin6_port
                                                   : reinterpret_cast<const sockaddr_in&>(address).sin_port;
    int value = 0;
    socklen_t value_size = sizeof value;
    if (ntohs(bound) == port && getsockopt(file, level, option, &value, &value_size) == 0) return value;
  }
  return std::nullopt;
}

/// The kernel neither splits datagrams nor believes messages about sizes that anybody can forge.
TEST(Udp, SocketsIgnoreWhatIcmpSaysAboutSizes) {
  const Pair v4 = connected("127.0.0.1:0");
  for (const std::uint16_t port : {v4.server->local().port, v4.client.port->local().port})
    EXPECT_EQ(option_of(port, AF_INET, IPPROTO_IP, IP_MTU_DISCOVER), IP_PMTUDISC_PROBE);
  const auto v6 = listen_udp("[::1]:0");
  if (!v6) GTEST_SKIP() << "without IPv6: " << v6.error().what;
  EXPECT_EQ(option_of((*v6)->local().port, AF_INET6, IPPROTO_IPV6, IPV6_MTU_DISCOVER), IPV6_PMTUDISC_PROBE);
}

TEST(Peer, PrintsAsOneWritesIt) {
  const Peer v4{{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 127, 0, 0, 1}, 0, 7447};
  EXPECT_EQ(to_string(v4), "127.0.0.1:7447");
  EXPECT_EQ(to_string(Peer{{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, 0, 80}), "[::1]:80");
  Peer other_port = v4;
  other_port.port = 7448;
  EXPECT_NE(other_port, v4);
  EXPECT_NE(std::hash<Peer>{}(other_port), std::hash<Peer>{}(v4));
  Peer reached_elsewhere = v4;
  reached_elsewhere.via[15] = 1;
  EXPECT_EQ(reached_elsewhere, v4) << "an own address does not make it another peer";
}

TEST(Udp, CarriesBothWaysOverIPv4) {
  Pair pair = connected("127.0.0.1:0");
  EXPECT_NE(pair.server->local().port, 0);
  expect_round_trip(pair);
  EXPECT_EQ(pair.server->counters(),
            (PortCounters{.sent = 1, .sent_bytes = 2, .received = 1, .received_bytes = 3}));
}

TEST(Udp, CarriesBothWaysOverIPv6) {
  if (!listen_udp("[::1]:0")) GTEST_SKIP() << "this machine has no IPv6";
  Pair pair = connected("[::1]:0");
  expect_round_trip(pair);
}

/// All of 127.0.0.0/8 are addresses of this machine. Without a choice the system answers from 127.0.0.1.
TEST(Udp, AnswersFromTheAddressThatWasAsked) {
  for (const char* all : {"0.0.0.0:0", "[::]:0"}) {
    auto server = listen_udp(all);
    if (!server) continue;  // no IPv6
    const std::string port = std::to_string((*server)->local().port);
    auto first = connect_udp("127.0.0.2:" + port), second = connect_udp("127.0.0.77:" + port);
    ASSERT_TRUE(first.has_value() && second.has_value());
    std::array<std::byte, 1500> buffer;
    std::vector<Peer> from;
    for (UdpClient* client : {&*first, &*second}) {
      ASSERT_TRUE(client->port->send(client->server, bytes({1})));
      const auto request = (*server)->receive(buffer, kPatience);
      ASSERT_TRUE(request.has_value());
      from.push_back(request->from);
    }
    for (const Peer& to : from) ASSERT_TRUE((*server)->send(to, bytes({2})));
    EXPECT_TRUE(first->port->receive(buffer, kPatience).has_value()) << all;
    EXPECT_TRUE(second->port->receive(buffer, kPatience).has_value()) << all;
  }
}

/// A client of each address of a server that listens on several.
class SeveralAddresses : public testing::Test {
 protected:
  void SetUp() override {
    std::vector<std::string> addresses{"127.0.0.2:0", "127.0.0.77:0"};
    if (listen_udp("[::1]:0")) addresses.emplace_back("[::1]:0");
    auto listening = listen_udp(addresses);
    ASSERT_TRUE(listening.has_value()) << listening.error().what;
    server_ = *std::move(listening);
    ASSERT_EQ(server_.addresses.size(), addresses.size());
    for (const Peer& address : server_.addresses) clients_.push_back(connect_udp(address).value());
  }
  void ask(std::size_t client, int value) {
    ASSERT_TRUE(clients_[client].port->send(clients_[client].server, bytes({value})));
  }
  /// The sender of the next datagram, which must be `value`.
  Peer asker(int value) {
    const auto request = server_.port->receive(buffer_, kPatience);
    EXPECT_TRUE(request && std::ranges::equal(request->bytes, bytes({value}))) << value;
    return request ? request->from : Peer{};
  }

  UdpServer server_;
  std::vector<UdpClient> clients_;
  std::array<std::byte, 1500> buffer_;
};

TEST_F(SeveralAddresses, AreAllHeardAndAnswerEachFromItself) {
  EXPECT_EQ(server_.port->local(), server_.addresses.front());
  std::vector<Peer> from;
  for (std::size_t i = 0; i < clients_.size(); ++i) {
    ask(i, static_cast<int>(i));
    from.push_back(asker(static_cast<int>(i)));
  }
  for (const Peer& to : from) ASSERT_TRUE(server_.port->send(to, bytes({9})));
  for (std::size_t i = 0; i < clients_.size(); ++i) {
    EXPECT_TRUE(clients_[i].port->receive(buffer_, kPatience)) << to_string(server_.addresses[i]);
    EXPECT_EQ(clients_[i].port->counters().strangers, 0u);
  }
}

TEST_F(SeveralAddresses, ReachEachFamilyWithoutAChoice) {
  for (std::size_t i = 0; i < clients_.size(); ++i) {
    ask(i, 1);
    Peer to = asker(1);
    to.via = {};
    EXPECT_TRUE(server_.port->send(to, bytes({9}))) << to_string(to);
  }
}

TEST_F(SeveralAddresses, TakeTurnsDuringAFloodAtOne) {
  for (int i = 0; i < 50; ++i) ask(0, 1);
  ask(1, 2);  // loopback delivers in order: all of the flood has arrived
  int before = 0;
  for (auto next = server_.port->receive(buffer_, kPatience); next && next->bytes[0] == std::byte{1};
       next = server_.port->receive(buffer_, kPatience))
    ++before;
  EXPECT_LE(before, 2);
}

TEST_F(SeveralAddresses, AreWokenAsOne) {
  const Stopwatch waited;
  std::jthread waker([&] { server_.port->wake(); });
  EXPECT_FALSE(server_.port->receive(buffer_, kPatience).has_value());
  EXPECT_LT(waited.elapsed(), kPatience);
}

TEST_F(SeveralAddresses, NamesTheOneThatIsInUse) {
  const std::vector<std::string> addresses{"127.0.0.3:0", to_string(server_.addresses[1])};
  const auto second = listen_udp(addresses);
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().fault, Fault::Unavailable);
  EXPECT_NE(second.error().what.find(addresses[1] + " is in use"), std::string::npos) << second.error().what;
}

/// A datagram tells the address that it came to, but not the port.
TEST(Udp, RefusesAnAddressThatAnotherOneIncludes) {
  for (const auto& [first, second, words] :
       {std::tuple{"127.0.0.1:0", "127.0.0.1:7447", "127.0.0.1:0 and 127.0.0.1:7447: give each address once"},
        {"[::1]:0", "[::1]:0", "[::1]:0 and [::1]:0: give each address once"},
        {"127.0.0.1:0", "0.0.0.0:0", "0.0.0.0:0 and 127.0.0.1:0: the first includes the second"},
        {"[::]:0", "[::1]:0", "[::]:0 and [::1]:0: the first includes the second"},
        {"0.0.0.0:0", "[::]:0", "[::]:0 and 0.0.0.0:0: the first includes the second"}}) {
    const auto port = listen_udp(std::vector<std::string>{first, second});
    ASSERT_FALSE(port.has_value()) << first << " " << second;
    EXPECT_EQ(port.error().fault, Fault::Malformed);
    EXPECT_NE(port.error().what.find(words), std::string::npos) << port.error().what;
    const auto tcp = listen_tcp(std::vector<std::string>{first, second});
    ASSERT_FALSE(tcp.has_value()) << first << " " << second;
    EXPECT_EQ(tcp.error().what, port.error().what);
  }
  if (!listen_udp("[::1]:0")) GTEST_SKIP() << "this machine has no IPv6";
  EXPECT_TRUE(listen_udp(std::vector<std::string>{"0.0.0.0:0", "[::1]:0"}).has_value());
}

TEST(Tcp, AJoinedListenerAcceptsAtEachAddressInTurn) {
  const Waiting soon{SteadyClock().now() + kPatience};
  TcpServer server = listen_tcp(std::vector<std::string>{"127.0.0.2:0", "127.0.0.77:0"}).value();
  TcpListener& all = server.listener;
  const Peer first = server.addresses[0], second = server.addresses[1];
  EXPECT_EQ(all.local(), first);
  std::vector<TcpStream> streams;
  for (int i = 0; i < 5; ++i) streams.push_back(connect_tcp(first, soon).value());
  TcpStream late = connect_tcp(second, soon).value();
  ASSERT_TRUE(late.write(bytes({7}), soon));
  std::array<std::byte, 8> buffer;
  bool heard = false;
  for (int i = 0; i < 2; ++i) {
    auto accepted = all.accept(soon);
    ASSERT_TRUE(accepted.has_value());
    const Waiting poll{SteadyClock().now() + 100ms};
    heard |= accepted->read_some(buffer, poll).has_value();
    streams.push_back(*std::move(accepted));
  }
  EXPECT_TRUE(heard);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(all.accept(soon).has_value());
  EXPECT_FALSE(all.accept({SteadyClock().now() + 1ms}).has_value());
}

/// Sets the limit of open files to those that are open now, until it is destroyed.
class NoDescriptors {
 public:
  NoDescriptors() {
    getrlimit(RLIMIT_NOFILE, &before_);
    const int lowest_free = open("/dev/null", O_RDONLY);
    close(lowest_free);
    rlimit none = before_;
    none.rlim_cur = static_cast<rlim_t>(lowest_free);
    setrlimit(RLIMIT_NOFILE, &none);
  }
  NoDescriptors(const NoDescriptors&) = delete;
  NoDescriptors& operator=(const NoDescriptors&) = delete;
  ~NoDescriptors() { setrlimit(RLIMIT_NOFILE, &before_); }

 private:
  rlimit before_{};
};

TEST(Tcp, AListenerWithoutDescriptorsWaitsAndGoesOn) {
  auto listener = TcpListener::listen(resolve_tcp("127.0.0.2:0").value().front()).value();
  const auto stream = connect_tcp(listener.local(), {SteadyClock().now() + kPatience});
  ASSERT_TRUE(stream.has_value());
  {
    const NoDescriptors none;
    const auto cpu = [] { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
    const double before = cpu();
    EXPECT_FALSE(listener.accept({SteadyClock().now() + 500ms}).has_value());
    EXPECT_LT(cpu() - before, 0.2) << "it does not spin";
  }
  EXPECT_TRUE(listener.accept({SteadyClock().now() + kPatience}).has_value());
}

TEST(OneNetwork, IsAnAddressOfIPv4OrASixtyFourOfIPv6) {
  const auto peer = [](const char* address) { return resolve_udp(address).value().front(); };
  EXPECT_TRUE(is_of_one_network(peer("192.0.2.1:1"), peer("192.0.2.1:2")));
  EXPECT_FALSE(is_of_one_network(peer("192.0.2.1:1"), peer("192.0.2.2:1")));
  EXPECT_TRUE(is_of_one_network(peer("[2001:db8::1]:1"), peer("[2001:db8::ffff:0:1]:2")));
  EXPECT_FALSE(is_of_one_network(peer("[2001:db8::1]:1"), peer("[2001:db8:0:1::1]:1")));
  EXPECT_FALSE(is_of_one_network(peer("192.0.2.1:1"), peer("[2001:db8::1]:1")));
}

TEST(Tcp, ConnectsToTheFirstAddressThatAccepts) {
  auto listener = TcpListener::listen(resolve_tcp("127.0.0.2:0").value().front()).value();
  auto gone = TcpListener::listen(resolve_tcp("127.0.0.3:0").value().front());
  const Peer closed = gone->local();
  gone = fail(Fault::Missing, "closed");
  const Waiting soon{SteadyClock().now() + kPatience};
  const auto stream = connect_tcp(std::vector{closed, listener.local(), closed}, soon);
  ASSERT_TRUE(stream.has_value()) << stream.error().what;
  EXPECT_EQ(stream->peer(), listener.local());
  const auto none = connect_tcp(std::vector{closed, closed}, soon);
  ASSERT_FALSE(none.has_value());
  const std::string where = to_string(closed) + " (TCP): ";
  EXPECT_TRUE(none.error().what.starts_with(where)) << none.error().what;
  EXPECT_NE(none.error().what.find(", " + where), std::string::npos) << none.error().what;
}

/// A TCP port that drops whoever wants to connect, as a firewall does: its queue is full.
class SilentPort {
 public:
  SilentPort() {
    sockaddr_in here{};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof here;
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&here), size), 0);
    EXPECT_EQ(listen(socket_, 0), 0);
    EXPECT_EQ(getsockname(socket_, reinterpret_cast<sockaddr*>(&here), &size), 0);
    address_ = resolve_tcp("127.0.0.1:" + std::to_string(ntohs(here.sin_port))).value().front();
    while (auto queued = connect_tcp(address_, {SteadyClock().now() + 100ms}))
      queue_.push_back(*std::move(queued));
  }
  SilentPort(const SilentPort&) = delete;
  SilentPort& operator=(const SilentPort&) = delete;
  ~SilentPort() { close(socket_); }

  [[nodiscard]] const Peer& address() const { return address_; }

 private:
  int socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  Peer address_;
  std::vector<TcpStream> queue_;
};

TEST(Tcp, ASilentAddressLeavesTimeForTheNext) {
  const SilentPort silent;
  auto listener = TcpListener::listen(resolve_tcp("127.0.0.2:0").value().front()).value();
  const auto stream =
      connect_tcp(std::vector{silent.address(), listener.local()}, {SteadyClock().now() + 2s});
  ASSERT_TRUE(stream.has_value()) << stream.error().what;
  EXPECT_EQ(stream->peer(), listener.local());
}

TEST(Udp, IPv6SocketSpeaksIPv4) {
  auto server = listen_udp("[::]:0");
  if (!server) GTEST_SKIP() << "this machine has no IPv6";
  auto client = connect_udp("127.0.0.1:" + std::to_string((*server)->local().port));
  ASSERT_TRUE(client.has_value());
  Pair pair{std::move(*server), std::move(*client)};
  expect_round_trip(pair);
}

TEST(Udp, PortInUseIsOneClearSentence) {
  const auto first = listen_udp("127.0.0.1:0");
  ASSERT_TRUE(first.has_value());
  const std::string address = to_string((*first)->local());
  const auto second = listen_udp(address);
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error().fault, Fault::Unavailable);
  EXPECT_NE(second.error().what.find(address + " is in use"), std::string::npos) << second.error().what;
}

TEST(Udp, RefusesWhatIsNoAddress) {
  for (const char* address :
       {"", ":", "::1:7447", "7447", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:80x",
        ":7447", "[::1]:", "[::1]7447", "[]", "[]:7447", "[host]:7447", "::1::7"}) {
    const auto port = listen_udp(address);
    ASSERT_FALSE(port.has_value()) << address;
    EXPECT_EQ(port.error().fault, Fault::Malformed) << address;
    EXPECT_FALSE(connect_udp(address).has_value()) << address;
  }
}

TEST(Udp, AnAddressWithoutAPortHasTheDefaultPort) {
  for (const auto& [address, peer] : {std::pair{"192.0.2.2", "192.0.2.2:7447"},
                                      {"192.0.2.2:80", "192.0.2.2:80"},
                                      {"localhost", "127.0.0.1:7447"},
                                      {"[2001:db8::2]", "[2001:db8::2]:7447"},
                                      {"[2001:db8::2]:80", "[2001:db8::2]:80"},
                                      {"2001:db8::2", "[2001:db8::2]:7447"},
                                      {"::1", "[::1]:7447"}}) {
    const auto all = resolve_tcp(address);
    ASSERT_TRUE(all.has_value()) << all.error().what;
    const Peer found = all->front();
    if (std::string_view(address) == "localhost") {
      EXPECT_TRUE(is_loopback(found));
      EXPECT_EQ(found.port, kDefaultPort);
    } else {
      EXPECT_EQ(to_string(found), peer);
    }
  }
}

TEST(Udp, AHostThatDoesNotResolveIsOneSentenceWithACure) {
  for (const Expected<UdpClient>& client :
       {connect_udp("no-such-host.invalid"),
        connect_udp("no-such-host.invalid:80")}) {  // RFC 6761: never known
    ASSERT_FALSE(client.has_value());
    EXPECT_EQ(client.error().fault, Fault::Missing);
    const std::string& what = client.error().what;
    EXPECT_NE(what.find("host"), what.npos) << what;
    EXPECT_NE(what.find("'no-such-host.invalid'"), what.npos) << what;
    EXPECT_NE(what.find("give its IP address instead"), what.npos) << what;
  }
}

TEST(Udp, RefusesToTalkToNobody) {
  EXPECT_FALSE(connect_udp("127.0.0.1:0").has_value());
  EXPECT_FALSE(connect_udp("0.0.0.0:7447").has_value());
}

TEST(Udp, RefusesAnAddressOfAnotherMachine) {
  const auto port =
      listen_udp("192.0.2.1:0");  // an address of the documentation range (RFC 5737), which no machine has
  ASSERT_FALSE(port.has_value());
  EXPECT_EQ(port.error().fault, Fault::Missing);
  const auto tcp = listen_tcp(std::vector<std::string>{"127.0.0.1:0", "192.0.2.1:0"});
  ASSERT_FALSE(tcp.has_value());
  EXPECT_EQ(tcp.error().fault, Fault::Missing);
  for (const auto& [what, name] :
       {std::pair{port.error().what, "192.0.2.1:0: "}, {tcp.error().what, "192.0.2.1:0 (TCP): "}})
    EXPECT_NE(what.find(std::string("cannot listen on ") + name +
                        "this machine does not have that address; hostname -I prints"),
              what.npos)
        << what;
}

TEST(Udp, AbsentServerBreaksNothing) {
  auto server = listen_udp("127.0.0.1:0");
  ASSERT_TRUE(server.has_value());
  const std::string address = to_string((*server)->local());
  server->reset();  // now the kernel answers with ICMP port unreachable
  auto client = connect_udp(address);
  ASSERT_TRUE(client.has_value());
  std::array<std::byte, 1500> buffer;
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(client->port->send(client->server, bytes({1})));
    EXPECT_FALSE(client->port->receive(buffer, 1ms).has_value());
  }
  auto back = listen_udp(address);
  ASSERT_TRUE(back.has_value());
  Pair pair{std::move(*back), std::move(*client)};
  expect_round_trip(pair);
}

TEST(Udp, ClientReceivesOnlyFromItsServer) {
  Pair pair = connected("127.0.0.1:0");
  auto stranger = listen_udp("127.0.0.1:0");
  ASSERT_TRUE(stranger.has_value());
  std::array<std::byte, 1500> buffer;
  ASSERT_TRUE(pair.client.port->send(pair.client.server, bytes({1})));
  const auto from = pair.server->receive(buffer, kPatience);
  ASSERT_TRUE(from.has_value());
  ASSERT_TRUE((*stranger)->send(from->from, bytes({66})));
  ASSERT_TRUE(pair.server->send(from->from, bytes({7})));
  // Loopback delivers in order: the stranger's datagram is first, and a poll must still return the server's.
  const auto received = pair.client.port->receive(buffer, 0s);
  ASSERT_TRUE(received.has_value());
  EXPECT_TRUE(std::ranges::equal(received->bytes, bytes({7})));
  EXPECT_EQ(pair.client.port->counters().strangers, 1u);
}

TEST(Udp, DropsWhatIsLongerThanTheBuffer) {
  Pair pair = connected("127.0.0.1:0");
  std::array<std::byte, 4> small;
  ASSERT_TRUE(pair.client.port->send(pair.client.server, bytes({1, 2, 3, 4, 5})));
  ASSERT_TRUE(pair.client.port->send(pair.client.server, bytes({1, 2, 3, 4})));
  const auto got = pair.server->receive(small, kPatience);
  ASSERT_TRUE(got.has_value());
  EXPECT_EQ(got->bytes.size(), 4u);
  EXPECT_EQ(pair.server->counters().oversized, 1u);
}

TEST(Udp, SendToAnotherFamilyIsCountedNotSent) {
  Pair pair = connected("127.0.0.1:0");
  EXPECT_FALSE(pair.server->send(Peer{{0x20, 1, 0xd, 0xb8}, 0, 9}, bytes({1})));
  EXPECT_EQ(pair.server->counters().unsent, 1u);
}

TEST(Udp, WakeEndsTheWait) {
  Pair pair = connected("127.0.0.1:0");
  std::array<std::byte, 16> buffer;
  const Stopwatch waited;
  std::jthread waker([&] { pair.server->wake(); });
  EXPECT_FALSE(pair.server->receive(buffer, kPatience).has_value());
  EXPECT_LT(waited.elapsed(), kPatience);
}

TEST(Udp, TakesAWholeFrameAtOnce) {
  Pair pair = connected("127.0.0.1:0");
  std::array<std::byte, 1500> buffer;
  ASSERT_TRUE(pair.client.port->send(pair.client.server, bytes({1})));
  const Peer client = pair.server->receive(buffer, kPatience)->from;
  const std::vector<std::byte> slice(1200);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(pair.server->send(client, slice));
  int arrived = 0;
  while (pair.client.port->receive(buffer, 0s)) ++arrived;
  EXPECT_EQ(arrived, 100);
}

// On loopback a datagram has arrived when one sent after it has arrived. A new socket's kernel may at first
// take time stamps only at the read, so the test repeats until stamps are taken at arrival.
TEST(Udp, LateReaderSeesWhenADatagramCame) {
  Pair pair = connected("127.0.0.1:0");
  auto witness = listen_udp("127.0.0.1:0");
  ASSERT_TRUE(witness.has_value());
  const auto other = connect_udp(to_string((*witness)->local()));
  ASSERT_TRUE(other.has_value());
  const SteadyClock clock;
  std::array<std::byte, 1500> buffer;
  bool seen = false;
  for (const Stopwatch tried; !seen && tried.elapsed() < kPatience;) {
    const Time before = clock.now();
    ASSERT_TRUE(pair.client.port->send(pair.client.server, bytes({1})));
    ASSERT_TRUE(other->port->send(other->server, bytes({2})));
    ASSERT_TRUE((*witness)->receive(buffer, kPatience).has_value());
    const Time after = clock.now();
    const auto late = pair.server->receive(buffer, kPatience);
    ASSERT_TRUE(late.has_value());
    EXPECT_GE(late->arrived, before);
    EXPECT_LE(late->arrived, clock.now());
    seen = late->arrived <= after;
  }
  EXPECT_TRUE(seen);
}

}  // namespace
}  // namespace farshade
