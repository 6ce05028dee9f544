#include "rt_server/work/request_handlers.h"

#include <spdlog/spdlog.h>

#include <new>
#include <utility>

#include "stereo/base/check.h"

namespace farshade {
namespace {

constexpr std::size_t index_of(Answer answer) {
  return static_cast<std::size_t>(answer);
}

}  // namespace

void RequestHandlers::add(Answer answer, std::unique_ptr<RequestHandler> handler) {
  check(handler != nullptr, "an answer that is offered has a handler");
  handlers_[index_of(answer)] = std::move(handler);
}

AnswerSet RequestHandlers::offered() const {
  AnswerSet offered = 0;
  for (std::size_t i = 0; i < kAnswers; ++i)
    if (handlers_[i]) offered |= set_of(static_cast<Answer>(i));
  return offered;
}

AnswerCost RequestHandlers::answer(const Job& job, FramePacker& packer, Time now) {
  AnswerCost none;
  RequestHandler* const handler = handlers_[index_of(job.request.answer.kind)].get();
  check(handler != nullptr, "a session accepts requests for offered answers only");
  try {
    return handler->answer(job, packer);
  } catch (const AnswersLost& lost) {
    spdlog::error("answers are no longer offered: {}", lost.what());
    for (std::size_t i = 0; i < kAnswers; ++i)
      if ((lost.answers & set_of(static_cast<Answer>(i))) != 0) handlers_[i].reset();
  } catch (const std::bad_alloc&) {
    packer.begin(job.most_message_bytes, job.version);
    return without_memory(now);
  } catch (const std::exception& error) {
    none.rebuilt_too_often = dynamic_cast<const RebuiltTooOften*>(&error) != nullptr;
    none.too_large = dynamic_cast<const AnswerTooLarge*>(&error) != nullptr;
    if (const auto line = failures_.failed(error.what(), now))
      spdlog::warn("a request cannot be answered: {}", *line);
  }
  packer.begin(job.most_message_bytes, job.version);
  return none;
}

AnswerCost RequestHandlers::without_memory(Time now) {
  if (const auto line = failures_.failed("the server's memory is used up (--memory, ulimit)", now))
    spdlog::warn("a request cannot be answered: {}", *line);
  return {.lacked_memory = true};
}

}  // namespace farshade
