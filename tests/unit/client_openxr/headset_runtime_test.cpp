#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <thread>
#include <utility>

#include "stereo/gpu/frame_commands.h"
#include "stereo/math/rotation.h"
#include "tests/unit/client_openxr/fake_headset.h"

namespace farshade::openxr {
namespace {

namespace fake = fake_openxr;
using Calls = std::vector<std::string>;

const Calls kFrameCalls{"xrWaitFrame",
                        "xrBeginFrame",
                        "xrLocateViews",  // to know whether the head is seen
                        "xrLocateViews",
                        "xrAcquireSwapchainImage",
                        "xrWaitSwapchainImage",
                        "xrAcquireSwapchainImage",
                        "xrWaitSwapchainImage",
                        "xrReleaseSwapchainImage",
                        "xrReleaseSwapchainImage",
                        "xrEndFrame"};

/// Both eyes of a head that looks ahead and moves to the right by 0.1 m in each frame.
fake::Frame moving(XrTime time) {
  fake::Frame frame;
  const auto moved_m = static_cast<float>(static_cast<double>(time) * 1e-8);
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    frame.views[eye].pose.position = {moved_m + (eye == 0 ? -0.03f : 0.03f), 1.6f, 0.2f};
  return frame;
}

/// The middle of the eyes, metres.
glm::dvec3 middle(const StereoView& views) {
  return (views[0].stage_from_eye.translation + views[1].stage_from_eye.translation) * 0.5;
}

XrEventDataReferenceSpaceChangePending recentre(XrSession session, XrTime at,
                                                XrReferenceSpaceType type = XR_REFERENCE_SPACE_TYPE_STAGE) {
  return {XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING,
          nullptr,
          session,
          type,
          at,
          XR_FALSE,
          {{0, 0, 0, 1}, {0, 0, 0}}};
}

class HeadsetFrames : public FakeHeadset {};

/// The field of view is asymmetric and changes from frame to frame, and the eyes turn.
fake::Frame turning(XrTime time) {
  const auto step = static_cast<float>(static_cast<double>(time % 1'000'000'000) * 1e-9);
  fake::Frame frame;
  frame.views[0].fov = {-0.9f - step, 0.7f, 0.8f + step, -0.85f};
  frame.views[1].fov = {-0.65f, 0.95f + step, 0.75f, -0.9f - step};
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const glm::dquat rotation = rotation_exp({0.3 * step, 0, eye == 0 ? step : -step});
    frame.views[eye].pose = {{static_cast<float>(rotation.x), static_cast<float>(rotation.y),
                              static_cast<float>(rotation.z), static_cast<float>(rotation.w)},
                             {eye == 0 ? -0.03f : 0.03f, 1.5f + step, -step}};
  }
  return frame;
}

/// The head is placed at the start, 2 m beside where it is, and not turned.
TEST_F(HeadsetFrames, HaveTheFovAndPoseThatTheRuntimeGivesThem) {
  fake->frame = turning;
  HeadsetSetup at = setup();
  at.start.translation = {2, 1.5, 0};
  ASSERT_TRUE(open(std::move(at))) << error;
  show_until(6);
  ASSERT_EQ(shown.size(), 6u);
  const glm::dvec3 placed = shown[0][0].stage_from_eye.translation - glm::dvec3(-0.03f, 1.5f, 0);
  for (std::size_t frame = 0; frame < shown.size(); ++frame)
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const XrTime time = fake->first_time + static_cast<XrTime>(frame) * fake->period;
      const fake::View given = turning(time).views[eye];
      const farshade::View& view = shown[frame][eye];
      EXPECT_EQ(view.fov,
                (EyeFov{given.fov.angleLeft, given.fov.angleRight, given.fov.angleUp, given.fov.angleDown}));
      EXPECT_EQ(view.size, kEyeSize);
      const XrPosef& pose = given.pose;
      const glm::dquat rotation(pose.orientation.w, pose.orientation.x, pose.orientation.y,
                                pose.orientation.z);
      EXPECT_LT(angle_between_rad(view.stage_from_eye.rotation, glm::normalize(rotation)), 1e-9);
      const glm::dvec3 position(pose.position.x, pose.position.y, pose.position.z);
      EXPECT_LT(glm::length(view.stage_from_eye.translation - (position + placed)), 1e-9);
    }
  EXPECT_NEAR(middle(shown[0]).x, 2, 1e-6);
  EXPECT_NEAR(middle(shown[0]).y, 1.5, 1e-6);
}

/// The compositor gets what it has given, to the precision of floats.
TEST_F(HeadsetFrames, SubmitTheViewsThatTheyWereDrawnFor) {
  fake->frame = turning;
  HeadsetSetup at = setup();
  at.start = {rotation_exp({0, 1, 0}), {2, 1.5, 0}};
  ASSERT_TRUE(open(std::move(at))) << error;
  show_until(3);
  ASSERT_EQ(fake->frames.size(), 3u);
  for (const fake::SubmittedFrame& frame : fake->frames) {
    ASSERT_EQ(frame.views.size(), kEyes);
    for (std::uint32_t eye = 0; eye < kEyes; ++eye) {
      const fake::View given = turning(frame.time).views[eye];
      const fake::SubmittedView& view = frame.views[eye];
      EXPECT_EQ(std::memcmp(&view.fov, &given.fov, sizeof given.fov), 0);
      EXPECT_EQ(std::memcmp(&view.pose.position, &given.pose.position, sizeof given.pose.position), 0);
      EXPECT_NEAR(view.pose.orientation.x, given.pose.orientation.x, 1e-6);
      EXPECT_NEAR(view.pose.orientation.z, given.pose.orientation.z, 1e-6);
      EXPECT_EQ(view.picture.imageArrayIndex, eye);
      EXPECT_EQ(view.picture.imageRect.extent.width, static_cast<int>(kEyeSize.width));
      EXPECT_EQ(view.picture.imageRect.extent.height, static_cast<int>(kEyeSize.height));
    }
  }
}

/// The head moves by 0.25 m after the frame has begun.
TEST_F(HeadsetFrames, SubmitTheViewsThatWereLocatedLast) {
  float moved_m = 0;
  bool is_seen = true;
  fake->frame = [&](XrTime) {
    fake::Frame frame;
    for (fake::View& view : frame.views) view.pose.position.x = moved_m;
    frame.is_tracked = is_seen;
    return frame;
  };
  ASSERT_TRUE(open(setup())) << error;
  const Time time = runtime->wait_frame().value().display_time;
  const StereoView first = runtime->locate_views(time);
  moved_m = 0.25f;
  const StereoView second = runtime->locate_views(time);
  EXPECT_NEAR(middle(second).x - middle(first).x, 0.25, 1e-9);
  moved_m = 9;
  is_seen = false;
  EXPECT_EQ(runtime->locate_views(time), second) << "the head is not seen any more";
  submit(time);
  ASSERT_EQ(fake->frames.size(), 1u);
  for (const fake::SubmittedView& view : fake->frames[0].views) EXPECT_EQ(view.pose.position.x, 0.25f);
}

TEST_F(HeadsetFrames, MakeTheirCallsInTheOrderOfTheSpecification) {
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  for (int frame = 0; frame < 5; ++frame) {
    fake->calls.clear();
    ASSERT_TRUE(show());
    EXPECT_EQ(fake->calls, kFrameCalls);
  }
}

TEST_F(HeadsetFrames, HaveNoLayerIfTheRuntimeShowsNothing) {
  fake->frame = [this](XrTime time) {
    fake::Frame frame;
    frame.should_render = time >= fake->first_time + 3 * fake->period;
    return frame;
  };
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  ASSERT_EQ(fake->frames.size(), 4u);
  for (std::size_t frame = 0; frame < 4; ++frame)
    EXPECT_EQ(fake->frames[frame].views.empty(), frame < 3) << frame;
  EXPECT_EQ(fake->counts["xrLocateViews"], 2u);
  EXPECT_EQ(fake->counts["xrAcquireSwapchainImage"], 2u);
  EXPECT_EQ(runtime->counters().empty, 3u);
  EXPECT_EQ(runtime->counters().submitted, 1u);
}

TEST_F(HeadsetFrames, HaveNoLayerIfTheRuntimeDoesNotKnowWhereTheHeadIs) {
  fake->frame = [this](XrTime time) {
    fake::Frame frame;
    frame.is_tracked = time >= fake->first_time + 2 * fake->period;
    return frame;
  };
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  ASSERT_EQ(fake->frames.size(), 3u);
  EXPECT_TRUE(fake->frames[0].views.empty());
  EXPECT_TRUE(fake->frames[1].views.empty());
}

/// Some runtimes say so of a pose of zeros before they have measured one.
TEST_F(HeadsetFrames, HaveNoLayerIfWhatTheRuntimeCallsAValidPoseIsNone) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::array<XrPosef, 5> poses{XrPosef{{0, 0, 0, 0}, {0, 1, 0}}, XrPosef{{0, 0, 0, 1e-9f}, {0, 1, 0}},
                                     XrPosef{{kNan, 0, 0, 1}, {0, 1, 0}}, XrPosef{{0, 0, 0, 1}, {0, kNan, 0}},
                                     XrPosef{{0, 0, 0, 1e30f}, {0, 1, 0}}};
  fake->frame = [&](XrTime time) {
    fake::Frame frame;
    const auto number = static_cast<std::size_t>((time - fake->first_time) / fake->period);
    if (number < poses.size()) frame.views[number % 2].pose = poses[number];
    return frame;
  };
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  ASSERT_EQ(fake->frames.size(), poses.size() + 1);
  for (std::size_t i = 0; i <= poses.size(); ++i)
    EXPECT_EQ(fake->frames[i].views.empty(), i < poses.size()) << i;
  EXPECT_FALSE(std::isnan(middle(shown[0]).x + shown[0][0].stage_from_eye.rotation.w));
}

/// The displays of some headsets are turned outwards.
TEST_F(HeadsetFrames, PlaceTheHeadByTheMiddleOfBothEyes) {
  constexpr double kTurn_rad = 0.2;
  fake->frame = [](XrTime) {
    fake::Frame frame;
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      const glm::dquat rotation = rotation_exp({0, eye == 0 ? kTurn_rad : -kTurn_rad, 0});
      frame.views[eye].pose.orientation = {0, static_cast<float>(rotation.y), 0,
                                           static_cast<float>(rotation.w)};
    }
    return frame;
  };
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  EXPECT_NEAR(heading_rad(shown[0][0].stage_from_eye.rotation), kTurn_rad, 1e-6);
  EXPECT_NEAR(heading_rad(shown[0][1].stage_from_eye.rotation), -kTurn_rad, 1e-6);
}

