#include "vr_client/modes/make_pipeline.h"

#include "stereo/base/check.h"

namespace farshade {

std::unique_ptr<ModePipeline> make_pipeline(const RunContext& context) {
  // If no light casts shadows, there is no link, and hybrid draws the scene without masks.
  if (context.link == nullptr && answers_for(context.mode.mode) != 0) return make_hybrid(context);
  switch (context.mode.mode) {
    case Mode::Hybrid:
      return make_hybrid(context);
    case Mode::ClientPositions:
      return make_client_positions(context);
    case Mode::ServerGBuffer:
      return make_server_gbuffer(context);
    case Mode::Remote:
      return make_remote(context);
    case Mode::Delta:
      return make_delta(context);
    case Mode::Local:
      return make_local(context);
    case Mode::Full:
      return make_full(context);
  }
  check(false, "every mode has a pipeline");
  return nullptr;
}

}  // namespace farshade
