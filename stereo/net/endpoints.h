/// Addresses of the user, of asio and of this project (Peer), for UDP and TCP alike. Only udp.cpp and tcp.cpp
/// include this file.
#pragma once

#include <asio/io_context.hpp>
#include <asio/ip/basic_endpoint.hpp>
#include <asio/ip/basic_resolver.hpp>
#include <charconv>
#include <string>
#include <string_view>

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

/// Splits `name:port` or `[::1]:port`.
[[nodiscard]] inline Expected<HostPort> split_address(std::string_view address) {
  const std::size_t colon = address.rfind(':');
  std::string_view host = address.substr(0, colon);
  const std::string_view port = colon == address.npos ? "" : address.substr(colon + 1);
  std::uint16_t number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  const bool bracketed = host.size() >= 2 && host.front() == '[' && host.back() == ']';
  if (bracketed) host = host.substr(1, host.size() - 2);
  const bool sound = !host.empty() && (bracketed || host.find(':') == host.npos);
  if (!sound || error != std::errc{} || end != port.data() + port.size())
    return fail(Fault::Malformed,
                "'" + std::string(address) +
                    "' is no address: write HOST:PORT with a port up to 65535, IPv6 as [::1]:7447");
  return HostPort{std::string(host), std::string(port)};
}

template <class Protocol>
[[nodiscard]] Expected<asio::ip::basic_endpoint<Protocol>> resolve_address(asio::io_context& context,
                                                                           std::string_view address) {
  const Expected<HostPort> parts = split_address(address);
  if (!parts) return tl::unexpected(parts.error());
  asio::error_code error;
  asio::ip::basic_resolver<Protocol> resolver(context);
  const auto found = resolver.resolve(parts->host, parts->port, error);
  if (error || found.empty())
    return fail(Fault::Missing, "no host '" + parts->host + "' is known (" + error.message() + ")");
  return found.begin()->endpoint();
}

}  // namespace farshade
