/// Farewells: the last datagrams for clients whose sessions have ended. What loses one may lose the next one,
/// too, so they leave apart.
#pragma once

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "stereo/net/datagram.h"
#include "stereo/sealing/handshake.h"

namespace farshade {

class Farewells {
 public:
  /// Queues sealed datagrams for `to`; the first is due at once.
  void add(const Peer& to, std::vector<std::vector<std::byte>> datagrams) {
    farewells_.push_back({to, std::move(datagrams)});
  }

  /// When the next datagram is due; nothing if none is left.
  [[nodiscard]] std::optional<Time> due_at() const {
    if (farewells_.empty()) return std::nullopt;
    return std::ranges::min(farewells_, {}, &Farewell::due).due;
  }

  /// Removes a datagram that is due, for `to`. Returns false if none is.
  bool take(Time now, Peer& to, std::vector<std::byte>& datagram) {
    const auto next =
        std::ranges::find_if(farewells_, [&](const auto& farewell) { return farewell.due <= now; });
    if (next == farewells_.end()) return false;
    to = next->to;
    datagram = std::move(next->datagrams.back());
    next->datagrams.pop_back();
    next->due = now + kBetweenGoodbyes;
    if (next->datagrams.empty()) farewells_.erase(next);
    return true;
  }

 private:
  struct Farewell {
    Peer to;
    std::vector<std::vector<std::byte>> datagrams;
    Time due{};
  };
  std::vector<Farewell> farewells_;
};

}  // namespace farshade
