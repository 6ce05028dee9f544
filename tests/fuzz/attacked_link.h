/// A link in virtual time that somebody listens to, for the targets of whole conversations: taps that keep
/// what was said, datagrams that never arrive, and masks cheap enough to be painted a thousand times a
/// second.
#pragma once

#include <map>
#include <vector>

#include "rt_server/core/server_core.h"
#include "stereo/net/virtual_link.h"
#include "tests/fuzz/edits.h"
#include "vr_client/link/network_link.h"

namespace farshade::fuzz {

using Bytes = std::vector<std::byte>;

inline constexpr Welcome kServed{{1, 2, 3}, 3};

[[nodiscard]] FrameRequest request(std::uint32_t frame);
/// In place of a tracer: masks that differ from frame to frame, eye to eye and pixel to pixel.
TraceStats paint(const FrameRequest& asked, ShadowFrame& frame);

[[nodiscard]] SharedKey key_named(std::string name);

/// A port whose datagrams are kept, as sent; `hold_next` of them get no further.
class Tap final : public DatagramPort {
 public:
  /// Keeps them in `heard`, which outlives it.
  Tap(DatagramPort& port, std::vector<Bytes>& heard) : port_(port), heard_(heard) {}

  [[nodiscard]] Peer local() const override { return port_.local(); }
  bool send(const Peer& to, std::span<const std::byte> bytes) override;
  [[nodiscard]] std::optional<Datagram> receive(std::span<std::byte> into, Duration wait) override {
    return port_.receive(into, wait);
  }
  void wake() override { port_.wake(); }
  [[nodiscard]] PortCounters counters() const override { return port_.counters(); }

  std::uint32_t hold_next = 0;
  std::map<Peer, std::uint64_t> bytes_to{};

 private:
  DatagramPort& port_;
  std::vector<Bytes>& heard_;
};

/// One of `heard`, the newest first, shortened and changed as the input says; nothing if there is none.
[[nodiscard]] Bytes heard_again(const std::vector<Bytes>& heard, Choices& choices, std::uint32_t most_edits);

/// A genuine client that knows what it should get.
struct GenuineClient {
  GenuineClient(DatagramPort& port, const Clock& time, const Peer& server, std::string name,
                std::vector<Bytes>& heard);

  void ask();
  /// Every whole mask in hand is the one that was painted.
  void check_masks() const;
  /// Asks until it has its masks, `tries` times at most, and waits `patience` for each.
  [[nodiscard]] bool gets_masks(int tries, Duration patience);

  const Clock& clock;
  Tap tap;
  NetworkLink link;
  std::uint32_t asked = 0;
};

/// Lets the server do all that it can do now.
void serve(ServerCore& core);

}  // namespace farshade::fuzz
