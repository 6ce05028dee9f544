#include "tests/integration/insider_tools.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <stdexcept>
#include <thread>

#include "stereo/frame/tiles.h"
#include "stereo/messages/frame_fields.h"
#include "stereo/net/udp.h"
#include "tests/unit/forged.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using link_test::Bytes;

constexpr Duration kPlay = 1s, kPause = 1ms, kPatience = 100ms;
constexpr Extent kUsual{512, 512};

}  // namespace

InsiderAttack::InsiderAttack(const Peer& server, const SharedKey& key, const Welcome& served,
                             const Peer& victim)
    : server_(server), victim_(victim), key_(key), served_(served) {
  const auto new_port = [&] {
    Expected<UdpClient> udp = connect_udp(server);
    if (!udp) throw std::runtime_error(udp.error().what);
    return std::move(udp->port);
  };
  pacer_ = new_port();
  for (std::size_t i = 0; i < kSockets; ++i) sockets_.push_back({new_port()});
}

void InsiderAttack::run(const std::atomic<bool>& over) {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 19);
  constexpr std::array<void (InsiderAttack::*)(), kPlays> plays{
      &InsiderAttack::reconnect,          &InsiderAttack::repeat_tiles,
      &InsiderAttack::wild_codings,       &InsiderAttack::jump_counters,
      &InsiderAttack::flood_victim,       &InsiderAttack::report_nothing,
      &InsiderAttack::hold_memory,        &InsiderAttack::report_without_looking,
      &InsiderAttack::ask_for_everything, &InsiderAttack::jump_fields,
      &InsiderAttack::ask_for_pictures};
  const SteadyClock clock;
  for (; !over; ++rounds_) {
    const auto play = plays[rounds_ % plays.size()];
    for (const Time until = clock.now() + kPlay; clock.now() < until && !over;) {
      (this->*play)();
      drain();
      catch_up();
      std::this_thread::sleep_for(kPause);
    }
  }
}

void InsiderAttack::join(Socket& socket) {
  socket.client.emplace(*socket.port, server_, key_, served_);
  socket.counter = 0;
  socket.client->connect(kPatience);
  ++sent_;
}

/// The socket, with a session of this round or an earlier one that still lives.
InsiderAttack::Socket& InsiderAttack::joined(std::size_t i) {
  Socket& socket = sockets_[i % kSockets];
  const bool is_over = socket.client && socket.client->no_session > 0;
  if (!socket.client || !socket.client->session || is_over) join(socket);
  return socket;
}

void InsiderAttack::say(Socket& socket, const ClientMessage& message) {
  if (!socket.client->keys) return;
  Bytes bytes;
  encode(message, bytes);
  socket.client->say(link_test::seal_at(socket.counter++, socket.client->keys->session,
                                        socket.client->keys->to_server, bytes));
  ++sent_;
}

FrameRequest InsiderAttack::next_request(Socket& socket, Extent size) {
  FrameRequest request = link_test::request_of(++socket.frame, size);
  for (View& view : request.views) view.stage_from_eye.translation = {0, 1.5, 4};
  return request;
}

void InsiderAttack::drain() {
  for (Socket& socket : sockets_) {
    if (!socket.client) continue;
    for (int i = 0; i < kBatch && socket.client->hear(Duration::zero()); ++i) {
    }
  }
}

/// The server handles datagrams in order: it has handled all before when it answers a hello without a cookie.
void InsiderAttack::catch_up() {
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  while (pacer_->receive(buffer, Duration::zero())) {
  }
  pacer_->send(server_, link_test::LinkClient(key_, served_).hello());
  static_cast<void>(pacer_->receive(buffer, kPatience));
  ++sent_;
}

void InsiderAttack::reconnect() {
  for (int i = 0; i < 4; ++i) {
    Socket& socket = sockets_[next_++ % kSockets];
    join(socket);
    say(socket, RequestMessage{.request = next_request(socket, kUsual)});
  }
}

void InsiderAttack::repeat_tiles() {
  Socket& socket = joined(next_);
  RequestMessage message{.request = next_request(socket, kUsual)};
  message.request.answer = {.kind = Answer::MasksOfPositions, .position_bits = 16, .slices = 65535};
  say(socket, message);
  const std::array<std::byte, 16> zeros{};
  PlaneSlice slice{.frame = message.request.frame,
                   .kind = PlaneKind::PositionX,
                   .size = kUsual,
                   .word_bytes = 2,
                   .tile_count = 16,
                   .block = zeros};
  for (int i = 1; i < kBatch - 1; ++i) say(socket, slice);
  ++slice.frame.value;  // of a request that was never made
  say(socket, slice);
}

void InsiderAttack::wild_codings() {
  constexpr std::array kinds{Answer::Video, Answer::GBuffer, Answer::Difference};
  for (int i = 0; i < 4; ++i) {
    Socket& socket = joined(next_++);
    const auto n = static_cast<std::uint32_t>(next_);
    RequestMessage message{.request = next_request(socket, {64 + 16 * (n % 13), 64 + 16 * (n % 7)})};
    message.request.answer.kind = kinds[n % kinds.size()];
    if (is_video(message.request.answer.kind)) {
      message.request.answer.bits_per_second = kLeastVideo_bits * (1 + n % 50);
      message.request.answer.interval = 14ms;
    }
    say(socket, message);
  }
}