class HeadsetRecentring : public FakeHeadset {
 protected:
  /// The space in use is of type `used`.
  void expect_only(XrReferenceSpaceType used, XrReferenceSpaceType other) {
    fake->frame = moving;
    ASSERT_TRUE(open(setup())) << error;
    ASSERT_TRUE(show());
    for (const XrReferenceSpaceType type : {other, XR_REFERENCE_SPACE_TYPE_VIEW})
      fake->push(recentre(fake->session, fake->first_time, type));
    ASSERT_TRUE(show());
    EXPECT_NEAR(middle(shown[1]).x, 0.1, 1e-5);
    fake->push(recentre(fake->session, fake->first_time, used));
    ASSERT_TRUE(show());
    EXPECT_NEAR(middle(shown[2]).x, 0, 1e-5);
  }
};

TEST_F(HeadsetRecentring, TakesEffectAtTheTimeThatTheEventNames) {
  fake->frame = moving;
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  fake->push(recentre(fake->session, fake->first_time + 3 * fake->period));
  show_until(6);
  ASSERT_EQ(shown.size(), 6u);
  constexpr std::array kMoved_m{0.0, 0.1, 0.2, 0.0, 0.1, 0.2};
  for (std::size_t frame = 0; frame < shown.size(); ++frame)
    EXPECT_NEAR(middle(shown[frame]).x, kMoved_m[frame], 1e-5) << frame;
}

