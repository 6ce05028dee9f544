#include "stereo/net/explain.h"

#include <cstdio>

namespace farshade {

std::string short_form(const ContentHash& hash) {
  std::array<char, 9> text{};
  std::snprintf(text.data(), text.size(), "%02x%02x%02x%02x", hash[0], hash[1], hash[2], hash[3]);
  return text.data();
}

std::string_view name_of(RefusalReason reason) {
  switch (reason) {
    case RefusalReason::VersionMismatch:
      return "another protocol version";
    case RefusalReason::UnknownKey:
      return "unknown key";
    case RefusalReason::SceneMismatch:
      return "it shows another scene: give both the same scene file, --light, --sun, --ambient and "
             "--exposure";
    case RefusalReason::Busy:
      return "no room for another client (--sessions)";
  }
  return "unknown reason";
}

Explanation explain(const Refusal& refusal, const ContentHash& scene_hash) {
  if (refusal.reason == RefusalReason::Busy)
    return {"the server has no room for another client", "try again later, or start it with more --sessions"};
  return {
      "the server serves scene " + short_form(refusal.scene_hash) + ", the client shows scene " +
          short_form(scene_hash),
      "give both the same scene file, or start the client without --scene, so that it fetches the server's"};
}

Explanation explain(const OpenRefusal& refusal, const std::string& key, const Peer& server) {
  if (refusal.reason == RefusalReason::VersionMismatch)
    return {"the server speaks protocol version " + std::to_string(refusal.version) + ", the client " +
                std::to_string(kProtocolVersion),
            "build both from the same source"};
  return {"the server at " + to_string(server) + " does not know the key '" + key + "'",
          "add it to the server's ring (rt_server keygen), or give --key the file that was made there"};
}

}  // namespace farshade
