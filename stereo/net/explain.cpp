#include "stereo/net/explain.h"

#include <cstdio>
#include <span>

#include "stereo/sealing/handshake.h"

namespace farshade {
namespace {

std::string first_digits(std::span<const std::uint8_t> bytes) {
  std::array<char, 9> text{};
  std::snprintf(text.data(), text.size(), "%02x%02x%02x%02x", bytes[0], bytes[1], bytes[2], bytes[3]);
  return text.data();
}

}  // namespace

std::string short_form(const ContentHash& hash) {
  return first_digits(hash);
}

std::string short_form(const KeyId& id) {
  return first_digits(id);
}

Explanation explain(const Refusal& refusal, const ContentHash& scene_hash) {
  if (refusal.reason == RefusalReason::Busy)
    return {"the server has no room for another client", "try again later, or start it with more --sessions"};
  return {
      "the server serves scene " + short_form(refusal.scene_hash) + ", the client shows scene " +
          short_form(scene_hash),
      "start the client again without --scene, so that it fetches the server's, or give both the same scene "
      "file"};
}

Explanation explain(const OpenRefusal& refusal, const SharedKey& key, const Peer& server) {
  if (refusal.reason == RefusalReason::VersionMismatch)
    return {"the server speaks protocol version " + std::to_string(refusal.version) + ", the client " +
                std::to_string(kProtocolVersion),
            "build both from the same source"};
  const std::string where = "the server at " + to_string(server);
  if (key == insecure_key())
    return {where + " does not accept clients with --insecure",
            "omit --insecure, and use a key that the server has (rt_server pair)"};
  return {where + " has no key with the secret of '" + key.name + "' (id " + short_form(id_of(key)) + ")",
          "if '" + key.name +
              "' was made anew there, copy the file again; otherwise bring a key to the server "
              "(rt_server pair), make one there (rt_server keygen), or give --key the file that was made "
              "there. A "
              "server with --insecure knows no keys"};
}

Explanation explain(const Goodbye& goodbye, const SharedKey& key, const Peer& server) {
  const std::string where = "the server at " + to_string(server) + " has ended the session: ";
  switch (goodbye.reason) {
    case EndReason::ServerEnds:
      return {where + "it ends itself", "start it again"};
    case EndReason::Revoked:
      return {where + "the key '" + key.name + "' was taken out of its ring",
              "bring it a new one (rt_server pair)"};
    case EndReason::Expired:
      return {where + "the time of the key '" + key.name + "' is over",
              "make a new one there (rt_server keygen), or bring one (rt_server pair)"};
    case EndReason::Displaced:
      return {where + "it is full, and another key has fewer sessions", "start it with more --sessions"};
    case EndReason::Withdrawn:
      return {where + "it can no longer make these answers", "its log says why"};
  }
  return {};
}

std::string explain(const KeyId& id, const KeyRing& ring, const Peer& client) {
  const std::string text = "refused a client at " + to_string(client) + ": ";
  const KeyId open = id_of(insecure_key());
  if (ring.contains(id))
    return text + "it named the key '" + ring.at(id).name + "' and could not prove that it has it";
  if (id == open)
    return text + "it was started with --insecure, and this server wants a key: start it without --insecure";
  if (ring.contains(open))
    return text + "it uses a key, and this server was started with --insecure: start it with --insecure, too";
  return text + "no key of the ring has its id " + short_form(id) +
         ": it uses an old key file or that of another server (rt_server pair brings a new one)";
}

}  // namespace farshade
