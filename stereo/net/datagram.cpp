#include "stereo/net/datagram.h"

#include <arpa/inet.h>

#include <algorithm>
#include <string_view>

namespace farshade {

bool is_v4(const Peer& peer) {
  constexpr std::array<std::uint8_t, 12> kMapped{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
  return std::ranges::equal(kMapped, std::span(peer.address).first<12>());
}

bool is_unspecified(const Peer& peer) {
  const auto address = std::span(peer.address).subspan(is_v4(peer) ? 12 : 0);
  return std::ranges::all_of(address, [](std::uint8_t byte) { return byte == 0; });
}

bool is_of_one_network(const Peer& a, const Peer& b) {
  constexpr std::size_t kPrefix_bytes = 8;
  constexpr std::array<std::uint8_t, 12> kMapped{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
  const bool is_ipv4 = std::equal(kMapped.begin(), kMapped.end(), a.address.begin());
  return std::equal(a.address.begin(), is_ipv4 ? a.address.end() : a.address.begin() + kPrefix_bytes,
                    b.address.begin());
}

bool is_loopback(const Peer& peer) {
  constexpr std::array<std::uint8_t, 16> kLoopback{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  return is_v4(peer) ? peer.address[12] == 127 : peer.address == kLoopback;
}

std::string to_string(const Peer& peer) {
  const bool v4 = is_v4(peer);
  std::array<char, INET6_ADDRSTRLEN> text{};
  inet_ntop(v4 ? AF_INET : AF_INET6, peer.address.data() + (v4 ? 12 : 0), text.data(), text.size());
  const std::string host = v4 ? text.data() : "[" + std::string(text.data()) + "]";
  return host + ":" + std::to_string(peer.port);
}

}  // namespace farshade

std::size_t std::hash<farshade::Peer>::operator()(const farshade::Peer& peer) const noexcept {
  const auto* address = reinterpret_cast<const char*>(peer.address.data());
  const std::size_t ends = (std::size_t{peer.scope} << 16 | peer.port) * 0x9e3779b97f4a7c15u;
  return std::hash<std::string_view>{}({address, peer.address.size()}) ^ ends;
}
