/// Measures the server time per display frame for several heads. Each head follows another part of the same
/// recording. The clients draw only what they need to find out what to ask for.
#pragma once

#include <nlohmann/json.hpp>

#include "tests/network/rehearsal.h"

namespace farshade::study {

/// Figures as in Figures::json: for each display frame from `warm_up` on, the time in which the server
/// received, traced, packed and sent the answers for the simultaneous requests of `clients` heads,
/// `time.server_frame`, ms. Head i is 0.1 s ahead of head i - 1. `play.request.asks` says what
/// they ask for. The mode has no effect.
[[nodiscard]] nlohmann::json measure_clients(const Play& play, std::uint32_t clients, std::uint32_t warm_up);

}  // namespace farshade::study
