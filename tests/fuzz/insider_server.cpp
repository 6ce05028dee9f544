// A client, and a server that holds the client's key and says what it likes: any bytes sealed for the
// session, genuine answers that are changed, counters that jump. The input is a list of steps in virtual
// time. After each step the client's records fit their requests. Afterwards the client must still send
// requests and assemble the answer to the next one bit for bit, unless the server said that its key is
// revoked or expired: then the client must be silent.
#include "stereo/codec/mask_block.h"
#include "stereo/codec/plane_codec.h"
#include "tests/fuzz/attacked_link.h"
#include "tests/support/manual_clock.h"
#include "tests/unit/hostile_server.h"

using namespace farshade;
using namespace std::chrono_literals;
using fuzz::Bytes;

namespace {

constexpr std::size_t kFrames = Assembler::kKept + 2;

Bytes encoded(const ServerMessage& message) {
  Bytes bytes;
  encode(message, bytes);
  return bytes;
}

/// All tiles of one plane of a G-buffer.
Bytes plane_of(FrameId frame) {
  PixelPlane plane({18, 10}, 3);
  for (std::size_t i = 0; i < plane.words.size(); ++i) plane.words[i] = static_cast<std::uint32_t>(37 * i);
  PlanePacker packer;
  packer.start(frame, Side::Left, PlaneKind::BaseColor, plane);
  return encoded(*packer.next());
}

/// The painted masks as one LZ4 block.
Bytes mask_block(FrameId frame) {
  ShadowFrame painted;
  fuzz::paint(fuzz::request(frame.value), painted);
  const Bytes block = pack_mask_block(painted);
  check(block.size() <= kVideoPart_bytes, "the block fits into one part");
  return encoded(VideoPart{.frame = frame, .after = frame, .bytes = block});
}

class Conversation {
 public:
  Conversation();
  void step(fuzz::Choices& choices);
  void finish();

 private:
  void ask(const AnswerSpec& answer);
  void say(std::span<const std::byte> message, std::optional<std::uint64_t> counter = {});
  [[nodiscard]] std::vector<Bytes> honest_answer() const;
  [[nodiscard]] Bytes genuine(fuzz::Choices& choices) const;
  void check_client() const;
  void check_silence();

