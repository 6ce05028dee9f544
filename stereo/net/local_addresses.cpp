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

std::optional<Peer> peer_of(const sockaddr* address, std::uint16_t port) {
  Peer peer{.port = port};
  if (address != nullptr && address->sa_family == AF_INET) {
    sockaddr_in v4;
    std::memcpy(&v4, address, sizeof v4);
    peer.address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
    std::memcpy(&peer.address[12], &v4.sin_addr, 4);
    return peer.address[12] == 169 && peer.address[13] == 254 ? std::nullopt
                                                              : std::optional(peer);  // RFC 3927
  }
  if (address != nullptr && address->sa_family == AF_INET6) {
    sockaddr_in6 v6;
    std::memcpy(&v6, address, sizeof v6);
    std::memcpy(peer.address.data(), &v6.sin6_addr, peer.address.size());
    if (!IN6_IS_ADDR_LINKLOCAL(&v6.sin6_addr)) return peer;
  }
  return std::nullopt;
}

}  // namespace

std::vector<Peer> local_addresses(std::uint16_t port) {
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(first, &freeifaddrs);
  std::vector<Peer> found;
  for (const ifaddrs* at = first; at != nullptr; at = at->ifa_next) {
    if ((at->ifa_flags & IFF_UP) == 0 || (at->ifa_flags & IFF_LOOPBACK) != 0) continue;
    if (const std::optional<Peer> peer = peer_of(at->ifa_addr, port)) found.push_back(*peer);
  }
  std::stable_partition(found.begin(), found.end(), is_v4);
  return found;
}

}  // namespace farshade
