/// ShadowLink: the client's end of the wire. Sends what is to be traced, assembles what comes back, hands out
/// the masks in hand, newest first. Never blocks longer than it was told; a server that is gone, late or
/// restarted means fewer masks, nothing else.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "stereo/net/assembler.h"
#include "stereo/net/datagram.h"
#include "stereo/scene/scene.h"

namespace farshade {

class ShadowLink {
 public:
  /// Masks of `lights` lights of `scene_hash`'s scene; keeps the newest `frames` requests. `clock` times
  /// waits.
  ShadowLink(DatagramPort& port, const Peer& server, const Clock& clock, const SceneHash& scene_hash,
             std::uint32_t lights, std::size_t frames);

  /// Says hello until the server welcomes us or `patience` is over. Refuses what the server refuses
  /// (Mismatch), a server that does not answer (Missing) or has no room (Unavailable); after the latter two
  /// one may go on, the link keeps trying.
  [[nodiscard]] Expected<void> meet(Duration patience);

  /// `asked_at` is the display time of the frame that asks; masks() tells frames apart by it.
  void request(const TraceRequest& request, Time asked_at);

  /// Takes in all that has arrived.
  void poll();

  /// Takes in what arrives until `frame` is whole or `patience` is over. True if it is whole.
  bool wait_for(FrameId frame, Duration patience);

  /// Frames of which something is known and that were asked for up to the display time `until`, newest first.
  [[nodiscard]] std::vector<const ReceivedFrame*> masks(Time until) const;

  /// When a frame that is still remembered was asked for.
  [[nodiscard]] std::optional<Time> asked_at(FrameId frame) const;

  /// Null if nothing of it is in hand.
  [[nodiscard]] const ReceivedFrame* find(FrameId frame) const { return assembler_.find(frame); }

  /// A refusal that no waiting can cure, once the server has said it.
  [[nodiscard]] const std::optional<Error>& refused() const { return refused_; }
  [[nodiscard]] bool welcomed() const { return welcomed_; }

  struct Counters {
    AssemblerCounters assembler;
    RefusalCounts undecodable;
    PortCounters port;
  };
  [[nodiscard]] Counters counters() const;

  /// Time spent so far on decoding and assembling, waits not counted.
  [[nodiscard]] Duration busy() const { return busy_; }

 private:
  bool receive_one(Duration wait);
  void say_hello();
  void take(const Welcome& welcome);
  void take(const Refusal& refusal);
  void take(const Slice& slice) { assembler_.accept(slice); }
  void take(const FrameReport& report) { assembler_.accept(report); }
  void send(const ClientMessage& message);

  DatagramPort& port_;
  Peer server_;
  const Clock& clock_;
  SceneHash scene_hash_;
  std::uint32_t lights_;
  std::uint32_t light_set_revision_ = 1;
  Assembler assembler_;
  struct Asked {
    FrameId frame;
    Time at;
  };
  std::vector<Asked> asked_;  ///< oldest first, at most `frames_`
  std::size_t frames_;
  bool welcomed_ = false;
  std::optional<Time> last_hello_;
  std::optional<Error> refused_;
  std::optional<std::string> busy_server_;  ///< what a server without room has said
  RefusalCounts undecodable_{};
  Duration busy_{};
  std::vector<std::byte> outgoing_;
  std::array<std::byte, kMaxDatagram_bytes> incoming_{};
};

}  // namespace farshade
