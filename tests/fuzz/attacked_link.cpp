#include "tests/fuzz/attacked_link.h"

#include <algorithm>

namespace farshade::fuzz {

FrameRequest request(std::uint32_t frame) {
  FrameRequest requested;
  requested.frame = {frame};
  requested.display_time = Time(frame * std::chrono::milliseconds(14));
  for (View& view : requested.views) view = {{}, {-0.7, 0.8, 0.6, -0.5}, {18, 10}};
  return requested;
}

TraceStats paint(const FrameRequest& requested, ShadowFrame& frame) {
  frame.frame = requested.frame;
  frame.light_set_revision = requested.lights.revision;
  frame.views = requested.views;
  std::uint32_t noise = requested.frame.value;
  for (const Side side : kSides) {
    const Extent size = requested.views[index_of(side)].size;
    EyeMask& mask = frame.masks[index_of(side)];
    mask = EyeMask(size, kServed.light_count);
    for (std::uint32_t y = 0; y < size.height; ++y)
      for (std::uint32_t x = 0; x < size.width; ++x)
        mask.set_word(x, y, 0, (noise = noise * 1664525 + 1013904223) >> 29);
  }
  return {};
}

SharedKey key_named(std::string name) {
  SharedKey key{.name = std::move(name)};
  std::copy_n(key.name.begin(), std::min<std::size_t>(key.name.size(), 32), key.secret.begin());
  return key;
}

bool Tap::send(const Peer& to, std::span<const std::byte> bytes) {
  recorded_.emplace_back(bytes.begin(), bytes.end());
  bytes_to[to] += bytes.size();
  if (hold_next == 0) return port_.send(to, bytes);
  --hold_next;
  return true;
}

Bytes replayed(const std::vector<Bytes>& recorded, Choices& choices, std::uint32_t most_edits) {
  const std::uint32_t back = choices.up_to(255);
  const std::uint32_t edits = choices.up_to(most_edits);
  if (recorded.empty()) return {};
  return edited(recorded[recorded.size() - 1 - back % recorded.size()], choices, edits);
}

GenuineClient::GenuineClient(DatagramPort& port, const Clock& time, const Peer& server, std::string name,
                             std::vector<Bytes>& recorded)
    : clock(time),
      tap(port, recorded),
      link(tap, time, {server, key_named(std::move(name)), kServed.scene_hash, {kServed.light_count}},
           Assembler::kKept + 1) {
  check(link.connect(std::chrono::seconds(1)).has_value(), "a client with the key is welcomed");
}

void GenuineClient::ask() {
  link.request(request(++requests), clock.now());
}

void GenuineClient::check_masks() const {
  for (const RequestRecord* received : link.receiver().received(clock.now())) {
    if (!received->complete()) continue;
    ShadowFrame painted;
    paint(request(received->request.frame.value), painted);
    check(received->masks == painted.masks, "masks are the painted ones, bit for bit");
  }
}

bool GenuineClient::gets_masks(int tries, Duration patience) {
  for (; tries > 0; --tries) {
    ask();
    const Time until = clock.now() + patience;
    const bool whole = link.wait_for({requests}, patience);
    check_masks();
    if (whole) return true;
    link.listen(until - clock.now());
  }
  return false;
}

void serve(ServerCore& core) {
  while (core.receive(Duration::zero())) {
  }
  while (core.work()) {
  }
  core.send_due();
}

}  // namespace farshade::fuzz