TEST_F(HeadsetRecentring, EachOfSeveralTakesEffect) {
  fake->frame = moving;
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  fake->push(recentre(fake->session, fake->first_time + 4 * fake->period));
  fake->push(recentre(fake->session, fake->first_time + 2 * fake->period));
  show_until(6);
  constexpr std::array kMoved_m{0.0, 0.1, 0.0, 0.1, 0.0, 0.1};
  for (std::size_t frame = 0; frame < shown.size(); ++frame)
    EXPECT_NEAR(middle(shown[frame]).x, kMoved_m[frame], 1e-5) << frame;
}

/// A runtime sends the event for each type of space. Only that of the space in use moves what it measures.
TEST_F(HeadsetRecentring, OfAnotherSpaceThanTheStageHasNoEffectOnIt) {
  expect_only(XR_REFERENCE_SPACE_TYPE_STAGE, XR_REFERENCE_SPACE_TYPE_LOCAL);
}

TEST_F(HeadsetRecentring, OfAnotherSpaceThanTheLocalOneHasNoEffectOnIt) {
  fake->spaces = {XR_REFERENCE_SPACE_TYPE_LOCAL};
  expect_only(XR_REFERENCE_SPACE_TYPE_LOCAL, XR_REFERENCE_SPACE_TYPE_STAGE);
}

