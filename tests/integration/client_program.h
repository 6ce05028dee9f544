/// vr_client and rt_server as the tests run them: small, short, in a scratch folder, on a port of the
/// system's choice.
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

/// An rt_server that listens.
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

/// vr_client with `options`, along the walk at kClientSize unless they say otherwise.
[[nodiscard]] std::vector<std::string> client_arguments(const std::map<std::string, std::string>& options);

struct Ended {
  int status;
  std::string errors;
};
[[nodiscard]] Ended run_client(const std::map<std::string, std::string>& options);

/// Column name to fields, top row first. Fields hold no commas.
using Csv = std::map<std::string, std::vector<std::string>>;
[[nodiscard]] Csv read_csv(const std::filesystem::path& path);

/// A row of summary.csv by group and metric: median, p95, p99. Fails the test if it is missing or not finite.
[[nodiscard]] std::vector<double> summary_row(const std::filesystem::path& out, const std::string& group,
                                              const std::string& metric);

/// All regular files below `folder`, as paths from it.
[[nodiscard]] std::vector<std::string> files_below(const std::filesystem::path& folder);

}  // namespace farshade
