// A server that offers every kind of answer, with the handlers of masks, of planes and of video that it has
// in earnest, a genuine client, and a client that holds another key and does with it what it likes: any bytes
// sealed for its sessions, requests of every kind with too many parts and with numbers and times that jump,
// counters that jump, sessions begun anew, hellos with the public keys of others. The input is a list of
// steps in virtual time. After each step the jobs that the server made fit their requests, and it has no more
// sessions than allowed. The genuine client keeps its session, and gets its masks bit for bit with its next
// request.
#include <array>

#include "rt_server/answers/video.h"
#include "stereo/codec/mask_block.h"
#include "stereo/frame/cube_mask.h"
#include "stereo/frame/tiles.h"
#include "stereo/messages/frame_fields.h"
#include "tests/fuzz/attacked_link.h"
#include "tests/support/manual_clock.h"
#include "tests/unit/forged.h"
#include "tests/unit/link_client.h"

using namespace farshade;
using namespace std::chrono_literals;
using fuzz::Bytes;

namespace {

constexpr std::uint32_t kPlaces = 5;  ///< addresses; the genuine client has the first
constexpr std::size_t kMostSessions = 6;

Welcome served_everything() {
  Welcome served = fuzz::kServed;
  served.most_pixels = 64 * 64;
  served.answers = kEveryAnswer;
  return served;
}

/// The tiles that a job's parts have.
std::size_t tiles_of(const Job& job) {
  std::size_t tiles = 0;
  for (const Bytes& part : job.parts) {
    const Decoded<ClientMessage> message = decode_client(part);
    check(message.has_value(), "a part was decoded before");
    const auto take = [&](const auto& slice) {
      check(slice.size == job.request.views[index_of(slice.eye)].size, "a part is of the requested view");
      tiles += slice.tile_count;
    };
    if (const auto* plane = std::get_if<PlaneSlice>(&*message)) take(*plane);
    if (const auto* asked = std::get_if<AskSlice>(&*message)) take(*asked);
  }
  return tiles;
}

/// A number from the input: small, or anywhere in the 64 bits.
std::uint64_t any_number(fuzz::Choices& choices) {
  if (choices.up_to(1) == 0) return choices.up_to(3);
  const std::uint64_t far = std::uint64_t{1} << choices.up_to(63);
  return choices.up_to(1) == 0 ? far - 1 - choices.up_to(2) : far + choices.up_to(2);
}

/// A time within the range of the wire.
Time any_time(fuzz::Choices& choices) {
  const std::uint64_t ns = any_number(choices) % (std::uint64_t{kMaxTime_ns} + 1);
  return time_from_ns(choices.up_to(1) == 0 ? static_cast<std::int64_t>(ns) : -static_cast<std::int64_t>(ns));
}

PixelPlane plane_of(Extent size, std::uint32_t word_bytes) {
  PixelPlane plane(size, word_bytes);
  for (std::size_t i = 0; i < plane.words.size(); ++i) plane.words[i] = static_cast<std::uint32_t>(37 * i);
  return plane;
}

/// Checks the job, and makes masks and planes from paint, and video from grey pictures.
AnswerCost answer(const Job& job, FramePacker& packer, Streams& streams) {
  std::size_t most = 0;
  for (const View& view : job.request.views) {
    check(view.size.pixels() <= served_everything().most_pixels, "no view is larger than allowed");
    most += TileGrid{view.size}.count();
  }
  check(!is_drawn(job.request.answer.kind) || job.request.views[0].size == job.request.views[1].size,
        "pictures have one size");
  check(tiles_of(job) <= 3 * most, "no more tiles than the views have");
  check(job.parts.size() <= job.request.answer.slices, "no more parts than announced");
  const Answer kind = job.request.answer.kind;
  const Extent size = job.request.views[0].size;
  if (is_video(kind)) {
    const Image<Rgb8> grey(size, Rgb8(static_cast<std::uint8_t>(job.request.frame.value)));
    return {.coding = has_video() ? streams.code(job, {grey, grey}, packer) : Duration{}};
  }
  if (kind == Answer::GBuffer) {
    GBufferPlanes planes;
    planes.base_color.fill(plane_of(size, 3));
    planes.normal.fill(plane_of(size, 4));
    planes.depth.fill(plane_of(size, 4));
    packer.add(job.request.frame, planes);
  }
  if (kind != Answer::Masks) return {};
  ShadowFrame frame;
  AnswerCost cost{.traced = fuzz::paint(job.request, frame)};
  if (frame.masks[0].size() != Extent{18, 10}) return cost;
  if (job.request.answer.coding == Coding::Lz4)
    packer.add(frame.frame, frame.frame, full_parts(pack_mask_block(frame)));
  else
    packer.add(frame);
  return cost;
}

class Conversation {
 public:
  Conversation();
  void step(fuzz::Choices& choices);
  void finish();