TEST_F(HeadsetRecentring, OfAnotherSessionHasNoEffect) {
  fake->frame = moving;
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  fake->push(recentre(XR_NULL_HANDLE, fake->first_time));
  ASSERT_TRUE(show());
  EXPECT_NEAR(middle(shown[1]).x, 0.1, 1e-5);
}

class HeadsetSessions : public FakeHeadset {
 protected:
  /// The headset was taken off, or another program was started.
  void stop_session() const {
    for (const XrSessionState state :
         {XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_STOPPING})
      fake->push(state);
  }
};

TEST_F(HeadsetSessions, EndAsTheSpecificationAsksFor) {
  ASSERT_TRUE(open(setup())) << error;
  show_until(2);
  finish();
  EXPECT_EQ(error, "");
  EXPECT_EQ(runtime->history(),
            "idle, ready, synchronized, visible, focused, visible, synchronized, stopping");
  EXPECT_EQ(fake->counts["xrRequestExitSession"], 1u);
  EXPECT_EQ(fake->counts["xrEndSession"], 1u);
}

/// The session is bound to the device.
TEST_F(HeadsetSessions, GoOnWithAnotherDeviceInThePlaceOfALostOne) {
  system = HeadsetSystem::open().value();
  ShownPictures own = make_pictures(*system).value();
  HeadsetSetup shows_own = setup();
  shows_own.depth = [&own] { return HeadsetDepth{own.depth, 0}; };
  runtime = system->open_runtime(own.device, own.shown, std::move(shows_own)).value();
  const auto show_frames = [&](int frames) {
    for (int i = 0; i < frames; ++i) {
      const Time time = runtime->wait_frame().value().display_time;
      static_cast<void>(runtime->locate_views(time));
      gpu::FrameCommands frame(own.device);
      runtime->add_output([&](const gpu::Recording& record) { frame.record(record); });
      frame.submit();
      runtime->end_frame(time);
    }
  };
  show_frames(3);
  // The runtime notices the loss first.
  fake->answers = {{"xrEndFrame", fake->counts["xrEndFrame"] + 1, XR_ERROR_RUNTIME_FAILURE}};
  show_frames(1);
  runtime->leave_device();
  EXPECT_EQ(fake->living.sessions, 0);
  static_cast<void>(std::exchange(own, make_pictures(*system).value()));
  runtime->take_device(own.shown);
  EXPECT_EQ(fake->living.sessions, 1);
  show_frames(3);
  EXPECT_EQ(fake->frames.size(), 6u);
  finish();
  EXPECT_EQ(error, "");
  EXPECT_EQ(own.device.validation_log->messages(), std::vector<std::string>{});
  runtime.reset();
}

/// For example a device that is lost again and again.
TEST_F(HeadsetSessions, EndIfThereIsNoOtherDevice) {
  ASSERT_TRUE(open(setup())) << error;
  show_until(2);
  runtime->leave_device();
  finish();
  EXPECT_EQ(error, "");
  EXPECT_EQ(fake->living.sessions, 0);
}

TEST_F(HeadsetSessions, StopAndStartAgain) {
  fake->frame = moving;
  HeadsetSetup patient = setup();
  patient.sleep = [this](Duration) {  // the headset is worn again
    if (fake->counts["xrEndSession"] == 1 && fake->counts["xrBeginSession"] == 1 && fake->events.empty())
      fake->push(XR_SESSION_STATE_READY);
  };
  ASSERT_TRUE(open(std::move(patient))) << error;
  show_until(2);
  stop_session();
  show_until(4);
  finish();
  EXPECT_EQ(error, "");
  ASSERT_EQ(shown.size(), 4u);
  EXPECT_EQ(fake->counts["xrCreateSession"], 1u);
  EXPECT_EQ(fake->counts["xrBeginSession"], 2u);
  EXPECT_EQ(fake->counts["xrEndSession"], 2u);
  EXPECT_NEAR(middle(shown[3]).x, 0.3, 1e-5) << "the head stays where it was placed";
}

