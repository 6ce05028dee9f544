/// A good client for tests of attacks on a real rt_server, and what is measured of the server meanwhile.
#pragma once

#include <optional>
#include <string>

#include "stereo/link/network_link.h"
#include "tests/integration/client_program.h"

namespace farshade {

/// A client that waits for the masks of each request, and repeats the same poses.
class Walker {
 public:
  static constexpr std::uint32_t kPoses = 24;
  static constexpr Duration kPatience = std::chrono::seconds(20);

  /// Throws a std::runtime_error if there is no session within kPatience. `size` is that of a view.
  Walker(DatagramPort& port, const LinkTarget& target, Extent size = kClientSize);

  /// The masks of the next pose; nothing if they are not complete within `patience`.
  std::optional<PerEye<EyeMask>> next_masks(Duration patience = kPatience);

  [[nodiscard]] NetworkLink::Counters counters() const { return link_.counters(); }

 private:
  SteadyClock clock_;
  NetworkLink link_;
  Extent size_;
  FrameId frame_;
};

/// What the good client's link needs to know of `server`, which serves the scene file `scene`. Throws a
/// std::runtime_error if the file cannot be read.
[[nodiscard]] LinkTarget target_of(const Peer& server, const SharedKey& key, const std::string& scene);

/// Resident memory of the process `pid`, KiB.
[[nodiscard]] double memory_KiB(pid_t pid);

/// The line with the server's counters.
struct Counts {
  std::string line;

  /// The number before `what`; 0 if the line does not contain it.
  [[nodiscard]] std::uint64_t of(const std::string& what) const;
};

/// Asks a running server for its counters (SIGUSR1).
[[nodiscard]] Counts counts_of(RunningServer& server);

}  // namespace farshade
