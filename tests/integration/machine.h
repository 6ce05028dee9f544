/// Machine: plays another machine in a test, in namespaces of network, mounts and processes. Virtual cables
/// join them.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/integration/child_program.h"

namespace farshade {

/// Why this machine cannot play several, which also need `programs`; empty if it can.
inline std::string missing_for_machines(const std::vector<std::string>& programs = {}) {
  if (geteuid() != 0) return "namespaces of networks need root";
  std::vector<std::string> all{"/usr/bin/unshare", "/usr/bin/nsenter", "/usr/sbin/ip"};
  all.insert(all.end(), programs.begin(), programs.end());
  for (const std::string& program : all)
    if (!std::filesystem::exists(program)) return program + " is not installed";
  ChildProgram tries({"/usr/bin/unshare", "--net", "--mount", "--pid", "--fork", "/usr/sbin/ip", "link",
                      "add", "cable", "type", "veth", "peer", "name", "other"});
  const std::string why = tries.errors();
  return tries.wait() == 0 ? "" : "this machine allows no namespaces or no veth interfaces: " + why;
}

/// All its processes end with it.
class Machine {
 public:
  Machine()
      : init_({"/usr/bin/unshare", "--net", "--mount", "--pid", "--fork", "--kill-child", "/bin/sh", "-ec",
               "mount -t tmpfs none /run; ip link set lo up; echo up; exec sleep 600"}) {
    EXPECT_TRUE(init_.line_after("up")) << init_.errors();
  }

  [[nodiscard]] pid_t id() const { return init_.id(); }

  /// `arguments` with what runs them here.
  [[nodiscard]] std::vector<std::string> here(std::vector<std::string> arguments) const {
    const std::vector<std::string> enter{"/usr/bin/nsenter", "--net", "--mount", "--target",
                                         std::to_string(id())};
    arguments.insert(arguments.begin(), enter.begin(), enter.end());
    return arguments;
  }
  void shell(const std::string& commands) const {
    ChildProgram program(here({"/bin/sh", "-ec", commands}));
    const std::string errors = program.errors();
    EXPECT_EQ(program.wait(), 0) << commands << ": " << errors;
  }

 private:
  ChildProgram init_;
};

/// Joins two machines by the interface `cable`, with the addresses 192.0.2.2 and 192.0.2.3.
inline void join(const Machine& a, const Machine& b) {
  a.shell("ip link add cable type veth peer name cable netns " + std::to_string(b.id()) +
          "; ip addr add 192.0.2.2/24 dev cable; ip link set cable up");
  b.shell("ip addr add 192.0.2.3/24 dev cable; ip link set cable up");
}

}  // namespace farshade
