/// Runs one case through the real rt_server and vr_client over a UDP socket and returns its verdict.
#pragma once

#include <filesystem>
#include <functional>
#include <map>

#include "tests/stability/setting.h"
#include "tests/stability/verdict.h"

namespace farshade::stability {

enum class Outcome : std::uint8_t {
  Works,
  Refused,     ///< the client refuses with a sentence
  BothRefuse,  ///< server and client refuse, each with a sentence: the scene is outside the domain
};

/// The bound for the prediction of an extreme head.
enum class HeadBound : std::uint8_t {
  None,
  NoWorseThanHeld,  ///< the error of the requested views is at most that of held views
  TwiceHeld,        ///< at most twice that: a jump in the recording looks like a velocity
};

struct Case {
  std::string name, extreme;
  std::string sweep{};  ///< the sweep of this point; empty: none
  double x = 0;         ///< position on the sweep
  std::function<Setting()> make;
  Outcome outcome = Outcome::Works;
  HeadBound head = HeadBound::None;
  std::string like = "ordinary";  ///< the ordinary case with as many triangles, lights and pixels
};

/// Lower quartiles of run times, ms.
struct Pace {
  double client_ms = 0, server_ms = 0;
};

/// Paths of the programs, their keys, and a folder for the files of one case.
struct CasePaths {
  std::filesystem::path server, client, folder;
};

struct Ran {
  Verdict verdict;
  Pace pace;
};

/// Runs the case twice: with masks of the shown pose, and with masks that are 20 ms late (or as the case
/// says), with prediction and guard band.
[[nodiscard]] Ran run(const Case& tested, const CasePaths& paths);

/// Adds run times to the verdict. The bound is four times those of the ordinary case.
void judge_pace(const Pace& pace, const Pace& ordinary, Verdict& verdict);

}  // namespace farshade::stability
