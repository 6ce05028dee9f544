#include "rt_server/answers/answer_renderer.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <stdexcept>

#include "stereo/raster/max_instances.h"

namespace farshade {

Expected<void> AnswerRenderer::can_draw() const {
  const std::size_t instances = context_.scene.instances.size();
  if (instances > kMaxInstances)
    return fail(Fault::Unsupported,
                fmt::format("the scene has {} instances, more than the {} that can be drawn", instances,
                            kMaxInstances));
  return gpu::open_device(context_.device).map([](const gpu::Device&) {});
}

Expected<void> AnswerRenderer::reopen() {
  renderers_ = no_renderers();
  device_.reset();
  Expected<gpu::Device> device = gpu::open_device(context_.device);
  if (!device) return tl::unexpected(device.error());
  device_.emplace(std::move(*device));
  spdlog::info("pictures are drawn on {}: {}", device_->name, device_->why);
  return {};
}

Renderer& AnswerRenderer::renderer_for(const Job& job) {
  const Extent size = job.request.views[0].size;
  if (!device_)
    if (const Expected<void> opened = reopen(); !opened)
      throw AnswersLost(kDrawnAnswers, opened.error().what);
  if (std::unique_ptr<Renderer>* const found = renderers_.find(size)) return **found;
  rebuilds_.take(job.key, job.arrived);
  const std::size_t of_pixels = kEyes * size.pixels() * kDrawnPixel_bytes,
                    expected = of_pixels + kPipelines_bytes + scene_bytes_;
  renderers_.make_room(size, job.key, expected);  // before the new one takes memory
  const std::uint64_t before = device_->ledger->read().now.total();
  auto renderer = make_renderer(*device_, context_.scene, context_.plan.draw,
                                RendererLimits{.size = size, .traced_size = size, .depth_frames = 1});
  const std::uint64_t taken = device_->ledger->read().now.total() - before;
  scene_bytes_ = taken - std::min<std::uint64_t>(taken, of_pixels);
  return *renderers_.put(size, job.key, of_pixels + kPipelines_bytes + scene_bytes_, std::move(renderer));
}

AnswerRenderer::RenderedAnswer AnswerRenderer::draw(const Job& job) {
  const FrameRequest& request = job.request;
  Renderer& renderer = renderer_for(job);
  const TraceStats traced = context_.tracer.trace(request, mask_.frame, job.is_given_up);
  mask_.display_time = request.display_time;
  mask_.scene_time = request.scene_time;
  mask_.receive_all();
  ++mask_.content;
  traced_.emplace(mask_.traced());
  state_.emplace(state_at(context_.scene, request.scene_time, request.lights));
  state_->light_set.exposure = context_.exposure;
  const ShownFrame shown{.views = request.views,
                         .state = *state_,
                         .masks = {&*traced_, 1},
                         .reprojection = {.lookup = Lookup::Direct}};
  go_on_with(job);
  renderer.draw(shown);
  const DrawTimes drawn = renderer.finish();
  return {renderer, mask_.frame, shown, {.traced = traced, .draw = drawn.total}};
}

}  // namespace farshade
