#include "stereo/net/explain.h"

#include <cstdio>

namespace farshade {

std::string short_form(const ContentHash& hash) {
  std::array<char, 9> text{};
  std::snprintf(text.data(), text.size(), "%02x%02x%02x%02x", hash[0], hash[1], hash[2], hash[3]);
  return text.data();
}

std::string explain(const Refusal& refusal, const Hello& hello) {
  switch (refusal.reason) {
    case RefusalReason::VersionMismatch:
      return "the server speaks protocol version " + std::to_string(refusal.version) + ", the client " +
             std::to_string(hello.version) + ": build both from the same source";
    case RefusalReason::SceneMismatch:
      return "the server serves scene " + short_form(refusal.scene_hash) + ", the client shows scene " +
             short_form(hello.scene_hash) + ": give both the same scene file";
    case RefusalReason::Busy:
      return "the server has no room for another client: try again when one has left";
    case RefusalReason::NotWelcomed:
      return "the server does not know this client (any more): it has to say hello first";
  }
  return "the server refuses for a reason that this version does not know";
}

}  // namespace farshade
