#include "stereo/net/local_addresses.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>

namespace farshade {
namespace {

using Interfaces = std::unique_ptr<ifaddrs, decltype(&freeifaddrs)>;

Interfaces interfaces() {
  ifaddrs* first = nullptr;
  return {getifaddrs(&first) == 0 ? first : nullptr, &freeifaddrs};
}

std::optional<Peer> peer_of(const sockaddr* address, std::uint16_t port) {
  Peer peer{.port = port};
  if (address != nullptr && address->sa_family == AF_INET) {
    sockaddr_in v4;
    std::memcpy(&v4, address, sizeof v4);
    peer.address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
    std::memcpy(&peer.address[12], &v4.sin_addr, 4);
    return peer;
  }
  if (address != nullptr && address->sa_family == AF_INET6) {
    sockaddr_in6 v6;
    std::memcpy(&v6, address, sizeof v6);
    std::memcpy(peer.address.data(), &v6.sin6_addr, peer.address.size());
    return peer;
  }
  return std::nullopt;
}

/// RFC 3927 and RFC 4291.
bool is_link_local(const Peer& peer) {
  const auto& bytes = peer.address;
  return is_v4(peer) ? bytes[12] == 169 && bytes[13] == 254 : bytes[0] == 0xfe && (bytes[1] & 0xc0) == 0x80;
}

}  // namespace

std::vector<Peer> local_addresses(std::uint16_t port) {
  const Interfaces all = interfaces();
  std::vector<Peer> found;
  for (const ifaddrs* at = all.get(); at != nullptr; at = at->ifa_next) {
    if ((at->ifa_flags & IFF_UP) == 0 || (at->ifa_flags & IFF_LOOPBACK) != 0) continue;
    const std::optional<Peer> peer = peer_of(at->ifa_addr, port);
    if (peer && !is_link_local(*peer)) found.push_back(*peer);
  }
  std::stable_partition(found.begin(), found.end(), is_v4);
  return found;
}

std::uint32_t interface_of(const Peer& peer) {
  const Interfaces all = interfaces();
  for (const ifaddrs* at = all.get(); at != nullptr; at = at->ifa_next) {
    const std::optional<Peer> found = peer_of(at->ifa_addr, peer.port);
    if (found && found->address == peer.address) return if_nametoindex(at->ifa_name);
  }
  return 0;
}

}  // namespace farshade
