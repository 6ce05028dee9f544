/// Runs vr_client and rt_server for tests: small and short, in a scratch folder, on a port that the system
/// chooses.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "stereo/base/extent.h"
#include "tests/integration/child_program.h"

namespace farshade {

inline const std::string kRoom = FARSHADE_ASSETS "/room.glb", kWalk = FARSHADE_ASSETS "/walk.csv";
inline constexpr Extent kClientSize{96, 64};

/// An rt_server process that accepts clients.
class RunningServer {
 public:
  explicit RunningServer(const std::string& scene = kRoom, const std::string& listen = "127.0.0.1:0",
                         const std::vector<std::string>& more = {});

  [[nodiscard]] const std::string& address() const { return address_; }
  [[nodiscard]] ChildProgram& program() { return program_; }

 private:
  ChildProgram program_;
  std::string address_;
};

/// The command line of vr_client with `options`. By default it plays the walk at kClientSize.
[[nodiscard]] std::vector<std::string> client_arguments(const std::map<std::string, std::string>& options);

struct Ended {
  int status;
  std::string errors;
};
[[nodiscard]] Ended run_client(const std::map<std::string, std::string>& options);

/// The columns of a CSV file by name, without the heading. Fields contain no commas.
using Csv = std::map<std::string, std::vector<std::string>>;
[[nodiscard]] Csv read_csv(const std::filesystem::path& path);

/// A row of summary.csv by group and metric: median, p95, p99. Fails the test if it is missing or not finite.
[[nodiscard]] std::vector<double> summary_row(const std::filesystem::path& out, const std::string& group,
                                              const std::string& metric);

/// The paths of all regular files below `folder`, relative to it.
[[nodiscard]] std::vector<std::string> files_below(const std::filesystem::path& folder);

}  // namespace farshade
