/// Addresses of the user, of asio and of this project (Peer), for UDP and TCP alike. Only udp.cpp and tcp.cpp
/// include this file.
#pragma once

#include <algorithm>
#include <asio/io_context.hpp>
#include <asio/ip/basic_endpoint.hpp>
#include <asio/ip/basic_resolver.hpp>
#include <cerrno>
#include <charconv>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/base/check.h"
#include "stereo/base/expected.h"
#include "stereo/net/datagram.h"

namespace farshade {

template <class Protocol>
[[nodiscard]] Peer peer_of(const asio::ip::basic_endpoint<Protocol>& endpoint) {
  const asio::ip::address address = endpoint.address();
  const asio::ip::address_v6 wide =
      address.is_v4() ? asio::ip::make_address_v6(asio::ip::v4_mapped, address.to_v4()) : address.to_v6();
  return {wide.to_bytes(), narrow<std::uint32_t>(wide.scope_id()), endpoint.port()};
}

template <class Protocol>
[[nodiscard]] std::vector<Peer> peers_of(const std::vector<asio::ip::basic_endpoint<Protocol>>& endpoints) {
  std::vector<Peer> peers;
  for (const auto& endpoint : endpoints) peers.push_back(peer_of(endpoint));
  return peers;
}

/// `peer` as an endpoint of family `family`; the unspecified address if that family cannot reach it.
template <class Protocol>
[[nodiscard]] asio::ip::basic_endpoint<Protocol> endpoint_of(const Peer& peer, const Protocol& family) {
  const asio::ip::address_v6 wide(peer.address, peer.scope);
  if (family == Protocol::v6()) return {wide, peer.port};
  return {wide.is_v4_mapped() ? asio::ip::make_address_v4(asio::ip::v4_mapped, wide) : asio::ip::address_v4(),
          peer.port};
}

struct HostPort {
  std::string host, port;
};

/// Splits `name:port`, `name`, `[::1]:port`, `[::1]` or `::1`. Without a port the port is `without_port`.
/// Refuses (Malformed) a name of digits only, which is a forgotten host, and a bare IPv6 address that ends in
/// the digits of `without_port`, which probably lacks its brackets.
[[nodiscard]] inline Expected<HostPort> split_address(std::string_view address, std::uint16_t without_port) {
  std::string_view host = address;
  std::string port = std::to_string(without_port);
  const bool is_bare_v6 = std::ranges::count(address, ':') > 1 && !address.starts_with('[');
  const std::size_t colon = address.rfind(':');
  bool sound = !is_bare_v6 || !address.ends_with(":" + port);
  if (!is_bare_v6 && colon != address.npos && !address.ends_with(']')) {
    host = address.substr(0, colon);
    port = address.substr(colon + 1);
    std::uint16_t number = 0;
    const char* const end = port.data() + port.size();
    const auto [stop, error] = std::from_chars(port.data(), end, number);
    sound = error == std::errc{} && stop == end;
  }
  const bool bracketed = host.size() >= 2 && host.front() == '[' && host.back() == ']';
  if (bracketed) host = host.substr(1, host.size() - 2);
  sound &= host.find_first_not_of("0123456789") != host.npos && host.find_first_of("[]") == host.npos;
  if (bracketed || is_bare_v6) {
    asio::error_code no_address;
    asio::ip::make_address_v6(host, no_address);
    sound &= !no_address;
  }
  if (sound) return HostPort{std::string(host), port};
  return fail(Fault::Malformed,
              "'" + std::string(address) +
                  "' is no address: write HOST or HOST:PORT with a port up to 65535, IPv6 as "
                  "[::1] or [::1]:" +
                  std::to_string(without_port));
}

/// All addresses of a name, at least one, in the order in which the system prefers them.
template <class Protocol>
[[nodiscard]] Expected<std::vector<asio::ip::basic_endpoint<Protocol>>> resolve_all(
    asio::io_context& context, std::string_view address, std::uint16_t without_port = kDefaultPort) {
  const Expected<HostPort> parts = split_address(address, without_port);
  if (!parts) return tl::unexpected(parts.error());
  asio::error_code error;
  asio::ip::basic_resolver<Protocol> resolver(context);
  const auto found = resolver.resolve(parts->host, parts->port, error);
  if (!error && !found.empty()) {
    std::vector<asio::ip::basic_endpoint<Protocol>> endpoints;
    for (const auto& entry : found)
      if (std::ranges::find(endpoints, entry.endpoint()) == endpoints.end())
        endpoints.push_back(entry.endpoint());
    return endpoints;
  }
  const std::string cure = "give its IP address instead (hostname -I prints it on that machine)";
  return fail(Fault::Missing,
              error == asio::error::host_not_found_try_again
                  ? "no name server answers for the host '" + parts->host +
                        "': check this machine's network, or " + cure
                  : "no host named '" + parts->host + "' is known: check the spelling, or " + cure);
}

/// Whether a port of `all` receives what is sent to `one`, too, if their port numbers are equal.
[[nodiscard]] inline bool includes(const Peer& all, const Peer& one) {
  return all.address == one.address || (is_unspecified(all) && (is_v4(one) || !is_v4(all)));
}

/// Refuses (Malformed) two addresses of a server of which one includes the other, whatever their ports. A
/// datagram tells the address that it came to, but not the port: two sockets of one address could not be told
/// apart when it is answered.
[[nodiscard]] inline Expected<void> check_apart(const Peer& a, const Peer& b) {
  const bool a_first = includes(a, b);
  if (!a_first && !includes(b, a)) return {};
  const Peer &all = a_first ? a : b, &one = a_first ? b : a;
  return fail(Fault::Malformed,
              "cannot listen on both " + to_string(all) + " and " + to_string(one) + ": " +
                  (all.address == one.address ? "give each address once"
                                              : "the first includes the second, so leave out one of them"));
}

/// The addresses on which a server listens, in the order of `addresses`: of a name, the first one. Errors as
/// of resolve_all and check_apart.
template <class Protocol>
[[nodiscard]] Expected<std::vector<asio::ip::basic_endpoint<Protocol>>> resolve_own(
    asio::io_context& context, std::span<const std::string> addresses, std::uint16_t without_port) {
  check(!addresses.empty(), "a server listens on an address");
  std::vector<asio::ip::basic_endpoint<Protocol>> own;
  for (const std::string& address : addresses) {
    const auto found = resolve_all<Protocol>(context, address, without_port);
    if (!found) return tl::unexpected(found.error());
    for (const auto& other : own)
      if (auto apart = check_apart(peer_of(other), peer_of(found->front())); !apart)
        return tl::unexpected(apart.error());
    own.push_back(found->front());
  }
  return own;
}

/// Why a port cannot listen on `address`, with a cure. `protocol` is the end of the address's name.
[[nodiscard]] inline Error listen_error(const Peer& address, const char* protocol,
                                        const asio::error_code& error) {
  const std::string where = to_string(address) + protocol;
  if (error == asio::error::address_in_use)
    return {Fault::Unavailable, where +
                                    " is in use by another program: stop it, or choose another port (0 "
                                    "takes any free one)"};
  if (error.value() == EADDRNOTAVAIL)
    return {Fault::Missing, "cannot listen on " + where +
                                ": this machine does not have that address; hostname -I prints those that it "
                                "has, and 0.0.0.0 includes all of IPv4"};
  if (error == asio::error::address_family_not_supported)
    return {Fault::Missing,
            "cannot listen on " + where + ": this machine has no IPv6; give an address of IPv4"};
  return {error == asio::error::access_denied ? Fault::Unreadable : Fault::Missing,
          "cannot listen on " + where + ": " + error.message()};
}

}  // namespace farshade
