/// Clients: what one server needs for a display frame of several heads, each along another part of the same
/// recording. Nobody draws.
#pragma once

#include <nlohmann/json.hpp>

#include "tests/network/rehearsal.h"

namespace farshade::study {

/// Figures as Figures::json has them: of each display frame from `warm_up` on, the time in which the server
/// took in, traced, packed and sent what `clients` heads asked for at once, `time.server_frame`, ms. Head i
/// is a tenth of a second ahead of head i - 1. Of `play` counts what both sides need; its mode does not.
[[nodiscard]] nlohmann::json measure_clients(const Play& play, std::uint32_t clients, std::uint32_t warm_up);

}  // namespace farshade::study
