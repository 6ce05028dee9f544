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
#include "stereo/wire/key_file.h"

namespace farshade {

struct KeySource {
  std::filesystem::path ring;  ///< empty: the insecure key alone
};

/// At least one key. Errors: those of load_key_ring, and Missing for a ring without keys.
[[nodiscard]] Expected<std::vector<SharedKey>> load_keys(const KeySource& source);

/// Those of `ring` that have not expired.
[[nodiscard]] std::vector<SharedKey> valid_on(std::chrono::sys_days day, std::vector<SharedKey> ring);

/// The day by UTC.
[[nodiscard]] std::chrono::sys_days today_by_utc();

/// Keys that have expired stay in the ring and are not accepted.
class KeysInUse {
 public:
  /// Tells both whom to accept, from the beginning. Keeps references to `core` and `sender`, which may be
  /// null.
  KeysInUse(KeySource source, std::vector<SharedKey> ring, ServerCore& core, SceneSender* sender,
            std::function<std::chrono::sys_days()> today = today_by_utc);

  /// Reads the key ring again. While it cannot be read, nobody new is admitted, because the key of whoever
  /// comes may have been taken out of it.
  void reload();

  /// Keys expire at the end of a day. A ring that could not be read is tried again.
  void look_again();

 private:
  void use();
  void complain(const std::string& what);

  KeySource source_;
  std::vector<SharedKey> ring_;
  ServerCore& core_;
  SceneSender* sender_;
  std::function<std::chrono::sys_days()> today_;
  std::chrono::sys_days day_{};
  bool is_read_ = true;
  std::string complaint_;
  Time complained_{};
};

}  // namespace farshade
