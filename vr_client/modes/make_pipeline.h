/// Makes the pipeline of each mode.
#pragma once

#include <memory>

#include "vr_client/frame/frame_loop.h"

namespace farshade {

// The pipelines keep references to `context`. It must have the link or the tracer that the mode needs, unless
// no light casts shadows.
[[nodiscard]] std::unique_ptr<ModePipeline> make_hybrid(const RunContext& context);
[[nodiscard]] std::unique_ptr<ModePipeline> make_client_positions(const RunContext& context);
[[nodiscard]] std::unique_ptr<ModePipeline> make_server_gbuffer(const RunContext& context);
[[nodiscard]] std::unique_ptr<ModePipeline> make_remote(const RunContext& context);
[[nodiscard]] std::unique_ptr<ModePipeline> make_delta(const RunContext& context);

/// The pipeline of context.mode.
[[nodiscard]] std::unique_ptr<ModePipeline> make_pipeline(const RunContext& context);

/// Calls ModePipeline::draw_ahead for the views of the first display time, before a real clock begins.
void draw_ahead(const RunContext& context, Time first_display_time);

}  // namespace farshade
