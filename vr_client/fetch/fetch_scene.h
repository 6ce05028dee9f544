/// fetch_scene: brings the server's scene into the cache. It goes on after a cut connection, and it ends:
/// when the scene is whole, when the server sends almost nothing, when it does not follow the protocol, or
/// when the caller wants to stop.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "stereo/fetch/scene_offer.h"
#include "stereo/messages/messages.h"
#include "stereo/net/tcp.h"
#include "stereo/sealing/key_file.h"

namespace farshade {

struct FetchPlan {
  std::vector<Peer> servers;  ///< addresses of one server, at least one; the first that accepts is used
  SharedKey key;
  std::filesystem::path cache;  ///< folder of all fetched scenes
  std::function<bool()> stopped = [] { return false; };
  /// Tells what happens: bytes of the scene that are here, of all of them. Called often.
  std::function<void(std::uint64_t here, std::uint64_t all)> progress = [](std::uint64_t, std::uint64_t) {};
  std::function<void(const std::string&)> note = [](const std::string&) {};  ///< one sentence for the user
  /// The fetch fails if fewer than `least_bytes` come in this time.
  Duration patience = std::chrono::seconds(20);
  std::uint64_t least_bytes = 20'000;
  Duration retry_pause = std::chrono::milliseconds(500);  ///< before another connection
};

struct FetchedScene {
  std::filesystem::path scene;  ///< in the cache
  Lighting lighting;            ///< of the server
  ContentHash hash{};           ///< of the lit scene, by the server
  std::uint64_t fetched_bytes = 0;
};

/// Errors: Missing (no server, or it does not send its scene), Mismatch (key, version, or the hash of a
/// file), Malformed or OutOfRange (what it sends), Unavailable (stopped, or busy), Unreadable (the disk).
[[nodiscard]] Expected<FetchedScene> fetch_scene(const FetchPlan& plan);

/// What the server would send. `plan.cache` is not used.
struct ReceivedOffer {
  SceneOffer offer;
  ContentHash hash{};  ///< of the lit scene
};
[[nodiscard]] Expected<ReceivedOffer> ask_offer(const FetchPlan& plan);

/// $XDG_CACHE_HOME/farshade/scenes.
[[nodiscard]] std::filesystem::path scene_cache_folder();

}  // namespace farshade