void InsiderAttack::jump_counters() {
  Socket& socket = joined(next_++);
  for (const int bits : {27, 32, 62, 63}) {
    const std::uint64_t before = socket.counter;
    socket.counter = (std::uint64_t{1} << bits) + 300;
    say(socket, RequestMessage{.request = next_request(socket, kUsual)});
    socket.counter = before;
  }
  socket.counter = ~std::uint64_t{0};
  say(socket, RequestMessage{.request = next_request(socket, kUsual)});
  socket.counter = 0;
  join(socket);
}

void InsiderAttack::flood_victim() {
  const Bytes noise(1200, std::byte{0x46});
  for (int i = 0; i < kBatch; ++i) sockets_[0].port->send(victim_, noise);
  sent_ += kBatch;
}

void InsiderAttack::report_nothing() {
  for (int i = 0; i < 8; ++i) {
    Socket& socket = joined(next_++);
    say(socket, RequestMessage{.request = next_request(socket, kUsual)});
  }
}

void InsiderAttack::report_without_looking() {
  for (int i = 0; i < 2; ++i) {
    Socket& socket = joined(static_cast<std::size_t>(i));
    RequestMessage message{.request = next_request(socket, kUsual)};
    message.arrivals = socket.client->arrivals.report();
    for (std::uint32_t entry = 0; entry < message.arrivals.count; ++entry)
      if (!message.arrivals.arrived(entry)) message.arrivals.ticks[entry] = 0;
    say(socket, message);
  }
}

void InsiderAttack::hold_memory() {
  Socket& socket = joined(next_++ % 8);
  constexpr Extent kLarge{2048, 2048};
  if (socket.holds_since != rounds_) {
    socket.holds_since = rounds_;
    RequestMessage message{.request = next_request(socket, kLarge)};
    message.request.answer = {.kind = Answer::MasksOfPositions, .position_bits = 16, .slices = 65535};
    say(socket, message);
  }
  const Bytes full(1100, std::byte{7});
  for (std::uint32_t tile = 0; tile + 1 < kBatch; ++tile)
    say(socket, PlaneSlice{.frame = {socket.frame},
                           .kind = PlaneKind::PositionX,
                           .size = kLarge,
                           .word_bytes = 2,
                           .first_tile = tile,
                           .tile_count = 1,
                           .block = full});
}

void InsiderAttack::ask_for_everything() {
  const auto side = std::min(kMaxViewSide_px, static_cast<std::uint32_t>(std::sqrt(served_.most_pixels)));
  for (int i = 0; i < 4; ++i) {
    Socket& socket = joined(next_++);
    say(socket, RequestMessage{.request = next_request(socket, {side, side})});
  }
}

void InsiderAttack::ask_for_pictures() {
  constexpr std::array kinds{Answer::GBuffer, Answer::Difference};
  for (std::size_t i = 0; i < 4; ++i) {
    Socket& socket = joined(4 * (rounds_ % (kSockets / 4)) + i);  // other sessions in each round
    RequestMessage message{.request = next_request(socket, i == 0 ? Extent{1024, 1024} : kUsual)};
    message.request.answer.kind = kinds[i % kinds.size()];
    if (is_video(message.request.answer.kind)) {
      message.request.answer.bits_per_second = kLeastVideo_bits;
      message.request.answer.interval = 14ms;
    }
    say(socket, message);
  }
}

/// Mostly valid: sizes are small, so that many are answered, and some are too large.
void InsiderAttack::jump_fields() {
  const auto up_to = [&](std::uint64_t most) { return random_() % (most + 1); };
  const auto any = [&] { return (std::uint64_t{1} << up_to(63)) - up_to(1); };
  const auto any_time = [&] { return time_from_ns(static_cast<std::int64_t>(any() % kMaxTime_ns)); };
  for (int i = 0; i < 8; ++i) {
    Socket& socket = joined(up_to(1));
    const auto side = static_cast<std::uint32_t>(up_to(9) == 0 ? kMaxViewSide_px : 64);
    RequestMessage message{.request = next_request(socket, {side, side})};
    FrameRequest& request = message.request;
    request.frame.value = static_cast<std::uint32_t>(up_to(3) == 0 ? any() : socket.last + up_to(2));
    if (up_to(1) == 0) request.display_time = any_time();
    if (up_to(1) == 0) request.scene_time = any_time();
    request.answer.kind =
        static_cast<Answer>(up_to(2) == 0 ? up_to(kAnswers - 1) : static_cast<std::uint64_t>(Answer::Video));
    if (is_video(request.answer.kind)) {
      request.answer.bits_per_second = kLeastVideo_bits;
      request.answer.interval =
          Duration(1 + static_cast<Duration::rep>(any() % kMostPictureInterval.count()));
      request.answer.coding = up_to(3) == 0 ? Coding::Alone : Coding::AfterLast;
    }
    if (request.answer.kind == Answer::MasksOfPositions)
      request.answer.position_bits = kLeastPosition_bits + static_cast<std::uint32_t>(up_to(8));
    message.probe_echo = any();
    message.arrivals.first = any() / 2;
    message.arrivals.base = any_time();
    message.arrivals.count = static_cast<std::uint32_t>(up_to(ArrivalReport::kMost));
    socket.last = request.frame.value;
    say(socket, message);
  }
}

}  // namespace farshade
