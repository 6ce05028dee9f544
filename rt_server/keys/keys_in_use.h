/// KeysInUse: the keys that the server accepts now, for sessions and for fetching the scene. The key ring may
/// change while the server runs, and keys expire.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "rt_server/fetch/scene_sender.h"
#include "rt_server/work/server_core.h"
#include "stereo/base/clock.h"
#include "stereo/base/expected.h"
#include "stereo/base/file_watch.h"
#include "stereo/sealing/key_file.h"

namespace farshade {

struct LoadedKeys {
  std::optional<std::filesystem::path> file;  ///< without one, `ring` is the insecure key alone
  FileWatch watch;                            ///< of `file`, from before it was read
  std::vector<SharedKey> ring;                ///< not empty
};

/// The key ring in `file`, or the insecure key without one. Errors: those of load_key_ring, and Missing
/// for a ring without keys.
[[nodiscard]] Expected<LoadedKeys> load_keys(const std::optional<std::filesystem::path>& file);

/// The keys of `ring` that are valid on `day`.
[[nodiscard]] std::vector<SharedKey> valid_on(std::chrono::sys_days day, std::vector<SharedKey> ring);

/// The day by UTC.
[[nodiscard]] std::chrono::sys_days today_by_utc();

/// Keys that have expired stay in the ring and are not accepted.
class KeysInUse {
 public:
  /// Passes the keys to `core` and `sender` at once. Keeps references to both; `sender` may be null.
  KeysInUse(LoadedKeys loaded, ServerCore& core, SceneSender* sender,
            std::function<std::chrono::sys_days()> today = today_by_utc);

  /// Reads the key ring again. While it cannot be read, nobody new is admitted, because a newcomer's
  /// key may have been removed.
  void reload();

  /// Call it about once a second: a change counts after two equal looks. Keys expire at the end of a day. A
  /// ring that has changed is read again, and one that could not be read, or has no key, is tried again.
  void look_again();

 private:
  void read_again();
  void use();
  void complain(const std::string& what);

  LoadedKeys loaded_;
  ServerCore& core_;
  SceneSender* sender_;
  std::function<std::chrono::sys_days()> today_;
  std::chrono::sys_days day_{};
  bool is_read_ = true;
  std::string complaint_;
  Time complained_{};
};

}  // namespace farshade
