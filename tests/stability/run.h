/// Run: one case through the real rt_server and vr_client over a UDP socket, and what came of it.
#pragma once

#include <filesystem>
#include <functional>
#include <map>

#include "tests/stability/setting.h"
#include "tests/stability/verdict.h"

namespace farshade::stability {

enum class Outcome : std::uint8_t {
  Works,
  Refused,     ///< by the client, with a sentence
  BothRefuse,  ///< by server and client, each with a sentence: the scene is out of the domain
};

/// What an extreme head is held to.
enum class HeadBound : std::uint8_t {
  None,
  NoWorseThanHeld,  ///< the predicted views miss by no more than views held since they were asked for
  TwiceHeld,        ///< by no more than twice that: what seemed a speed was a jerk of the recording's
};

struct Case {
  std::string name, extreme;
  std::string sweep{};  ///< whose point this is; empty: of none
  double x = 0;         ///< where on the sweep
  std::function<Setting()> make;
  Outcome outcome = Outcome::Works;
  HeadBound head = HeadBound::None;
  std::string like = "ordinary";  ///< the ordinary case of as many triangles, lights and pixels
};

/// Lower quartiles of run times, ms.
struct Pace {
  double client_ms = 0, server_ms = 0;
};

/// Where things are: the programs, keys for them, and a folder for one case at a time.
struct Room {
  std::filesystem::path server, client, folder;
};

struct Ran {
  Verdict verdict;
  Pace pace;
};

/// Runs the case twice: once with masks of the very pose shown, once 20 ms late (or as the case says) with
/// prediction and guard band.
[[nodiscard]] Ran run(const Case& tested, const Room& room);

/// Adds run times to the verdict: at most four times those of the ordinary case.
void judge_pace(const Pace& pace, const Pace& ordinary, Verdict& verdict);

}  // namespace farshade::stability
