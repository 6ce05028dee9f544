#include "vr_client/modes/mask_stream.h"

#include <gtest/gtest.h>

#include "stereo/math/rotation.h"
#include "tests/unit/client_modes/scripted_link.h"
#include "vr_client/modes/masks.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using modes_test::kEye;
using modes_test::ScriptedLink;
using Part = ScriptedLink::Part;

constexpr Duration kPeriod = 10ms;
constexpr AnswerSpec kMasks{.kind = Answer::Masks};

/// A client whose head turns slowly from frame to frame.
struct Client {
  explicit Client(const MaskPolicy& policy = {.pace = Pace::Real, .round_trip = 20ms},
                  const RequestSettings& request = {})
      : mask_stream(&link, policy, request) {
    settings.request = request;
  }

  /// Begins frame `number` and sends its request.
  std::optional<FrameRequest> ask(std::uint32_t number, const AnswerSpec& answer = kMasks) {
    shown = {FrameId{number}, Time(kPeriod * number), Time(kPeriod * number), {}, settings.lights};
    for (View& view : shown.views) view = {{}, {-0.7, 0.7, 0.6, -0.6}, kEye};
    for (View& view : shown.views) view.stage_from_eye.rotation = rotation_exp({0, 0.01 * number, 0});
    std::optional<FrameRequest> request = mask_stream.plan(inputs(), answer);
    if (request) mask_stream.send(inputs(), *request);
    return request;
  }
  /// The frames whose answers the current frame may use, newest first.
  std::vector<std::uint32_t> receive() {
    std::vector<std::uint32_t> frames;
    for (const RequestRecord* record : mask_stream.receive(inputs()))
      frames.push_back(record->request.frame.value);
    return frames;
  }
  [[nodiscard]] std::uint32_t settled() const {
    return mask_stream.settled() ? mask_stream.settled()->request.frame.value : 0;
  }
  /// The time between the current frame and the frame that its request is made for.
  [[nodiscard]] Duration lead() const { return link.sent.back().display_time - shown.display_time; }
  [[nodiscard]] FrameInputs inputs() const { return {shown, state, kPeriod, settings}; }

  ScriptedLink link;
  FrameSettings settings;
  SceneState state;
  FrameMoment shown;
  MaskStream mask_stream;
};

/// If everything that a request asked for was lost on the way to the server, its answer is a report alone.
TEST(MaskStream, AReportAloneEndsTheWaitOfVirtualTime) {
  Client client({.pace = Pace::Virtual, .delay = 20ms});
  client.link.on_wait = [&](FrameId frame) { client.link.deliver(frame, Part::Report); };
  client.ask(1);
  client.receive();
  EXPECT_LE(client.link.waited, 1500ms);
  client.ask(2);
  client.receive();
  EXPECT_GT(client.link.waited, 1500ms) << "the client goes on to wait for a server that answers";
}

TEST(MaskStream, SendsWhatItHasPlanned) {
  Client client;
  const std::optional<FrameRequest> request = client.ask(1);
  ASSERT_TRUE(request);
  ASSERT_EQ(client.link.sent.size(), 1u);
  EXPECT_EQ(client.link.sent[0].views, request->views);
  EXPECT_EQ(client.link.sent[0].answer, kMasks);
  const RequestRecord* const record = client.mask_stream.record(request->frame);
  ASSERT_NE(record, nullptr);
  EXPECT_EQ(record->origin.requested_at, client.shown.display_time) << "not the time it is predicted for";
}

TEST(MaskStream, WithoutALinkAsksAndReceivesNothing) {
  const FrameSettings settings;
  const SceneState state;
  const FrameRequest shown{{FrameId{1}, {}, {}, {}, {}}};
  const FrameInputs inputs{shown, state, kPeriod, settings};
  MaskStream mask_stream(nullptr, {}, {});
  EXPECT_FALSE(mask_stream.plan(inputs, kMasks));
  EXPECT_TRUE(mask_stream.receive(inputs).empty());
  EXPECT_EQ(mask_stream.settled(), nullptr);
  EXPECT_EQ(mask_stream.record(shown.frame), nullptr);
}

