/// Findings of `rt_server doctor` and `vr_client doctor`, and the checks that both programs share.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "stereo/base/expected.h"
#include "stereo/scene/lighting.h"

namespace farshade {

enum class Severity : std::uint8_t {
  Ok,
  Warn,  ///< the program works, but more slowly or without one of its features
  Fail,  ///< the program cannot work
};

struct Finding {
  Severity severity = Severity::Ok;
  std::string subject;  ///< what was checked
  std::string found;    ///< contains no secret
  std::string cure{};   ///< what the user can do; empty if the severity is Ok
};
using Findings = std::vector<Finding>;

/// A Fail finding whose text is `error`'s.
[[nodiscard]] Finding failed(std::string subject, const Error& error, std::string cure);

/// Prints one line per finding to standard output: `FAIL  SUBJECT: FOUND; cure: CURE`. Returns the exit
/// status of the program: 1 if any finding is a Fail.
[[nodiscard]] int report(const Findings& findings);

/// The protocol version, to compare with the other program's. Warns about a debug build.
[[nodiscard]] Finding check_build();

enum class KeyFile : std::uint8_t { OfClient, Ring };

/// Does the file exist, may only its owner read it, and is it valid?
[[nodiscard]] Finding check_key_file(const std::filesystem::path& path, KeyFile kind);

/// `lit` is the result of load_lit_scene. What was chosen for the scene is part of the finding.
[[nodiscard]] Finding check_scene(const Expected<LitScene>& lit);

/// Does the kernel grant UDP sockets the buffer sizes that the programs ask for?
[[nodiscard]] Finding check_socket_buffers();

}  // namespace farshade
