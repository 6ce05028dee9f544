/// An attacker that holds a valid key of a real rt_server, and plays what one key must not be able to do.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <random>
#include <string_view>
#include <vector>

#include "tests/unit/link_client.h"

namespace farshade {

class InsiderAttack {
 public:
  /// `served` is what the server says of itself. `victim` is the port of a good client, which gets datagrams
  /// that are not from its server.
  InsiderAttack(const Peer& server, const SharedKey& key, const Welcome& served, const Peer& victim);
  InsiderAttack(const InsiderAttack&) = delete;
  InsiderAttack& operator=(const InsiderAttack&) = delete;

  /// Plays one after the other, a second each, until `over`; a later call goes on with the next. The calling
  /// thread gets the least priority: the attacker's computer is not the server's.
  void run(const std::atomic<bool>& over);

  [[nodiscard]] std::uint64_t sent() const { return sent_; }
  /// Plays that have ended. Any thread may call it.
  [[nodiscard]] std::uint64_t rounds() const { return rounds_; }

  static constexpr std::size_t kPlays = 11;
  /// In the order in which they are played; after the last comes the first.
  static constexpr std::array<std::string_view, kPlays> kNames{
      "sessions begun anew",   "received tiles again", "sizes and bit rates",   "counters that jump",
      "a flood at the client", "nothing reported",     "memory held",           "arrivals made up",
      "the largest views",     "fields that jump",     "answers that take long"};

 private:
  /// Datagrams before the attacker waits until the server has handled them: more would overflow the server's
  /// socket buffer, in which the good client's datagrams come, too. No protocol prevents that.
  static constexpr int kBatch = 32;
  static constexpr std::size_t kSockets = 64;

  struct Socket {
    std::unique_ptr<DatagramPort> port;
    std::optional<link_test::PortClient> client{};
    std::uint64_t counter = 0;
    std::uint32_t frame = 0, last = 0;
    std::optional<std::uint64_t> holds_since{};  ///< the round
  };

  // Each sends at most kBatch datagrams.
  void reconnect();       // 1: sessions begun anew, each with a job
  void repeat_tiles();    // 2: slices of zeros with the same tile
  void wild_codings();    // 3 and 8: pictures of other sizes and bit rates in each request
  void jump_counters();   // 4
  void flood_victim();    // 5
  void report_nothing();  // 6 and 7: answers of the largest usual size, never reported
  void report_without_looking();
  void hold_memory();         // 9: positions that are never complete
  void ask_for_everything();  // 10: the largest views
  void jump_fields();         // 11: requests of every kind, with any frame numbers, times, sizes and rates
  void ask_for_pictures();    // 12: of the usual size, which are never refused, and larger

  Socket& joined(std::size_t i);
  void join(Socket& socket);
  void say(Socket& socket, const ClientMessage& message);
  FrameRequest next_request(Socket& socket, Extent size);
  void drain();
  void catch_up();

  Peer server_, victim_;
  SharedKey key_;
  Welcome served_;
  std::unique_ptr<DatagramPort> pacer_;  ///< only says hello
  std::vector<Socket> sockets_;
  std::size_t next_ = 0;
  std::mt19937_64 random_{1};
  std::uint64_t sent_ = 0;
  std::atomic<std::uint64_t> rounds_ = 0;
};

}  // namespace farshade
