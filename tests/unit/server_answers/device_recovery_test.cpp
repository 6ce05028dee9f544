#include "rt_server/answers/device_recovery.h"

#include <gtest/gtest.h>

#include "stereo/gpu/device.h"
#include "tests/unit/answers_from.h"

namespace farshade {
namespace {

using Device = int;  ///< a number that increases with each opening

/// All drawn answers of a device that is lost or cannot be opened, as the test chooses.
struct Server {
  Device opened = 1;
  int lost = 0;  ///< the number of draws that will fail with a lost device
  bool can_open = true;
  std::string other_failure;  ///< the error of a draw; empty: none
  int drawn = 0;

  RequestHandlers handlers = [this] {
    const auto draw = [this](const Job&, FramePacker&) {
      if (!other_failure.empty()) throw std::runtime_error(other_failure);
      if (lost > 0) {
        --lost;
        throw vk::DeviceLostError("vkQueueSubmit");
      }
      ++drawn;
      return AnswerCost{};
    };
    const auto recovery = std::make_shared<DeviceRecovery>([this]() -> Expected<void> {
      if (!can_open) return fail(Fault::Missing, "no driver");
      ++opened;
      return {};
    });
    RequestHandlers all = answers_from(kTracedAnswers, [](const Job&, FramePacker&) { return AnswerCost{}; });
    for (const Answer answer : {Answer::GBuffer, Answer::Video, Answer::Difference})
      all.add(answer, recovering(std::make_unique<AnswerFrom>(draw), recovery));
    return all;
  }();

  void request(Answer answer = Answer::GBuffer) {
    Job job{};
    job.request.answer.kind = answer;
    FramePacker packer;
    packer.begin();
    handlers.answer(job, packer, {});
  }
};

TEST(DeviceRecovery, OpensALostDeviceAgainAndDrawsTheNextRequest) {
  Server server;
  server.request();
  server.lost = 1;
  server.request();
  EXPECT_EQ(server.opened, 2);
  EXPECT_EQ(server.drawn, 1) << "the request during the loss has no answer";
  server.request();
  EXPECT_EQ(server.drawn, 2);
  EXPECT_EQ(server.handlers.offered(), kEveryAnswer);
}

TEST(DeviceRecovery, StopsOfferingPicturesIfNoDeviceCanBeOpened) {
  Server server;
  server.lost = 1;
  server.can_open = false;
  server.request(Answer::Video);
  EXPECT_EQ(server.handlers.offered(), kTracedAnswers);
  server.request(Answer::Masks);
  server.request(Answer::MasksOfPositions);
}

TEST(DeviceRecovery, GivesUpADeviceThatIsLostAgainAndAgain) {
  Server server;
  server.lost = DeviceRecovery::kMostLosses;
  for (int i = 0; i < DeviceRecovery::kMostLosses; ++i) {
    EXPECT_EQ(server.handlers.offered(), kEveryAnswer) << i;
    server.request(i == 1 ? Answer::Video : Answer::GBuffer);
  }
  EXPECT_EQ(server.handlers.offered(), kTracedAnswers);
  EXPECT_EQ(server.opened, DeviceRecovery::kMostLosses) << "it was not opened again";
}

TEST(DeviceRecovery, KeepsADeviceThatDrawsBetweenItsLosses) {
  Server server;
  for (int i = 0; i < 5 * DeviceRecovery::kMostLosses; ++i) {
    server.lost = DeviceRecovery::kMostLosses - 1;
    for (int k = 0; k < DeviceRecovery::kMostLosses; ++k) server.request();
  }
  EXPECT_EQ(server.handlers.offered(), kEveryAnswer);
  EXPECT_EQ(server.drawn, 5 * DeviceRecovery::kMostLosses);
}

TEST(DeviceRecovery, KeepsTheDeviceAfterAnyOtherFailure) {
  Server server;
  server.other_failure = "too large";
  for (int i = 0; i < 2 * DeviceRecovery::kMostLosses; ++i) server.request();
  EXPECT_EQ(server.opened, 1);
  EXPECT_EQ(server.handlers.offered(), kEveryAnswer);
}

}  // namespace
}  // namespace farshade
