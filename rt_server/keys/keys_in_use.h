/// KeysInUse: the keys that the server accepts now, for sessions and for fetching the scene. The key ring may
/// change while the server runs, and keys expire.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "rt_server/core/server_core.h"
#include "rt_server/fetch/scene_sender.h"
#include "stereo/base/clock.h"
#include "stereo/base/expected.h"
#include "stereo/base/file_watch.h"
#include "stereo/wire/key_file.h"

namespace farshade {

struct LoadedKeys {
  std::filesystem::path file;   ///< empty: `ring` is the insecure key alone
  FileWatch watch;              ///< of `file`, from before it was read
  std::vector<SharedKey> ring;  ///< not empty
};

/// The key ring in `file`, or the insecure key if it is empty. Errors: those of load_key_ring, and Missing
/// for a ring without keys.
[[nodiscard]] Expected<LoadedKeys> load_keys(const std::filesystem::path& file);

/// Those of `ring` that have not expired.
[[nodiscard]] std::vector<SharedKey> valid_on(std::chrono::sys_days day, std::vector<SharedKey> ring);

/// The day by UTC.
[[nodiscard]] std::chrono::sys_days today_by_utc();

/// Keys that have expired stay in the ring and are not accepted.
class KeysInUse {
 public:
  /// Tells both whom to accept, from the beginning. Keeps references to `core` and `sender`, which may be
  /// null.
  KeysInUse(LoadedKeys loaded, ServerCore& core, SceneSender* sender,
            std::function<std::chrono::sys_days()> today = today_by_utc);

  /// Reads the key ring again. While it cannot be read, nobody new is admitted, because the key of whoever
  /// comes may have been taken out of it.
  void reload();

  /// Call it again and again. Keys expire at the end of a day. A ring that has changed is read again, and one
  /// that could not be read, or has no key, is tried again.
  void look_again();

 private:
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
