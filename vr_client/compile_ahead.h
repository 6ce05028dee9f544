/// Compiles pipelines before the first frame.
#pragma once

#include "vr_client/client.h"

namespace farshade {

/// Creates every pipeline that a run with these settings can need, and keeps them in the user's cache. Tells
/// its progress on a terminal.
///
/// Lavapipe compiles in its only queue, one pipeline after another. If there are more cores, a second device
/// compiles the last pipelines meanwhile, and lavapipe's cache on disk brings them to the first device.
void compile_ahead(Client& client, const CarryOver& carry_over, PixelReport report, Changes changes);

}  // namespace farshade
