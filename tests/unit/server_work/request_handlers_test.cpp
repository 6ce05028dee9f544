#include "rt_server/work/request_handlers.h"

#include <gtest/gtest.h>

#include "tests/unit/answers_from.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;

Job job_for(Answer answer) {
  Job job{};
  job.request.frame = {1};
  job.request.answer.kind = answer;
  return job;
}

TEST(RequestHandlers, OffersTheKindsThatHaveAHandler) {
  EXPECT_EQ(RequestHandlers().offered(), 0);
  for (const AnswerSet answers : {kTracedAnswers, kDrawnAnswers, kEveryAnswer})
    EXPECT_EQ(answers_from(answers, nullptr).offered(), answers);
}

TEST(RequestHandlers, AFailedAnswerLeavesNothingBehindAndTheNextIsMade) {
  bool fails = true;
  RequestHandlers handlers = answers_from(kEveryAnswer, [&](const Job& job, FramePacker& packer) {
    constexpr std::array kUnit{std::byte{1}};
    packer.add(job.request.frame, job.request.frame, VideoUnitParts{std::span(kUnit)});
    if (fails) throw std::runtime_error("too large");
    return AnswerCost{.draw = 3ms};
  });
  FramePacker packer;
  packer.begin();
  EXPECT_EQ(handlers.answer(job_for(Answer::Video), packer, {}).draw, 0ms);
  EXPECT_EQ(packer.finish({.frame = {1}}).size(), 1u) << "only the report";
  EXPECT_EQ(handlers.offered(), kEveryAnswer);
  fails = false;
  packer.begin();
  EXPECT_EQ(handlers.answer(job_for(Answer::Video), packer, {}).draw, 3ms);
  EXPECT_EQ(packer.finish({.frame = {1}}).size(), 2u);
}

TEST(RequestHandlers, SaysWhyThereIsNoContent) {
  RequestHandlers handlers = answers_from(kEveryAnswer, [](const Job& job, FramePacker&) -> AnswerCost {
    if (job.request.answer.kind == Answer::Masks) throw std::bad_alloc();
    if (job.request.answer.kind == Answer::GBuffer) throw AnswerTooLarge(5);
    throw RebuiltTooOften();
  });
  FramePacker packer;
  packer.begin();
  const AnswerCost masks = handlers.answer(job_for(Answer::Masks), packer, {}),
                   video = handlers.answer(job_for(Answer::Video), packer, {}),
                   gbuffer = handlers.answer(job_for(Answer::GBuffer), packer, {});
  EXPECT_TRUE(gbuffer.too_large && !gbuffer.lacked_memory && !gbuffer.rebuilt_too_often);
  EXPECT_TRUE(masks.lacked_memory && !masks.rebuilt_too_often);
  EXPECT_TRUE(video.rebuilt_too_often && !video.lacked_memory);
}

TEST(RequestHandlers, LostAnswersAreNoLongerOffered) {
  RequestHandlers handlers = answers_from(kEveryAnswer, [](const Job& job, FramePacker&) -> AnswerCost {
    if (is_drawn(job.request.answer.kind)) throw AnswersLost(kDrawnAnswers, "no device");
    return {};
  });
  FramePacker packer;
  packer.begin();
  handlers.answer(job_for(Answer::Masks), packer, {});
  EXPECT_EQ(handlers.offered(), kEveryAnswer);
  handlers.answer(job_for(Answer::GBuffer), packer, {});
  EXPECT_EQ(handlers.offered(), kTracedAnswers);
}

TEST(FailureLog, LogsTheFirstFailureAndThenOnePerIntervalWithACount) {
  FailureLog log;
  EXPECT_EQ(log.failed("first", Time(1s)), "first");
  for (int i = 0; i < 7; ++i)
    EXPECT_EQ(log.failed("other", Time(1s + FailureLog::kInterval - 1ms)), std::nullopt);
  EXPECT_EQ(log.failed("late", Time(1s + FailureLog::kInterval)),
            "late (7 more failures since the last line)");
  EXPECT_EQ(log.failed("later", Time(2s + FailureLog::kInterval)), std::nullopt);
  EXPECT_EQ(log.failed("last", Time(9s + 2 * FailureLog::kInterval)),
            "last (1 more failures since the last line)");
  EXPECT_EQ(log.failed("alone", Time(9s + 3 * FailureLog::kInterval)), "alone");
}

TEST(FailureLogs, HaveALogForEachSourceAndForgetThoseOfManySources) {
  constexpr std::size_t kMost = 4;
  FailureLogs<int> logs(kMost);
  for (int source = 0; source < 100; ++source) {
    EXPECT_EQ(logs.failed(source, "bad", Time(1s)), "bad");
    EXPECT_EQ(logs.failed(source, "bad", Time(1s)), std::nullopt);
    EXPECT_LE(logs.size(), kMost);
  }
  EXPECT_EQ(logs.failed(98, "bad", Time(1s)), std::nullopt) << "the last ones are remembered";
}

}  // namespace
}  // namespace farshade
