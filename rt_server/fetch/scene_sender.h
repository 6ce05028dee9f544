/// SceneSender: sends the scene's files to clients over TCP. Its threads have low priority: one accepts, one
/// serves each connection. What strangers and clients can take is bounded: connections, time, rate, memory.
#pragma once

#include <atomic>
#include <list>
#include <mutex>
#include <thread>

#include "rt_server/fetch/send_rate.h"
#include "rt_server/fetch/served_files.h"
#include "stereo/base/failure_log.h"
#include "stereo/messages/fetch_messages.h"
#include "stereo/net/sealed_stream.h"

namespace farshade {

struct SenderLimits {
  std::size_t connections = 16;          ///< of clients that proved a key
  std::size_t of_one_key = 4;            ///< of these
  std::size_t strangers = 8;             ///< connections before that; a new one ends the oldest
  std::size_t strangers_of_network = 4;  ///< of these: an IPv4 address or a /64 of IPv6; a new one is closed
  Duration first_message = std::chrono::seconds(3);  ///< until a client must have proved its key
  Duration silence = std::chrono::seconds(20);  ///< until a client must have asked, or taken what it was sent
  Duration between_accepts = std::chrono::milliseconds(10);
  double bytes_per_second = 12.5e6;  ///< to all clients together; a quarter of it while masks are sent
};

struct SenderCounters {
  std::uint64_t accepted = 0;  ///< connections
  std::uint64_t dropped = 0;   ///< strangers over the limits
  std::uint64_t unproved = 0;  ///< ended without a proved key
  std::uint64_t busy = 0;      ///< clients over the limits
  std::uint64_t sent_bytes = 0;
  friend bool operator==(const SenderCounters&, const SenderCounters&) = default;
};

/// One line for a person at a terminal.
[[nodiscard]] std::string counters_line(const SenderCounters& counters);

/// What is sent to whom.
struct SceneToSend {
  std::filesystem::path scene;
  std::vector<SceneFile> files;  ///< Scene::files
  Lighting lighting;
  Welcome served;
  std::vector<SharedKey> ring;
};

class SceneSender {
 public:
  /// Starts its threads. `masks_are_sent` must be callable from any thread until the destructor has returned.
  SceneSender(TcpListener listener, SceneToSend what, std::function<bool()> masks_are_sent,
              const SenderLimits& limits = {});
  SceneSender(const SceneSender&) = delete;
  SceneSender& operator=(const SceneSender&) = delete;
  /// Ends all connections.
  ~SceneSender();

  [[nodiscard]] SenderCounters counters() const;

  /// From now on sends only to clients with these keys. Connections of other keys end.
  void set_ring(const std::vector<SharedKey>& ring);

 private:
  struct Connection {
    Peer peer;
    std::optional<KeyId> key{};  ///< once it is proved
    std::atomic<bool> ended = false, done = false;
    std::jthread thread{};
  };

  void accept_all(const std::stop_token& stop);
  /// False if the stream is closed at once.
  bool start(TcpStream stream);
  void serve(Connection& connection, TcpStream stream);
  [[nodiscard]] bool promote(Connection& connection, const SharedKey& key);
  [[nodiscard]] Expected<void> send_offer(SealedStream& stream, const Connection& connection);
  [[nodiscard]] Expected<void> answer(SealedStream& stream, const FetchRequest& request,
                                      const Connection& connection);
  /// Sleeps until `bytes` may be sent. False if the connection was ended.
  [[nodiscard]] bool wait_for_turn(const Connection& connection, std::size_t bytes);
  [[nodiscard]] static Waiting within(const Connection& connection, Duration span);

  TcpListener listener_;
  SceneToSend what_;
  std::function<bool()> masks_are_sent_;
  SenderLimits limits_;
  std::optional<ServedFiles> files_;  ///< empty if they cannot be offered
  std::vector<std::byte> offer_;

  mutable std::mutex mutex_;  ///< guards what follows
  std::list<Connection> connections_;
  KeyRing ring_;
  SenderCounters counters_;
  SendRate rate_;
  FailureLog refused_;

  std::jthread acceptor_;  ///< the last member: it uses all others
};

}  // namespace farshade