/// The views that an answer of this kind is requested for, by a client whose head turns while answers are
/// five frames late.
std::vector<FrameRequest> requested_while_turning(Answer answer, std::uint32_t most_pixels = 1 << 20) {
  Client client({.pace = Pace::Real, .round_trip = 20ms}, {.predictor = PredictorKind::Hold});
  client.link.welcome({.most_pixels = most_pixels});
  for (std::uint32_t i = 1; i <= 40; ++i) {
    client.ask(i, {.kind = answer});
    if (i > 5) client.mask_stream.drawn_with(client.inputs(), *client.link.receiver().find({i - 5}));
  }
  return client.link.sent;
}

TEST(MaskStream, AsksForAGuardBandUnlessAGBufferIsShaded) {
  EXPECT_EQ(requested_while_turning(Answer::GBuffer).back().views[0].size, kEye);
  for (const Answer answer : {Answer::Masks, Answer::MasksOfPositions, Answer::Video, Answer::Difference}) {
    const Extent requested = requested_while_turning(answer).back().views[0].size;
    EXPECT_GT(requested.width, kEye.width) << static_cast<int>(answer);
    EXPECT_LE(requested.width, largest_traced(kEye).width) << static_cast<int>(answer);
    EXPECT_LE(requested.height, largest_traced(kEye).height) << static_cast<int>(answer);
  }
}

/// Each new size costs a key frame.
TEST(MaskStream, PicturesChangeTheirSizeSeldom) {
  const std::vector<FrameRequest> sent = requested_while_turning(Answer::Video);
  std::size_t changes = 0;
  for (std::size_t i = 1; i < sent.size(); ++i) changes += sent[i].views[0].size != sent[i - 1].views[0].size;
  EXPECT_LE(changes, 2u);
}

TEST(MaskStream, KeepsTheGuardBandWithinWhatTheServerTraces) {
  constexpr auto none = static_cast<std::uint32_t>(kEye.pixels()), some = none + 16 * kEye.height;
  for (const Answer answer : {Answer::Masks, Answer::Video}) {
    EXPECT_EQ(requested_while_turning(answer, none).back().views[0].size, kEye);
    const Extent requested = requested_while_turning(answer, some).back().views[0].size;
    EXPECT_LE(requested.pixels(), some);
    EXPECT_GT(requested.width, kEye.width) << "as much as fits";
  }
}

TEST(MaskStreamSettled, IsTheNewestAnswerThatIsAsCompleteAsItWillBe) {
  Client client;
  for (std::uint32_t i = 1; i <= 4; ++i) client.ask(i);
  EXPECT_EQ(client.receive(), (std::vector<std::uint32_t>{}));
  EXPECT_EQ(client.settled(), 0u);
  client.link.deliver({1}, Part::FirstSlice);
  EXPECT_EQ(client.receive(), (std::vector<std::uint32_t>{1}));
  EXPECT_EQ(client.settled(), 1u) << "a part is better than nothing";
  client.link.deliver({1}, Part::All);
  client.link.deliver({2}, Part::FirstSlice);
  EXPECT_EQ(client.receive(), (std::vector<std::uint32_t>{2, 1}));
  EXPECT_EQ(client.settled(), 1u) << "the slices of 2 are arriving";
  client.link.deliver({2}, Part::All);
  client.receive();
  EXPECT_EQ(client.settled(), 2u);
}

// On a path that loses slices of every answer.
TEST(MaskStreamSettled, IsTheNewestOvertakenOrReportedAnswerIfNoneIsEverComplete) {
  Client client;
  for (std::uint32_t i = 1; i <= 5; ++i) client.ask(i);
  for (std::uint32_t i = 1; i <= 3; ++i) client.link.deliver({i}, Part::FirstSlice);
  client.receive();
  EXPECT_EQ(client.settled(), 2u) << "3 may still be arriving";
  client.link.deliver({3}, Part::Report);
  client.receive();
  EXPECT_EQ(client.settled(), 3u) << "the report was sent after the slices";
}