TEST_F(HeadsetSessions, ThatTheRuntimeEndsEndTheClient) {
  ASSERT_TRUE(open(setup())) << error;
  show_until(2);
  stop_session();
  fake->before = [this](const std::string& call) {
    if (call == "xrEndSession") fake->push(XR_SESSION_STATE_EXITING);
  };
  show_until(10);
  finish();
  EXPECT_EQ(shown.size(), 2u);
  EXPECT_EQ(error, "");
}

TEST_F(HeadsetSessions, AreReplacedWhenTheyAreLostAlsoIfTheHeadsetHasANewId) {
  fake->frame = moving;
  ASSERT_TRUE(open(setup())) << error;
  show_until(3);
  fake->push(XR_SESSION_STATE_LOSS_PENDING);
  fake->system = 2;
  show_until(6);
  finish();
  EXPECT_EQ(error, "");
  ASSERT_EQ(shown.size(), 6u);
  EXPECT_EQ(fake->counts["xrCreateSession"], 2u);
  EXPECT_EQ(fake->counts["xrGetVulkanGraphicsRequirements2KHR"], 2u);
  EXPECT_NEAR(middle(shown[3]).x, 0, 1e-5) << "the head is placed again";
}

/// It goes for a second time when a session for it is made.
TEST_F(HeadsetSessions, AreWaitedForWhileTheHeadsetIsAway) {
  HeadsetSetup patient = setup();
  std::vector<Duration> sleeps;
  patient.sleep = [&](Duration span) {
    sleeps.push_back(span);
    if (sleeps.size() == 12) fake->system = 2;
  };
  ASSERT_TRUE(open(std::move(patient))) << error;
  show_until(3);
  sleeps.clear();
  fake->push(XR_SESSION_STATE_LOSS_PENDING);
  fake->system = XR_NULL_SYSTEM_ID;
  fake->before = [&](const std::string& call) {
    if (call == "xrCreateSession" && fake->counts[call] == 1) fake->system = 3;
  };
  show_until(5);
  finish();
  EXPECT_EQ(error, "");
  EXPECT_EQ(shown.size(), 5u);
  EXPECT_EQ(fake->counts["xrGetSystem"], 1u + 4u + 1u) << "asked every 0.5 s";
  EXPECT_EQ(fake->counts["xrCreateSession"], 3u);
  EXPECT_LE(*std::ranges::max_element(sleeps), std::chrono::milliseconds(100));
}

TEST_F(HeadsetSessions, AreNotWaitedForByAUserWhoWantsToEnd) {
  HeadsetSetup impatient = setup();
  int sleeps = 0;
  impatient.sleep = [&](Duration) { ++sleeps; };
  impatient.wants_to_end = [&] { return sleeps >= 3; };
  ASSERT_TRUE(open(std::move(impatient))) << error;
  show_until(2);
  ASSERT_EQ(sleeps, 0);
  fake->push(XR_SESSION_STATE_LOSS_PENDING);
  fake->system = XR_NULL_SYSTEM_ID;
  EXPECT_FALSE(show());
  EXPECT_EQ(sleeps, 3);
  finish();
  EXPECT_EQ(error, "");
}

TEST_F(HeadsetSessions, AreNotMadeOnAnotherGpuThanTheOneThatDraws) {
  ASSERT_TRUE(open(setup())) << error;
  show_until(2);
  fake->push(XR_SESSION_STATE_LOSS_PENDING);
  fake->other_gpu = true;
  EXPECT_FALSE(show());
  finish();
  EXPECT_EQ(error,
            "the headset is now driven by another GPU than the one that draws: start the client again");
}

TEST_F(HeadsetSessions, OfARuntimeThatEndsEndTheClient) {
  ASSERT_TRUE(open(setup())) << error;
  show_until(2);
  fake->push(XrEventDataInstanceLossPending{XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING, nullptr, 0});
  EXPECT_FALSE(show());
  finish();
  EXPECT_EQ(error, "the OpenXR runtime ends");
}

