/// Compiles pipelines before the first frame.
#pragma once

#include <functional>
#include <string>

#include "vr_client/client.h"

namespace farshade {

/// Gets what a program waits for, in words.
using TellWaiting = std::function<void(const std::string&)>;

/// Creates every pipeline that a run with these settings can need, and keeps them in the user's cache. Tells
/// its progress on a terminal, and to `tell`, on the calling thread.
///
/// Lavapipe compiles in its only queue, one pipeline after another. If there are more cores, a second device
/// compiles the last pipelines meanwhile, and lavapipe's cache on disk brings them to the first device: from
/// the beginning in the first start on a machine, otherwise once a step has taken long.
void compile_ahead(Client& client, const Reprojection& reprojection, PixelReport report, Changes changes,
                   const TellWaiting& tell = {});

}  // namespace farshade