TEST(MaskStreamLatency, IsMeasuredWhenAnAnswerIsComplete) {
  // The first slice of an answer comes two frames after the request, the rest one frame later.
  Client client({.pace = Pace::Real, .round_trip = kPeriod});
  for (std::uint32_t i = 1; i <= 60; ++i) {
    client.ask(i);
    if (i > 2) client.link.deliver({i - 2}, Part::FirstSlice);
    if (i > 3) client.link.deliver({i - 3}, Part::All);
    client.receive();
  }
  EXPECT_EQ(client.lead(), 3 * kPeriod);
}

TEST(MaskStreamLatency, IsMeasuredOnceForEachAnswer) {
  Client client({.pace = Pace::Real, .round_trip = kPeriod});
  for (std::uint32_t i = 1; i <= 10; ++i) {
    client.ask(i);
    if (i > 1) client.link.deliver({i - 1}, Part::All);
    client.receive();
  }
  // An answer that is used for a hundred more frames does not count again.
  client.settings.request.every = 1000;
  for (std::uint32_t i = 11; i <= 110; ++i) {
    client.ask(i);
    client.receive();
  }
  client.settings.request.every = 1;
  client.ask(111);
  EXPECT_EQ(client.lead(), kPeriod);
}

TEST(MaskStreamVirtual, UsesWhatTheDelayAllows) {
  Client client({.pace = Pace::Virtual, .delay = 2 * kPeriod});
  client.link.on_wait = [&](FrameId frame) { client.link.deliver(frame, Part::All); };
  std::vector<std::uint32_t> usable;
  for (std::uint32_t i = 1; i <= 6; ++i) {
    client.ask(i);
    usable = client.receive();
  }
  EXPECT_EQ(usable, (std::vector<std::uint32_t>{4, 3, 2, 1}));
  EXPECT_EQ(client.settled(), 4u);
  EXPECT_EQ(client.lead(), 2 * kPeriod);
}

TEST(MaskStreamVirtual, MaskWaitMakesYoungerAnswersUsable) {
  Client client({.pace = Pace::Virtual, .delay = 2 * kPeriod, .mask_wait = kPeriod});
  client.link.on_wait = [&](FrameId frame) { client.link.deliver(frame, Part::All); };
  std::vector<std::uint32_t> usable;
  for (std::uint32_t i = 1; i <= 6; ++i) {
    client.ask(i);
    usable = client.receive();
  }
  EXPECT_EQ(usable.front(), 5u);
  EXPECT_EQ(client.lead(), kPeriod);
}

TEST(MaskStreamVirtual, WaitsForAServerThatDoesNotAnswerOnceOnly) {
  Client client({.pace = Pace::Virtual, .delay = kPeriod});
  client.ask(1);
  client.receive();
  EXPECT_GE(client.link.waited, 5s) << "the first answer may take long";
  client.link.waited = {};
  for (std::uint32_t i = 2; i <= 10; ++i) {
    client.ask(i);
    client.receive();
  }
  EXPECT_EQ(client.link.waited, 0s);
  // The server answers again, late, so the client waits for the next answer.
  client.link.deliver({10}, Part::All);
  client.ask(11);
  client.receive();
  client.ask(12);
  client.receive();
  EXPECT_GE(client.link.waited, 5s);
}

/// A pause of half a second within an answer does not end it.
TEST(MaskStreamVirtual, WaitsForTheRestOfAnAnswerThatGoesOn) {
  Client client({.pace = Pace::Virtual, .delay = kPeriod});
  int waits = 0;
  client.link.on_wait = [&](FrameId frame) {
    client.link.deliver(frame, ++waits < 6 ? Part::FirstSlice : Part::All);
  };
  client.ask(1);
  client.receive();
  EXPECT_TRUE(client.link.receiver().find({1})->complete());
}

TEST(MaskStreamVirtual, DoesNotWaitForTheRestOfAnAnswerThatHasStopped) {
  Client client({.pace = Pace::Virtual, .delay = kPeriod});
  client.link.on_wait = [&](FrameId frame) { client.link.deliver(frame, Part::FirstSlice); };
  client.ask(1);
  client.receive();
  EXPECT_LE(client.link.waited, 1200ms) << "a second without a new slice";
}

