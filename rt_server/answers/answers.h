/// Answers: makes the answers that this build and this machine can give. The masks are in answers.cpp; each
/// other kind has one file beside it. The kinds that need a picture share a renderer.
#pragma once

#include <memory>

#include "rt_server/core/answer_makers.h"
#include "rt_server/core/memory_share.h"
#include "stereo/gpu/device_options.h"
#include "stereo/tracer/tracer.h"

namespace farshade {

/// The scene that is served. The references must outlive the makers.
struct AnswerContext {
  const Scene& scene;
  const ScenePlan& plan;
  Tracer& tracer;
  Exposure exposure{};          ///< of pictures
  gpu::DeviceOptions device{};  ///< for pictures
  MemoryShare memory{};         ///< of in_work(): kept renderers 1/4, encoders 1/4, the answer the rest
};

/// A maker for each kind that can be made: pictures need a Vulkan device, video also a codec. Logs what is
/// not offered and why. Opens a device to find out and closes it; it is opened again for the first picture.
[[nodiscard]] AnswerMakers make_answers(const AnswerContext& context);

/// For Answer::Masks or Answer::Surround. Keeps the reference.
[[nodiscard]] std::unique_ptr<AnswerMaker> make_masks(Tracer& tracer);
[[nodiscard]] std::unique_ptr<AnswerMaker> make_position_masks(const AnswerContext& context);

class AnswerRenderer;
[[nodiscard]] std::unique_ptr<AnswerMaker> make_gbuffer(std::shared_ptr<AnswerRenderer> renderer);
[[nodiscard]] std::unique_ptr<AnswerMaker> make_video(std::shared_ptr<AnswerRenderer> renderer);
[[nodiscard]] std::unique_ptr<AnswerMaker> make_difference(std::shared_ptr<AnswerRenderer> renderer);

}  // namespace farshade
