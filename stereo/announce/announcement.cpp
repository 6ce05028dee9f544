#include "stereo/announce/announcement.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <iterator>
#include <tuple>

#include "stereo/base/printable.h"
#include "stereo/messages/messages.h"

namespace farshade {
namespace {

constexpr std::string_view kSearch = "auto", kProtocolKey = "protocol", kNewestKey = "newest";
constexpr std::size_t kMostListed = 8;

bool is_key(std::string_view given_key, std::string_view key) {
  return std::ranges::equal(given_key, key, [](char given, char lower) {
    return std::tolower(static_cast<unsigned char>(given)) == lower;
  });
}

/// The version with this key.
std::optional<std::uint16_t> version_of(std::span<const std::string> txt, std::string_view key) {
  for (const std::string& pair : txt) {
    const std::size_t equals = pair.find('=');
    if (!is_key(std::string_view(pair).substr(0, equals), key)) continue;
    if (equals == pair.npos) return std::nullopt;
    std::uint16_t version = 0;
    const char *const begin = pair.data() + equals + 1, *const end = pair.data() + pair.size();
    const auto [stop, error] = std::from_chars(begin, end, version);
    return error == std::errc{} && stop == end ? std::optional(version) : std::nullopt;
  }
  return std::nullopt;
}

int rank(const Peer& peer) {
  return is_v4(peer) ? 0 : is_link_local_v6(peer) ? 2 : 1;
}

/// One entry a name, with the best address, in order of the names.
std::vector<FoundServer> merged(std::vector<FoundServer> found) {
  std::ranges::sort(found, [](const FoundServer& a, const FoundServer& b) {
    return std::tuple(std::string_view(a.name), rank(a.address), a.address) <
           std::tuple(std::string_view(b.name), rank(b.address), b.address);
  });
  const auto same_name = [](const FoundServer& a, const FoundServer& b) { return a.name == b.name; };
  found.erase(std::unique(found.begin(), found.end(), same_name), found.end());
  return found;
}

std::string listed(const std::vector<FoundServer>& servers) {
  std::string text;
  for (std::size_t i = 0; i < std::min(servers.size(), kMostListed); ++i)
    text += (i == 0 ? "" : ", ") + in_words(servers[i]);
  if (servers.size() > kMostListed) text += " and " + std::to_string(servers.size() - kMostListed) + " more";
  return text;
}

bool speaks_ours(const FoundServer& server) {
  return server.protocol == kProtocolVersion;
}

Expected<FoundServer> missing(const std::string& name, const std::vector<FoundServer>& all) {
  if (!all.empty())
    return fail(Fault::Missing,
                "no server announces itself as '" + printable(name) + "', but there is " + listed(all));
  return fail(Fault::Missing,
              "no server announces itself on this network: start rt_server with --listen 0.0.0.0 and without "
              "--no-announce on a machine where avahi-daemon runs, let multicast DNS (UDP 5353) through the "
              "firewalls, or give --server ADDRESS");
}

}  // namespace

std::vector<std::string> announcement_txt() {
  return {"txtvers=1", std::string(kProtocolKey) + "=" + std::to_string(kPreviousVersion),
          std::string(kNewestKey) + "=" + std::to_string(kProtocolVersion)};
}

/// Clients of version 10 read `protocol` alone.
std::optional<std::uint16_t> announced_protocol(std::span<const std::string> txt) {
  const std::optional<std::uint16_t> newest = version_of(txt, kNewestKey);
  return newest == kProtocolVersion ? newest : version_of(txt, kProtocolKey);
}

bool is_link_local_v6(const Peer& peer) {
  return peer.address[0] == 0xfe && (peer.address[1] & 0xc0) == 0x80;
}

std::string address_text(const Peer& address) {
  std::string text = to_string(address);
  if (address.scope != 0) text.insert(text.rfind(']'), "%" + std::to_string(address.scope));
  return text;
}

std::string in_words(const FoundServer& server) {
  return "'" + printable(server.name) + "' at " + address_text(server.address);
}

bool is_search(std::string_view server) {
  return server == kSearch || (server.starts_with(kSearch) && server.substr(kSearch.size()).starts_with('/'));
}

Expected<FoundServer> choose_server(std::string_view search, std::vector<FoundServer> found) {
  const std::string name(search.substr(std::min(search.size(), kSearch.size() + 1)));
  const std::vector<FoundServer> all = merged(std::move(found));
  std::vector<FoundServer> fit;
  std::ranges::copy_if(all, std::back_inserter(fit), [&](const FoundServer& server) {
    return name.empty() || printable(server.name) == printable(name);
  });
  if (fit.empty()) return missing(name, all);
  std::vector<FoundServer> ours;
  std::ranges::copy_if(fit, std::back_inserter(ours), speaks_ours);
  if (ours.empty())
    return fail(Fault::Mismatch, "found " + listed(fit) + ", but not with version " +
                                     std::to_string(kProtocolVersion) +
                                     " of the protocol, which this client speaks: build client and server "
                                     "from the same source");
  if (ours.size() > 1)
    return fail(Fault::Unavailable, std::to_string(ours.size()) +
                                        " servers announce themselves: " + listed(ours) +
                                        "; choose one with --server auto/NAME or --server ADDRESS");
  return ours.front();
}

}  // namespace farshade
