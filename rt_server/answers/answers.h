/// Answers: what a server gives beside masks of what it sees itself. Files beside this
/// one make them; they share a tracer, and those that are pictures a painter.
#pragma once

#include <memory>

#include "rt_server/core/server_core.h"
#include "stereo/gpu/device.h"
#include "stereo/tracer/tracer.h"

namespace farshade {

/// What of a scene a server can make.
struct AnswerContext {
  const Scene& scene;
  const ScenePlan& plan;
  Tracer& tracer;
  gpu::DeviceOptions device{};  ///< what pictures are drawn on
};

/// One kind of answer; keeps its buffers. Not for several threads.
class AnswerMaker {
 public:
  virtual ~AnswerMaker() = default;
  virtual AnswerCost answer(const Job& job, FramePacker& packer) = 0;
};

class AnswerRenderer;

// References are kept.
[[nodiscard]] std::unique_ptr<AnswerMaker> make_position_masks(const AnswerContext& ground);
[[nodiscard]] std::unique_ptr<AnswerMaker> make_gbuffer(AnswerRenderer& painter);
[[nodiscard]] std::unique_ptr<AnswerMaker> make_video(AnswerRenderer& painter);
[[nodiscard]] std::unique_ptr<AnswerMaker> make_difference(AnswerRenderer& painter);

class Answers {
 public:
  /// What `ground` refers to outlives it. No device is opened before the first picture is wanted.
  explicit Answers(const AnswerContext& ground);
  ~Answers();

  /// As this build and this machine can: pictures need a device, video a codec. Opens a device and closes it.
  [[nodiscard]] AnswerSet offered() const;

  /// An AnswerFunction: all but Answer::Masks. What cannot be made (a picture too large for the device, too
  /// small for the codec) is said in the log and left out: one client's wish ends nobody's session.
  AnswerCost answer(const Job& job, FramePacker& packer);

 private:
  std::unique_ptr<AnswerRenderer> painter_;
  std::array<std::unique_ptr<AnswerMaker>, kAnswers> makers_;
  std::string last_failure_;  ///< said once, not at every frame
};

}  // namespace farshade
