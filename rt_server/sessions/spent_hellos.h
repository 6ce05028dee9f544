/// SpentHellos: hellos of which nothing more comes: they were refused, or their session has ended. While the
/// cookie of a hello is valid anybody can send it again from its address; it then costs no handshake. Memory
/// is bounded.
#pragma once

#include <algorithm>
#include <deque>
#include <utility>
#include <vector>

#include "stereo/messages/timing.h"
#include "stereo/sealing/handshake.h"

namespace farshade {

class SpentHellos {
 public:
  /// Twice as many as the usual limit of handshakes lets begin while a cookie is valid; the oldest gives way.
  static constexpr std::size_t kMostSpentHellos = 1024;

  /// A datagram was received at `now`. Forgets the hellos of which no cookie is valid any more: a newer hello
  /// shows its client.
  void advance(Time now) {
    now_ = std::max(now_, now);
    while (!spent_.empty() && spent_.front().until < now_) spent_.pop_front();
  }
  /// `answer` is sent again if the hello arrives again; empty: none.
  void add(const KeyId& key, const PublicKey& client, std::vector<std::byte> answer) {
    if (spent_.size() == kMostSpentHellos) spent_.pop_front();
    spent_.push_back({key, client, std::move(answer), now_ + kCookieLife});
  }
  /// Null if `hello` is not spent.
  [[nodiscard]] const std::vector<std::byte>* answer_to(const Hello& hello) const {
    const auto spent = std::ranges::find_if(
        spent_, [&](const Spent& old) { return old.client == hello.client && old.key == hello.key; });
    return spent == spent_.end() ? nullptr : &spent->answer;
  }

 private:
  struct Spent {
    KeyId key{};
    PublicKey client{};
    std::vector<std::byte> answer;
    Time until{};
  };
  std::deque<Spent> spent_;
  Time now_{};  ///< of the last datagram
};

}  // namespace farshade
