/// What a server tells the local network about itself (DNS-SD, RFC 6763, over multicast DNS, RFC 6762), and
/// which of the servers that were found `--server auto` means.
/// Anybody on the network can announce anything, so an announcement only saves typing an address. The
/// handshake with the key decides afterwards whether it is the right server.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereo/base/expected.h"
#include "stereo/net/datagram.h"

namespace farshade {

inline constexpr const char* kServiceType = "_farshade._udp";

/// The strings of the TXT record: `txtvers=1`, and the versions of the protocol that the server speaks:
/// `protocol=N` is the oldest one, `newest=N` its own. They contain nothing about scene, keys or user.
[[nodiscard]] std::vector<std::string> announcement_txt();

/// This program's protocol version if a TXT record has it, otherwise its `protocol`; nothing if the record
/// has no sound one. As in RFC 6763, capitals do not count in keys, the first of several equal keys counts,
/// and unknown keys are skipped.
[[nodiscard]] std::optional<std::uint16_t> announced_protocol(std::span<const std::string> txt);

struct FoundServer {
  std::string name;  ///< as announced: may be any bytes, so print printable(name)
  Peer address;
  std::optional<std::uint16_t> protocol;  ///< nothing: not announced soundly
};

[[nodiscard]] bool is_link_local_v6(const Peer& peer);

/// An address that --server takes: `192.0.2.2:7447`, `[fe80::1%2]:7447`.
[[nodiscard]] std::string address_text(const Peer& address);

/// "'desk' at 192.0.2.2:7447"
[[nodiscard]] std::string in_words(const FoundServer& server);

/// Whether a value of --server is `auto` or `auto/NAME`.
[[nodiscard]] bool is_search(std::string_view server);

/// The server that `search`, an is_search, means. The announcements of one name are one server; of its
/// addresses IPv4 comes first and link-local IPv6 last. Without a name, servers of other protocol versions do
/// not count. Errors: Missing if there is none, Mismatch if all that fit speak another version, Unavailable
/// if several fit. Their sentences list what was found.
[[nodiscard]] Expected<FoundServer> choose_server(std::string_view search, std::vector<FoundServer> found);

}  // namespace farshade
