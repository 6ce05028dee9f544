/// RequestHandlers: the kinds of answer that a server offers, and the object that makes each of them.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "rt_server/sessions/job.h"
#include "stereo/answers/frame_packer.h"
#include "stereo/base/failure_log.h"
#include "stereo/frame/trace_stats.h"

namespace farshade {

/// Work that an answer took, without packing.
struct AnswerCost {
  TraceStats traced{};
  Duration draw{}, coding{};
  bool lacked_memory = false;      ///< there is no content because memory ran out
  bool rebuilt_too_often = false;  ///< there is none for RebuiltTooOften
  bool too_large = false;          ///< there is none for AnswerTooLarge
};

/// Makes one kind of answer and reuses its buffers. Called by one thread at a time.
class RequestHandler {
 public:
  virtual ~RequestHandler() = default;
  /// Adds the messages of the answer to `packer`. Throws a std::exception if this request cannot be answered
  /// (for example a picture that is too large for the device), and AnswersLost if no request can be.
  virtual AnswerCost answer(const Job& job, FramePacker& packer) = 0;
};

/// Work on an answer was given up between two of its stages.
struct AnswerGivenUp : std::runtime_error {
  AnswerGivenUp() : std::runtime_error("work on it was given up") {}
};
/// Throws AnswerGivenUp if `job` is to be given up. Handlers call it before each stage that nothing
/// interrupts.
inline void go_on_with(const Job& job) {
  if (job.is_given_up && job.is_given_up()) throw AnswerGivenUp();
}

/// `answers` cannot be made any more, whatever is requested. what() is a sentence for the log.
struct AnswersLost : std::runtime_error {
  AnswersLost(AnswerSet lost, const std::string& why) : std::runtime_error(why), answers(lost) {}
  AnswerSet answers;
};

/// The clients of one key change the sizes of their views or their bit rates too often.
struct RebuiltTooOften : std::runtime_error {
  RebuiltTooOften() : std::runtime_error("its key changes sizes or bit rates too often") {}
};

/// An answer has more parts than a message can number. Smaller views have a smaller one.
struct AnswerTooLarge : std::runtime_error {
  explicit AnswerTooLarge(std::size_t bytes)
      : std::runtime_error("an answer of " + std::to_string(bytes) + " bytes is too large to send") {}
};

class RequestHandlers {
 public:
  /// Offers `answer` from now on. Replaces an earlier handler of that kind.
  void add(Answer answer, std::unique_ptr<RequestHandler> handler);

  /// The kinds that have a handler.
  [[nodiscard]] AnswerSet offered() const;

  /// Lets the handler of the requested kind, which must be offered, answer `job`. If it throws, logs the
  /// reason and leaves `packer` empty: a request that cannot be answered ends no session. After AnswersLost
  /// those kinds are no longer offered.
  AnswerCost answer(const Job& job, FramePacker& packer, Time now);

 private:
  [[nodiscard]] AnswerCost without_memory(Time now);

  std::array<std::unique_ptr<RequestHandler>, kAnswers> handlers_;  ///< by Answer; null: not offered
  FailureLog failures_;
};

}  // namespace farshade