TEST(MaskStreamReal, WaitsNoLongerThanTheMaskWait) {
  Client client({.pace = Pace::Real, .round_trip = 20ms, .mask_wait = 4ms});
  client.ask(1);
  client.receive();
  EXPECT_EQ(client.link.waited, 4ms);
}

TEST(MaskStreamGuardBand, LearnsFromTheMasksThatFramesAreDrawnWith) {
  const auto width = [](std::uint32_t late) {
    Client client({.pace = Pace::Real, .round_trip = 20ms});
    for (std::uint32_t i = 1; i <= 60; ++i) {
      client.ask(i);
      if (i > late) client.mask_stream.drawn_with(client.inputs(), *client.link.receiver().find({i - late}));
    }
    return client.link.sent.back().views[0].size.width;
  };
  EXPECT_GT(width(12), width(2)) << "masks that come ten frames late need a wider band";
}

struct Sources : Client {
  MaskSources sources{false};
  std::vector<std::uint32_t> take() {
    const auto usable = mask_stream.receive(inputs());
    sources.take(usable, mask_stream.settled());
    std::vector<std::uint32_t> frames;
    for (const TracedMask& mask : sources.masks()) frames.push_back(mask.frame.value);
    return frames;
  }
};

TEST(MaskSources, TrustTheNewestCompleteMaskFirst) {
  Sources client;
  for (std::uint32_t i = 1; i <= 5; ++i) client.ask(i);
  client.link.deliver({1}, Part::All);
  client.link.deliver({2}, Part::All);
  client.link.deliver({3}, Part::All);
  EXPECT_EQ(client.take(), (std::vector<std::uint32_t>{3, 2, 1}));
  client.link.deliver({4}, Part::FirstSlice);
  EXPECT_EQ(client.take(), (std::vector<std::uint32_t>{3, 4, 2, 1})) << "4 fills in what 3 does not know";
  client.link.deliver({4}, Part::All);
  EXPECT_EQ(client.take(), (std::vector<std::uint32_t>{4, 3, 2, 1}));
}

TEST(MaskSources, TellWhenTheBitsOfAMaskChange) {
  Sources client;
  client.ask(1);
  client.link.deliver({1}, Part::FirstSlice);
  client.take();
  const std::uint64_t part = client.sources.masks()[0].content;
  client.link.deliver({1}, Part::All);
  client.take();
  EXPECT_NE(client.sources.masks()[0].content, part);
}

TEST(MaskSources, AreReadDirectlyWhereTheFirstIsExact) {
  Sources client;
  client.settings.request.predictor = PredictorKind::Hold;
  client.settings.request.guard_band = GuardBandUse::Off;
  const auto lookup = [&](const FrameMoment& shown) {
    return client.sources.lookup(shown, Lookup::Reproject);
  };
  client.ask(1);
  EXPECT_EQ(lookup(client.shown), Lookup::Reproject) << "no mask";
  client.link.deliver({1}, Part::FirstSlice);
  client.take();
  EXPECT_EQ(lookup(client.shown), Lookup::Reproject) << "a part of it";
  client.link.deliver({1}, Part::All);
  client.take();
  EXPECT_EQ(lookup(client.shown), Lookup::Direct);
  FrameMoment other = client.shown;
  other.scene_time += 1s;
  EXPECT_EQ(lookup(other), Lookup::Direct) << "nothing is animated";
  EXPECT_EQ(MaskSources(true).lookup(other, Lookup::Reproject), Lookup::Reproject);
  MaskSources animated(true);
  animated.take(client.mask_stream.receive(client.inputs()), client.mask_stream.settled());
  EXPECT_EQ(animated.lookup(other, Lookup::Reproject), Lookup::Reproject) << "another scene time";
  EXPECT_EQ(animated.lookup(client.shown, Lookup::Reproject), Lookup::Direct);
  other = client.shown;
  other.views[1].stage_from_eye.translation.x += 0.1;
  EXPECT_EQ(lookup(other), Lookup::Reproject) << "the right eye has moved";
  other = client.shown;
  change(other.lights, 0, false, std::nullopt);
  EXPECT_EQ(lookup(other), Lookup::Reproject) << "another light set";
}

}  // namespace
}  // namespace farshade
