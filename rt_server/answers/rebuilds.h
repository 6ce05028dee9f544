/// Rebuilds: how often the clients of one key may make the server build a renderer or open an encoder. Each
/// takes tens of milliseconds, in which the worker answers nobody.
#pragma once

#include <map>

#include "rt_server/admission/token_bucket.h"
#include "rt_server/work/request_handlers.h"

namespace farshade {

class Rebuilds {
 public:
  /// A client that follows the advised size of views changes it twice a second at most; its guard band
  /// changes in steps of 16 px, when the head begins to turn or to rest. Turns by key (key_ledger.h) bound
  /// the time that is left for others; this bounds the work that is thrown away.
  static constexpr double kPerSecond = 16;

  /// Call before each. Throws RebuiltTooOften if the key has none left at `now`.
  void take(const KeyId& key, Time now) {
    TokenBucket& left = left_.try_emplace(key, kPerSecond).first->second;
    if (!left.has_token(now)) throw RebuiltTooOften();
    left.take();
  }

 private:
  std::map<KeyId, TokenBucket> left_;
};

}  // namespace farshade