  ManualClock clock_;
  VirtualLink wire_{clock_, {}};
  SharedKey key_ = fuzz::key_named("desk");
  link_test::HostileServer server_{wire_.server(), key_, fuzz::kServed};
  NetworkLink link_{wire_.client(),
                    clock_,
                    {wire_.server().local(), key_, fuzz::kServed.scene_hash, {fuzz::kServed.light_count}},
                    kFrames};
  std::uint32_t frame_ = 0;
  bool key_ended_ = false;  ///< the server has told so in a session of the client
};

/// Whether the message, if it is one, tells the client that its key is no longer good.
bool ends_key(std::span<const std::byte> message) {
  const Decoded<ServerMessage> decoded = decode_server(message);
  if (!decoded) return false;
  const auto* const goodbye = std::get_if<Goodbye>(&*decoded);
  return goodbye != nullptr &&
         (goodbye->reason == EndReason::Revoked || goodbye->reason == EndReason::Expired);
}

Conversation::Conversation() {
  wire_.while_waiting([this] { server_.serve(); });
  check(link_.connect(1s).has_value(), "whoever has the key can be a server");
  ask({});
}

void Conversation::ask(const AnswerSpec& answer) {
  if (key_ended_) return check_silence();
  FrameRequest request = fuzz::request(++frame_);
  request.answer = answer;
  if (is_video(answer.kind)) {
    request.answer.bits_per_second = kLeastVideo_bits;
    request.answer.interval = 10ms;
  }
  const std::uint64_t before = server_.requests(), sessions = server_.sessions();
  link_.request(request, request.display_time);
  server_.serve();
  if (server_.sessions() != sessions) {
    // After a silence the client has said hello, and this server forgets the session before.
    link_.poll();
    request.frame = {++frame_};
    link_.request(request, request.display_time);
    server_.serve();
  }
  check_eq(server_.requests(), before + 1, "requests: each is sent, whatever the server said");
  check(server_.request()->arrivals.count <= ArrivalReport::kMost, "and its report fits");
}

void Conversation::say(std::span<const std::byte> message, std::optional<std::uint64_t> counter) {
  link_.poll();
  const bool in_session = link_.last_received().has_value();
  server_.say(message, counter);
  link_.poll();
  key_ended_ = key_ended_ || (in_session && ends_key(message));
}

/// The messages that a genuine server would answer the newest request with, if it is for masks.
std::vector<Bytes> Conversation::honest_answer() const {
  ShadowFrame painted;
  fuzz::paint(fuzz::request(frame_), painted);
  std::vector<Bytes> messages;
  for (const Side side : kSides) {
    SlicePacker packer;
    packer.start(painted, side);
    while (const std::optional<Slice> slice = packer.next()) messages.push_back(encoded(*slice));
  }
  messages.push_back(encoded(FrameReport{.frame = {frame_}, .view_scale = kFullViewScale}));
  return messages;
}

Bytes Conversation::genuine(fuzz::Choices& choices) const {
  const FrameId frame{frame_ - choices.up_to(2)};
  const std::array block{std::byte{static_cast<std::uint8_t>(choices.up_to(255))}};
  switch (choices.up_to(6)) {
    case 0:
      return encoded(Probe{1 + choices.up_to(3)});
    case 1:
      return plane_of(frame);
    case 2:
      return encoded(VideoPart{.frame = frame, .after = frame, .bytes = block});
    case 3:
      return encoded(FrameReport{.frame = frame, .view_scale = {1 + choices.up_to(7)}});
    case 4:
      return encoded(fuzz::kServed);
    case 6:
      return mask_block(frame);
    default:
      return honest_answer()[choices.up_to(1)];
  }
}

void Conversation::step(fuzz::Choices& choices) {
  enum Step : std::uint32_t { Say, Change, Repeat, Jump, Ask, Pass, kSteps };
  const std::uint32_t kind = choices.up_to(kSteps - 1);
  if (kind == Say) {
    say(choices.bytes(choices.up_to(255)));
  } else if (kind == Change) {
    const Bytes message = genuine(choices);
    const std::uint32_t most = choices.up_to(4);
    Bytes changed = fuzz::edited(message, choices, most);
    if (changed.size() > kMaxMessage_bytes) changed.resize(kMaxMessage_bytes);
    say(changed);
  } else if (kind == Repeat) {
    const Bytes message = genuine(choices);
    for (std::uint32_t times = choices.up_to(16); times > 0; --times) say(message);
  } else if (kind == Jump) {
    const std::uint64_t far = std::uint64_t{1} << choices.up_to(63);
    say(encoded(Probe{1}), choices.up_to(1) == 1 ? 2 * far - 1 : far);
  } else if (kind == Ask) {
    const std::array<AnswerSpec, 4> answers{
        {{}, {.kind = Answer::GBuffer}, {.kind = Answer::Video}, {.coding = Coding::Lz4}}};
    ask(answers[choices.up_to(answers.size() - 1)]);
  } else {
    link_.listen(std::chrono::milliseconds(choices.up_to(255)));
  }
  check_client();
}

void Conversation::check_client() const {
  for (const RequestRecord* record : link_.receiver().received(Time::max())) {
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const EyeMask& mask = record->masks[eye];
      check(record->tiles_known[eye] <= record->tiles_requested[eye] * mask.layout().planes(),
            "tiles count once");
      for (std::uint32_t y = 0; y < mask.size().height; ++y)
        for (std::uint32_t x = 0; x < mask.size().width; ++x)
          check((mask.word(x, y, 0) & ~mask.layout().used_bits(0)) == 0, "no bit is set without a light");
    }
    const Answer kind = record->request.answer.kind;
    check(kind == Answer::GBuffer || record->gbuffer.tiles_known == 0, "planes come of a request for them");
    const bool is_block = record->request.answer.coding == Coding::Lz4;
    check(is_video(kind) || is_block || record->video.parts_known == 0, "video comes of a request for it");
    check(!is_block || record->complete(), "a block of masks is known as a whole");
    check(record->gbuffer.tiles_known <= record->gbuffer.tiles, "tiles of planes count once");
    check(record->video.parts_known <= record->video.known.size(), "parts count once");
    check(record->video.unit.size() <= kMostVideoParts * kVideoPart_bytes, "a unit is bounded");
  }
  check(link_.receiver().view_scale() <= kFullViewScale, "views grow to full size at most");
  check_eq(link_.refused().has_value(), key_ended_, "refused: by the word of a server with the key");
  check(link_.counters().sessions <= server_.sessions(), "a session begins with a handshake");
}

/// A client whose key is no longer good says nothing, whatever it is told to do.
void Conversation::check_silence() {
  const std::uint64_t requests = server_.requests(), sessions = server_.sessions();
  link_.request(fuzz::request(++frame_), {});
  link_.keep_alive();
  server_.serve();
  check(server_.requests() == requests && server_.sessions() == sessions, "a refused client is silent");
}

void Conversation::finish() {
  if (key_ended_) return check_silence();
  ask({.coding = Coding::Lz4});
  say(mask_block({frame_}));
  ShadowFrame block;
  fuzz::paint(fuzz::request(frame_), block);
  check(link_.receiver().find({frame_})->masks == block.masks, "the next block opens");
  ask({});
  for (const Bytes& message : honest_answer()) say(message);
  check(link_.wait_for({frame_}, 1ms), "the next answer comes whole");
  ShadowFrame painted;
  fuzz::paint(fuzz::request(frame_), painted);
  check(link_.receiver().find({frame_})->masks == painted.masks, "and bit for bit");
  check_client();
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::converse<Conversation>(data, size);
}
