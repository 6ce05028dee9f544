/// A link in virtual time with an attacker, for the targets that run whole conversations: ports that record
/// and withhold datagrams, and masks that can be painted a thousand times per second.
#pragma once

#include <spdlog/spdlog.h>

#include <map>
#include <vector>

#include "rt_server/work/server_core.h"
#include "stereo/link/network_link.h"
#include "tests/fuzz/edits.h"
#include "tests/support/fixed_random.h"
#include "tests/support/virtual_link.h"
#include "tests/unit/answers_from.h"

namespace farshade::fuzz {

using Bytes = std::vector<std::byte>;

inline constexpr Welcome kServed{{1, 2, 3}, 3};

[[nodiscard]] FrameRequest request(std::uint32_t frame);
/// Replaces the tracer: masks that differ in each frame, eye and pixel.
TraceStats paint(const FrameRequest& requested, ShadowFrame& frame);

[[nodiscard]] SharedKey key_named(std::string name);

/// A port that records the datagrams it sends, and withholds the next `hold_next` of them.
class Tap final : public DatagramPort {
 public:
  /// Records into `recorded`, which must outlive the port.
  Tap(DatagramPort& port, std::vector<Bytes>& recorded) : port_(port), recorded_(recorded) {}

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
  std::vector<Bytes>& recorded_;
};

/// One of `recorded`, counted from the newest, truncated and changed by the input; empty if there is none.
[[nodiscard]] Bytes replayed(const std::vector<Bytes>& recorded, Choices& choices, std::uint32_t most_edits);

/// A genuine client that checks the masks it receives.
struct GenuineClient {
  GenuineClient(DatagramPort& port, const Clock& time, const Peer& server, std::string name,
                std::vector<Bytes>& recorded);

  void ask();
  /// Checks that every complete mask is the painted one.
  void check_masks() const;
  /// Sends requests until it has complete masks, at most `tries`. Waits `patience` for each.
  [[nodiscard]] bool gets_masks(int tries, Duration patience);

  const Clock& clock;
  Tap tap;
  NetworkLink link;
  std::uint32_t requests = 0;
};

/// Lets the server do everything that it can do now.
void serve(ServerCore& core);

/// Runs the input: a list of steps of a conversation, and then its end. No session times out, because each of
/// the 32 steps takes at most 255 ms. Returns what LLVMFuzzerTestOneInput should.
template <class Conversation>
int converse(const std::uint8_t* data, std::size_t size) {
  constexpr int kMostSteps = 32;
  spdlog::set_level(spdlog::level::off);
  fix_random(1);
  Conversation conversation;
  Choices choices(data, size);
  for (int steps = 0; steps < kMostSteps && !choices.rest().empty(); ++steps) conversation.step(choices);
  conversation.finish();
  return 0;
}

}  // namespace farshade::fuzz
