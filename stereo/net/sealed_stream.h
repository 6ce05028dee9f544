/// SealedStream: sealed messages over TCP. It uses the handshake and the sealing of datagrams; each envelope
/// follows its length. The Hello names the stream's purpose in place of a scene, so that a Hello, an Accept
/// and their keys are of no use for another purpose or over UDP, and those of UDP are of no use here.
#pragma once

#include <string>

#include "stereo/net/tcp.h"
#include "stereo/sealing/handshake.h"

namespace farshade {

enum class StreamPurpose : std::uint8_t { SceneFetch, Pairing };

/// "farshade scene fetch" or "farshade pairing", then zeros.
[[nodiscard]] ContentHash hello_of(StreamPurpose purpose);

class SealedStream {
 public:
  /// The client's side: proves `key` and learns what the server serves. Mismatch if the server does not know
  /// the key or speaks another version, Malformed if it does not follow the protocol.
  [[nodiscard]] static Expected<SealedStream> connect(TcpStream stream, StreamPurpose purpose,
                                                      const SharedKey& key, const Waiting& waiting);

  /// The server's side. `ring` has the keys of clients by id. The client has proved its key when its first
  /// message opens, because a Hello can be repeated by others. Mismatch, with a sentence for the log, if it
  /// has none or speaks another version.
  [[nodiscard]] static Expected<SealedStream> admit(TcpStream stream, StreamPurpose purpose,
                                                    const KeyRing& ring, const Welcome& served,
                                                    const Waiting& waiting);

  /// Queues a message; flush() sends the queue. So a caller can send many at once.
  void add(std::span<const std::byte> message);
  [[nodiscard]] std::size_t queued_bytes() const { return outgoing_.size(); }
  [[nodiscard]] Expected<void> flush(const Waiting& waiting);

  /// The next message, valid until the next call. Malformed if it does not open or is out of order.
  [[nodiscard]] Expected<std::span<const std::byte>> receive(const Waiting& waiting);

  [[nodiscard]] const Welcome& served() const { return served_; }  ///< by the server
  [[nodiscard]] const KeyId& key() const { return key_; }          ///< of the client
  /// That of the client's Hello.
  [[nodiscard]] ProtocolVersion version() const { return version_; }

 private:
  explicit SealedStream(TcpStream stream) : stream_(std::move(stream)) {}

  void add_frame(std::span<const std::byte> envelope);
  [[nodiscard]] Expected<std::span<const std::byte>> receive_frame(const Waiting& waiting);

  TcpStream stream_;
  Welcome served_{};
  KeyId key_{};
  ProtocolVersion version_ = kProtocolVersion;
  std::optional<Sealer> sealer_;
  std::optional<Opener> opener_;
  std::uint64_t received_ = 0;  ///< messages
  std::vector<std::byte> outgoing_, envelope_, message_;
  std::vector<std::byte> incoming_;
  std::size_t begin_ = 0;  ///< of what was not yet taken from incoming_
};

}  // namespace farshade