 private:
  [[nodiscard]] link_test::PortClient& evil(std::uint32_t place) { return *evil_[place]; }
  void join(std::uint32_t place);
  void say_sealed(std::uint32_t place, std::span<const std::byte> message, std::uint64_t jump = 0);
  [[nodiscard]] Bytes request(std::uint32_t place, fuzz::Choices& choices);
  [[nodiscard]] Bytes part(fuzz::Choices& choices) const;
  void steal_hello(std::uint32_t place);
  void check_server();

  ManualClock clock_;
  VirtualLink wire_{clock_, {}, kPlaces};
  std::vector<Bytes> recorded_;
  const std::vector<SharedKey> ring_{fuzz::key_named("good"), fuzz::key_named("evil")};
  Streams streams_{kMemory_bytes};
  ServerCore core_{
      served_everything(),
      ring_,
      answers_from(kEveryAnswer,
                   [this](const Job& job, FramePacker& packer) { return answer(job, packer, streams_); }),
      wire_.server(),
      clock_,
      {.sessions = kMostSessions, .handshakes_per_second = 1e6}};
  std::optional<fuzz::GenuineClient> good_;
  std::array<std::optional<link_test::PortClient>, kPlaces> evil_;
  std::array<std::uint64_t, kPlaces> counter_{};
  FrameRequest last_ = fuzz::request(1);  ///< of the evil client
};

Conversation::Conversation() {
  wire_.while_waiting([this] { fuzz::serve(core_); }, [this] { return core_.next_due(); });
  good_.emplace(wire_.client(0), clock_, wire_.server().local(), "good", recorded_);
  check(good_->gets_masks(1, 100ms), "an undisturbed client gets its masks");
  for (std::uint32_t place = 1; place < kPlaces; ++place) join(place);
}

void Conversation::join(std::uint32_t place) {
  evil_[place].emplace(wire_.client(place), wire_.server().local(), ring_[1], served_everything());
  counter_[place] = 0;
  evil(place).say(evil(place).hello());
  for (int steps = 0; steps < 3; ++steps) {
    fuzz::serve(core_);
    while (evil(place).hear(0s)) {
    }
  }
}

void Conversation::say_sealed(std::uint32_t place, std::span<const std::byte> message, std::uint64_t jump) {
  if (!evil(place).keys) return join(place);
  counter_[place] += jump;
  evil(place).say(
      link_test::seal_at(counter_[place]++, evil(place).keys->session, evil(place).keys->to_server, message));
  fuzz::serve(core_);
}

Bytes Conversation::request(std::uint32_t place, fuzz::Choices& choices) {
  RequestMessage message;
  FrameRequest& request = message.request;
  request = fuzz::request(last_.frame.value + static_cast<std::uint32_t>(any_number(choices)));
  if (choices.up_to(3) == 0) request.display_time = any_time(choices);
  if (choices.up_to(3) == 0) request.scene_time = any_time(choices);
  request.answer.kind = static_cast<Answer>(choices.up_to(kAnswers - 1));
  const Extent size{1 + choices.up_to(70), 1 + choices.up_to(70)};
  for (View& view : request.views) view.size = size;
  if (choices.up_to(3) == 0) request.views[1].size = {18, 10};
  if (is_video(request.answer.kind)) {
    request.answer.bits_per_second = kLeastVideo_bits + choices.up_to(1) * 1000;
    request.answer.interval = 10ms;
    request.answer.coding = choices.up_to(3) == 0 ? Coding::Alone : Coding::AfterLast;
  }
  const bool positions = request.answer.kind == Answer::MasksOfPositions;
  if (positions) request.answer.position_bits = kLeastPosition_bits;
  if (positions || request.answer.kind == Answer::Masks) request.answer.slices = choices.up_to(65535);
  if (request.answer.kind == Answer::Masks && request.answer.slices == 0 && choices.up_to(1) == 0)
    request.answer.coding = Coding::Lz4;
  if (request.answer.kind == Answer::CubeMask) request.frame.value += kFirstCubeMaskFrame.value;
  message.probe_echo = choices.up_to(1) == 0 ? evil(place).probe : any_number(choices);
  message.arrivals.first = any_number(choices) / 2;
  if (choices.up_to(3) == 0) message.arrivals.base = any_time(choices);
  message.arrivals.count = choices.up_to(ArrivalReport::kMost);
  last_ = request;
  Bytes bytes;
  encode(ClientMessage(message), bytes);
  return bytes;
}

Bytes Conversation::part(fuzz::Choices& choices) const {
  const std::array block{static_cast<std::byte>(choices.up_to(255))};
  const auto side = static_cast<Side>(choices.up_to(1));
  const Extent size = choices.up_to(7) == 0 ? Extent{1024, 1024} : last_.views[index_of(side)].size;
  const std::uint32_t tiles = std::min(TileGrid{size}.count(), 1 + choices.up_to(255));
  Bytes bytes;
  if (choices.up_to(1) == 0)
    encode(ClientMessage(PlaneSlice{.frame = last_.frame,
                                    .eye = side,
                                    .kind = static_cast<PlaneKind>(choices.up_to(5)),
                                    .size = size,
                                    .word_bytes = 1,
                                    .tile_count = tiles,
                                    .block = block}),
           bytes);
  else
    encode(ClientMessage(AskSlice{.frame = last_.frame,
                                  .eye = side,
                                  .size = size,
                                  .lights = 3,
                                  .tile_count = tiles,
                                  .block = block}),
           bytes);
  return bytes;
}

/// A client of the good key says hello at this address. The other key's holder sees the hello and sends its
/// public key first. The good key's client must have a session of its own.
void Conversation::steal_hello(std::uint32_t place) {
  link_test::LinkClient victim(ring_[0], served_everything());
  const PublicKey seen = std::get<Hello>(*open_client_envelope(victim.hello())).client;
  const ContentHash scene = served_everything().scene_hash;
  DatagramPort& port = wire_.client(place);
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  const auto exchanged = [&](const Bytes& datagram) {
    while (port.receive(buffer, 0s)) {
    }
    port.send(wire_.server().local(), datagram);
    fuzz::serve(core_);
    const auto came = port.receive(buffer, 0s);
    return came ? Bytes(came->bytes.begin(), came->bytes.end()) : Bytes();
  };
  const Bytes retry = exchanged(link_test::hello_with(seen, ring_[1], scene, {}));
  const auto asked = open_server_envelope(retry);
  if (!asked || !std::holds_alternative<Retry>(*asked)) return;
  exchanged(link_test::hello_with(seen, ring_[1], scene, std::get<Retry>(*asked).cookie));
  Bytes reply = victim.hello();
  for (int steps = 0; steps < 2 && !reply.empty(); ++steps)
    reply = victim.take(exchanged(reply), clock_.now());
  check(victim.welcome.has_value() || victim.refusal.has_value(), "the server answers the good key");
}

void Conversation::step(fuzz::Choices& choices) {
  enum Step : std::uint32_t { Say, Ask, Part, Change, Jump, Join, Steal, Move, Pass, Good, kSteps };
  const std::uint32_t kind = choices.up_to(kSteps - 1), place = 1 + choices.up_to(kPlaces - 2);
  if (kind == Say) {
    say_sealed(place, choices.bytes(choices.up_to(255)));
  } else if (kind == Ask) {
    say_sealed(place, request(place, choices));
  } else if (kind == Part) {
    const Bytes message = part(choices);
    for (std::uint32_t times = 1 + choices.up_to(63); times > 0; --times) say_sealed(place, message);
  } else if (kind == Change) {
    const Bytes message = choices.up_to(1) == 0 ? request(place, choices) : part(choices);
    Bytes changed = fuzz::edited(message, choices, 4);
    if (changed.size() > kMaxMessage_bytes) changed.resize(kMaxMessage_bytes);
    say_sealed(place, changed);
  } else if (kind == Jump) {
    const std::uint64_t far = std::uint64_t{1} << choices.up_to(63);
    const std::uint64_t jump = choices.up_to(1) == 1 ? 2 * far - 1 : far;
    say_sealed(place, request(place, choices), jump);
  } else if (kind == Join) {
    join(place);
  } else if (kind == Steal) {
    steal_hello(place);
  } else if (kind == Move) {
    wire_.move_client(place);
  } else if (kind == Pass) {
    good_->link.listen(std::chrono::milliseconds(choices.up_to(255)));
  } else {
    good_->ask();
    fuzz::serve(core_);
    good_->link.poll();
  }
  check_server();
}

void Conversation::check_server() {
  for (std::uint32_t place = 1; place < kPlaces; ++place)
    while (evil(place).hear(0s)) {
    }
  good_->check_masks();
  check(core_.counters().sessions_open <= kMostSessions, "no more sessions than allowed");
  check(!good_->link.refused(), "the genuine client is not refused");
  check_eq(good_->link.counters().sessions, 1u, "sessions of the genuine client: the first one");
}

void Conversation::finish() {
  check(good_->gets_masks(1, 100ms), "the genuine client gets its masks");
  check_server();
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::converse<Conversation>(data, size);
}
