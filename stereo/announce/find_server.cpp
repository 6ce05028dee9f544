#include "stereo/announce/find_server.h"

#include <avahi-client/lookup.h>
#include <avahi-common/strlst.h>

#include <algorithm>
#include <cstring>

#include "stereo/announce/avahi.h"

namespace farshade {
namespace {

Peer peer_of(const AvahiAddress& address, AvahiIfIndex interface, std::uint16_t port) {
  Peer peer{.port = port};
  if (address.proto == AVAHI_PROTO_INET) {
    peer.address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
    std::memcpy(&peer.address[12], &address.data.ipv4.address, 4);
    return peer;
  }
  std::memcpy(peer.address.data(), address.data.ipv6.address, peer.address.size());
  if (is_link_local_v6(peer)) peer.scope = static_cast<std::uint32_t>(interface);
  return peer;
}

std::vector<std::string> strings_of(AvahiStringList* list) {
  std::vector<std::string> strings;
  for (; list != nullptr; list = avahi_string_list_get_next(list))
    strings.emplace_back(reinterpret_cast<const char*>(avahi_string_list_get_text(list)),
                         avahi_string_list_get_size(list));
  std::ranges::reverse(strings);  // Avahi's lists begin with the last string
  return strings;
}

/// What one search has found and still waits for.
struct Search {
  AvahiClient* client = nullptr;
  std::vector<FoundServer> found{};
  std::size_t asked = 0,
              open = 0;  ///< announcements whose address was asked for, and those without an answer
  bool all_named = false, failed = false;

  [[nodiscard]] bool is_over() const { return failed || (all_named && open == 0 && !found.empty()); }

  static void client_changed(AvahiClient*, AvahiClientState state, void* self) {
    if (state == AVAHI_CLIENT_FAILURE) static_cast<Search*>(self)->failed = true;
  }

  static void named(AvahiServiceBrowser*, AvahiIfIndex interface, AvahiProtocol protocol,
                    AvahiBrowserEvent event, const char* name, const char* type, const char* domain,
                    AvahiLookupResultFlags, void* self) {
    Search& search = *static_cast<Search*>(self);
    if (event == AVAHI_BROWSER_FAILURE) search.failed = true;
    if (event == AVAHI_BROWSER_ALL_FOR_NOW) search.all_named = true;
    if (event != AVAHI_BROWSER_NEW || search.asked >= kMostAnnouncements) return;
    // A server that listens on IPv4 only is announced with IPv4, but its machine may have addresses of IPv6.
    const bool asks = avahi_service_resolver_new(search.client, interface, protocol, name, type, domain,
                                                 protocol, {}, &Search::resolved, &search) != nullptr;
    search.asked += asks;
    search.open += asks;
  }

  static void resolved(AvahiServiceResolver* resolver, AvahiIfIndex interface, AvahiProtocol,
                       AvahiResolverEvent event, const char* name, const char*, const char*, const char*,
                       const AvahiAddress* address, std::uint16_t port, AvahiStringList* txt,
                       AvahiLookupResultFlags, void* self) {
    Search& search = *static_cast<Search*>(self);
    --search.open;
    if (event == AVAHI_RESOLVER_FOUND)
      search.found.push_back({name, peer_of(*address, interface, port), announced_protocol(strings_of(txt))});
    avahi_service_resolver_free(resolver);
  }
};

}  // namespace

Expected<FoundServer> find_server(std::string_view search_for) {
  const auto no_daemon = [] {
    return fail(Fault::Unavailable,
                "--server auto needs avahi-daemon, which does not run on this machine: install it (sudo apt "
                "install avahi-daemon), or give --server ADDRESS");
  };
  const SteadyClock clock;
  const Time end = clock.now() + kSearchTime;
  const avahi::SimplePoll poll(avahi_simple_poll_new());
  Search search;
  const avahi::Client client(
      avahi_client_new(avahi_simple_poll_get(poll.get()), {}, &Search::client_changed, &search, nullptr));
  if (!client) return no_daemon();
  search.client = client.get();
  // The client frees the browser and the resolvers.
  if (avahi_service_browser_new(client.get(), AVAHI_IF_UNSPEC, AVAHI_PROTO_UNSPEC, kServiceType, nullptr, {},
                                &Search::named, &search) == nullptr)
    return no_daemon();
  while (!search.is_over() && clock.now() < end) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - clock.now()).count();
    if (avahi_simple_poll_iterate(poll.get(), static_cast<int>(left)) != 0) break;
  }
  if (search.failed) return no_daemon();
  return choose_server(search_for, std::move(search.found));
}

}  // namespace farshade