TEST_F(HeadsetSessions, ThatAreLostWhileTheRuntimeEndsEndTheClient) {
  ASSERT_TRUE(open(setup())) << error;
  show_until(2);
  fake->push(XR_SESSION_STATE_LOSS_PENDING);
  fake->push(XrEventDataInstanceLossPending{XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING, nullptr, 0});
  fake->system = XR_NULL_SYSTEM_ID;
  EXPECT_FALSE(show());
  finish();
  EXPECT_EQ(error, "the OpenXR runtime ends");
}

TEST_F(HeadsetSessions, ThatDoNotEndAreLeft) {
  fake->ignores_exit = true;
  HeadsetSetup impatient = setup();
  impatient.longest_exit = std::chrono::milliseconds(500);
  ASSERT_TRUE(open(std::move(impatient))) << error;
  show_until(2);
  finish();
  EXPECT_EQ(error, "");
  EXPECT_GT(runtime->counters().empty, 0u) << "frames go on until then";
}

class HeadsetPictures : public FakeHeadset {};

TEST_F(HeadsetPictures, HaveDepthWhereTheRuntimeTakesIt) {
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  ASSERT_EQ(fake->swapchains.size(), 2u);
  EXPECT_EQ(fake->swapchains[1].format, VK_FORMAT_D32_SFLOAT);
  for (std::uint32_t eye = 0; eye < kEyes; ++eye) {
    const auto& depth = fake->frames.at(0).views.at(eye).depth;
    ASSERT_TRUE(depth);
    EXPECT_EQ(depth->minDepth, 0);
    EXPECT_EQ(depth->maxDepth, 1);
    EXPECT_EQ(depth->nearZ, std::numeric_limits<float>::infinity());
    EXPECT_EQ(depth->farZ, static_cast<float>(kNearPlane_m));
    EXPECT_EQ(depth->subImage.imageArrayIndex, eye);
    EXPECT_NE(depth->subImage.swapchain, fake->frames[0].views[eye].picture.swapchain);
  }
}

TEST_F(HeadsetPictures, HaveNoDepthWithoutTheExtension) {
  fake->extensions = {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME};
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  EXPECT_EQ(fake->swapchains.size(), 1u);
  EXPECT_FALSE(fake->frames.at(0).views.at(0).depth);
}

TEST_F(HeadsetPictures, HaveNoDepthWithoutItsFormat) {
  fake->formats = {VK_FORMAT_R8G8B8A8_SRGB, VK_FORMAT_D16_UNORM};
  ASSERT_TRUE(open(setup())) << error;
  ASSERT_TRUE(show());
  EXPECT_EQ(fake->swapchains.size(), 1u);
  EXPECT_FALSE(fake->frames.at(0).views.at(0).depth);
}

TEST_F(HeadsetPictures, HaveNoDepthInModesThatDrawNoScene) {
  HeadsetSetup flat = setup();
  flat.depth = {};
  ASSERT_TRUE(open(std::move(flat))) << error;
  ASSERT_TRUE(show());
  EXPECT_FALSE(fake->frames.at(0).views.at(0).depth);
}

TEST_F(HeadsetPictures, HaveTheFormatThatIsPreferred) {
  fake->formats = {VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_A8B8G8R8_SRGB_PACK32, VK_FORMAT_R8G8B8A8_SRGB};
  ASSERT_TRUE(open(setup())) << error;
  const fake::SwapchainNote& made = fake->swapchains.at(0);
  EXPECT_EQ(made.format, VK_FORMAT_R8G8B8A8_SRGB);
  EXPECT_EQ(made.width, kEyeSize.width);
  EXPECT_EQ(made.height, kEyeSize.height);
  EXPECT_EQ(made.layers, kEyes);
}

TEST_F(HeadsetPictures, HaveAnotherFormatWithTheSameBytes) {
  fake->formats = {VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_A8B8G8R8_SRGB_PACK32};
  ASSERT_TRUE(open(setup())) << error;
  EXPECT_EQ(fake->swapchains.at(0).format, VK_FORMAT_A8B8G8R8_SRGB_PACK32);
}

TEST_F(HeadsetPictures, NeedAFormatWithTheSameBytes) {
  fake->formats = {VK_FORMAT_B8G8R8A8_SRGB, VK_FORMAT_R8G8B8A8_UNORM};
  EXPECT_FALSE(open(setup()));
  EXPECT_EQ(error,
            "the OpenXR runtime offers no 8-bit RGBA sRGB swapchain, which this client needs, only "
            "B8G8R8A8Srgb, R8G8B8A8Unorm");
}

