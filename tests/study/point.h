/// Point: one way of working on one scene, head and network, played once in virtual time and told as JSON -
/// errors and run times - with pictures of its worst frame.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/network/rehearsal.h"

namespace farshade::study {

/// Plays `play` and returns `{"start_up_frames", "error", "wire", "time"}` as Figures::json has them: of
/// every reference_every-th frame's worse eye also `psnr`, `ssim` and `flip`. Writes
/// `{left,right}_{shown,reference,heat}.png` of the frame with the largest FLIP into `pictures`, a folder
/// that is there; nothing if it is empty.
[[nodiscard]] Expected<nlohmann::json> measure_point(Play play, const Network& network,
                                                     const std::filesystem::path& pictures);

/// Run times alone, without a reference: `modes` in random order, again in each of `rounds`, and the first of
/// them twice, so that the machine's noise shows.
struct Rounds {
  std::vector<std::string> modes;  ///< mode words
  std::uint32_t rounds = 5, warm_up = 10;
  std::uint64_t seed = 1;
};

/// `[{"mode", "again", "figures", "rounds": [FIGURES...]}]`, in the order of modes: figures over all rounds,
/// and of each. `play` is what all modes share; its first `warm_up` frames are in no figure.
[[nodiscard]] Expected<nlohmann::json> measure_rounds(const Play& play, const Network& network,
                                                      const Rounds& rounds);

}  // namespace farshade::study
