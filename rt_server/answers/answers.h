/// Answers: makes the answers that this build and this machine can give. The masks are in answers.cpp; each
/// other kind has one file beside it. The kinds that need a picture share a renderer.
#pragma once

#include <memory>

#include "rt_server/admission/memory_share.h"
#include "rt_server/work/request_handlers.h"
#include "stereo/gpu/device_options.h"
#include "stereo/tracer/tracer.h"

namespace farshade {

/// The scene that is served. The references must outlive the handlers.
struct AnswerContext {
  const Scene& scene;
  const ScenePlan& plan;
  Tracer& tracer;
  Exposure exposure{};          ///< of pictures
  gpu::DeviceOptions device{};  ///< for pictures
  MemoryShare memory{};         ///< of in_work(): kept renderers 1/4, encoders 1/4, the answer the rest
};

/// A handler for each kind that can be made: pictures need a Vulkan device, video also a codec. Logs what is
/// not offered and why. Opens a device to find out and closes it; it is opened again for the first picture.
[[nodiscard]] RequestHandlers make_answers(const AnswerContext& context);

/// For Answer::Masks or Answer::CubeMask. Keeps the reference.
[[nodiscard]] std::unique_ptr<RequestHandler> make_masks(Tracer& tracer);
[[nodiscard]] std::unique_ptr<RequestHandler> make_position_masks(const AnswerContext& context);

class AnswerRenderer;
[[nodiscard]] std::unique_ptr<RequestHandler> make_gbuffer(std::shared_ptr<AnswerRenderer> renderer);
[[nodiscard]] std::unique_ptr<RequestHandler> make_video(std::shared_ptr<AnswerRenderer> renderer);
[[nodiscard]] std::unique_ptr<RequestHandler> make_difference(std::shared_ptr<AnswerRenderer> renderer);

}  // namespace farshade