TEST_F(HeadsetPictures, HaveTheRecommendedSizeTimesTheScaleUpToTheLargest) {
  fake->sizes = {fake::EyeSize{1000, 900, 2000, 1500}, fake::EyeSize{1100, 850, 2000, 1500}};
  const Expected<std::unique_ptr<HeadsetSystem>> headset = HeadsetSystem::open();
  ASSERT_TRUE(headset) << headset.error().what;
  EXPECT_EQ((*headset)->eye_size(1), (Extent{1100, 900}));
  EXPECT_EQ((*headset)->eye_size(0.5), (Extent{550, 450}));
  EXPECT_EQ((*headset)->eye_size(1.7), (Extent{1870, 1500}));
  EXPECT_EQ((*headset)->eye_size(1e-6), (Extent{1, 1}));
  EXPECT_EQ((*headset)->name(), "Fake 1.2.3, Headset");
}

TEST_F(HeadsetPictures, OfARuntimeThatHoldsThemEndTheClient) {
  fake->answers = {{"xrWaitSwapchainImage", 3, XR_TIMEOUT_EXPIRED}};
  ASSERT_TRUE(open(setup())) << error;
  show_until(10);
  finish();
  EXPECT_EQ(runtime->counters().submitted, 1u);
  EXPECT_EQ(error,
            "the compositor of the OpenXR runtime gives no picture back: start the runtime again "
            "(xrWaitSwapchainImage returned XR_TIMEOUT_EXPIRED)");
}

TEST_F(HeadsetPictures, ThatDoNotExistEndTheClient) {
  fake->first_image = 7;
  ASSERT_TRUE(open(setup())) << error;
  show_until(10);
  finish();
  EXPECT_EQ(runtime->counters().submitted, 0u);
  EXPECT_NE(error.find("xrAcquireSwapchainImage"), std::string::npos) << error;
}

TEST_F(HeadsetPictures, ComeInLocalSpaceWithoutAStage) {
  fake->spaces = {XR_REFERENCE_SPACE_TYPE_LOCAL};
  ASSERT_TRUE(open(setup())) << error;
  EXPECT_TRUE(show());
}

class HeadsetWaits : public FakeHeadset {};

TEST_F(HeadsetWaits, GoOnWhileTheUserDoesNotWantToEnd) {
  std::atomic<int> idled = 0;
  fake->before = [&](const std::string& call) {
    while (call == "xrWaitFrame" && idled < 2) std::this_thread::yield();
  };
  HeadsetSetup patient = setup();
  patient.idle = [&] { ++idled; };
  ASSERT_TRUE(open(std::move(patient))) << error;
  EXPECT_TRUE(show());
}

/// A process whose runtime never returns from xrWaitFrame, and whose user wants to end. The status is that of
/// the process: 0 if the client has ended.
[[noreturn]] void end_while_the_runtime_blocks() {
  fake::Runtime& runtime = restart_fake();
  Expected<ShownPictures> made = make_pictures();
  std::atomic<bool> blocks = false;
  bool ends = false;
  runtime.before = [&blocks](const std::string& call) {
    if (call != "xrWaitFrame") return;
    blocks = true;
    std::this_thread::sleep_for(std::chrono::hours(1));  // until the process ends
  };
  {
    const std::unique_ptr<HeadsetSystem> system = HeadsetSystem::open().value();
    auto headset = system->open_runtime(made->device, made->shown,
                                        {.start = {},
                                         .eye_size = kEyeSize,
                                         .wants_to_end = [&] { return ends; },
                                         .idle = [&] { ends = blocks; },
                                         .depth = {},
                                         .longest_exit = std::chrono::milliseconds(200)});
    if (!headset || (*headset)->wait_frame() || !(*headset)->finish()) std::exit(1);
  }
  made = fail(Fault::Missing, "");  // destroys the device
  std::exit(blocks && runtime.counts["xrDestroySession"] == 0 ? 0 : 2);
}

TEST_F(HeadsetWaits, ThatNeverEndAreLeftWhenTheUserWantsToEnd) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(end_while_the_runtime_blocks(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace farshade::openxr
