/// A point of the study: one mode with one scene, head and network, run once in virtual time. The result is
/// JSON with errors and run times, and pictures of the worst frame.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/network/rehearsal.h"

namespace farshade::study {

/// Runs `play` and returns `{"start_up_frames", "error", "wire", "time"}`, with groups as in Figures::json.
/// `psnr`, `ssim` and `flip` are those of the worse eye of every reference_every-th frame. Writes
/// `{left,right}_{shown,reference,heat}.png` of the frame with the largest FLIP into the existing folder
/// `pictures`, unless the path is empty.
[[nodiscard]] Expected<nlohmann::json> measure_point(Play play, const Network& network,
                                                     const std::filesystem::path& pictures);

/// Settings for run times without a reference. Each round runs all `modes` in a random order, and the first
/// mode twice, so that the noise of the machine shows.
struct Rounds {
  std::vector<std::string> modes;  ///< mode words
  std::uint32_t rounds = 5;
  std::uint64_t seed = 1;
};

/// `[{"mode", "again", "figures", "rounds": [FIGURES...]}]`, in the order of modes: figures over all rounds,
/// and of each round. `play` has the settings that all modes share. A run is timed for `play.frames` frames,
/// after the first answer and the warm-up (figures.h) that the network needs.
[[nodiscard]] Expected<nlohmann::json> measure_rounds(const Play& play, const Network& network,
                                                      const Rounds& rounds);

}  // namespace farshade::study
