// Servers that announce themselves and clients that look for them, as processes on machines of their own: in
// namespaces of network, mounts and processes, joined by a virtual cable, each with its own avahi-daemon.
#include <gtest/gtest.h>

#include "tests/integration/client_program.h"
#include "tests/integration/machine.h"
#include "tests/integration/test_keys.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

const std::vector<std::string> kDaemons{"/usr/sbin/avahi-daemon", "/usr/bin/dbus-daemon"};

/// A system bus on which everybody may do everything.
constexpr const char* kBus =
    "<busconfig><type>system</type><listen>unix:path=/run/dbus/system_bus_socket</listen>"
    "<policy context='default'><allow user='*'/><allow own='*'/><allow send_destination='*'/>"
    "<allow receive_sender='*'/></policy></busconfig>";

/// A machine on which programs announce themselves.
class AnnouncingMachine : public Machine {
 public:
  void start_bus() {
    shell("mkdir /run/dbus; echo \"" + std::string(kBus) + "\" > /run/bus.conf");
    bus_.emplace(here({"/usr/bin/dbus-daemon", "--config-file=/run/bus.conf", "--nofork", "--nopidfile",
                       "--print-address"}));
    ASSERT_TRUE(bus_->line_after("unix:")) << bus_->errors();
  }
  /// With the bus, if it does not run yet. The machine's name is `name`.
  void start_avahi(const std::string& name) {
    if (!bus_) start_bus();
    shell("printf '[server]\\nhost-name=" + name + "\\n' > /run/avahi.conf");
    restart_avahi();
  }
  void restart_avahi() {
    avahi_.reset();
    shell("rm -rf /run/avahi-daemon");
    avahi_.emplace(here({"/usr/sbin/avahi-daemon", "--file=/run/avahi.conf", "--no-drop-root", "--no-chroot",
                         "--no-rlimits"}));
    ASSERT_TRUE(avahi_->error_line_after("Server startup complete.")) << avahi_->errors();
  }

 private:
  std::optional<ChildProgram> bus_, avahi_;
};

ChildProgram start_server(const Machine& machine, const std::string& listen,
                          const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{RT_SERVER,       "--scene", FARSHADE_ASSETS "/box_over_plane.gltf",
                                     "--listen",      listen,    "--keys",
                                     test_keys().ring};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return ChildProgram(machine.here(arguments));
}

/// Waits for a log line with `words`; false if the program ends first.
bool logs(ChildProgram& program, const std::string& words) {
  while (const auto line = program.error_line_after(""))
    if (line->find(words) != std::string::npos) return true;
  return false;
}

Ended client(const Machine& machine, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"/usr/bin/env", "LSAN_OPTIONS=detect_leaks=0", VR_CLIENT});
  arguments.insert(arguments.end(), {"--key", test_keys().client});
  ChildProgram program(machine.here(arguments));
  const std::string errors = program.errors();
  return {program.wait(), errors + program.output()};
}
Ended run_in(const Machine& machine, const ScratchFolder& folder, std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--trace", kWalk, "--frames", "2", "--size", "64x64", "--out",
                                     (folder.path() / "out").string()});
  return client(machine, arguments);
}

#define EXPECT_CONTAINS(text, words) EXPECT_NE((text).find(words), std::string::npos) << (text)

class Announce : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = missing_for_machines(kDaemons); !why.empty()) GTEST_SKIP() << why;
  }
  ScratchFolder folder_;
};

TEST_F(Announce, AClientFindsTheServerOnAnotherMachine) {
  AnnouncingMachine desk, lab;
  join(desk, lab);
  desk.start_avahi("desk");
  lab.start_avahi("lab");
  ChildProgram server = start_server(desk, "0.0.0.0:0");
  const auto listening = server.line_after("rt_server: listening on 0.0.0.0:");
  ASSERT_TRUE(listening) << server.errors();
  const std::string address = "192.0.2.2:" + *listening;
  ASSERT_TRUE(logs(server, "announced on this network as 'desk'"));

  const Ended doctor = client(lab, {"doctor", "--server", "auto"});
  EXPECT_CONTAINS(doctor.errors, "announcement: found 'desk' at " + address);
  EXPECT_CONTAINS(doctor.errors, address + ": the server answers, knows the key");
  // Without a scene, the search comes before its fetch; with one, before the handshake.
  for (const std::vector<std::string>& scene :
       {std::vector<std::string>{}, {"--scene", FARSHADE_ASSETS "/box_over_plane.gltf"}}) {
    std::vector<std::string> arguments{"--server", "auto"};
    arguments.insert(arguments.end(), scene.begin(), scene.end());
    const Ended run = run_in(lab, folder_, arguments);
    EXPECT_EQ(run.status, 0) << run.errors;
    EXPECT_CONTAINS(run.errors, "found the server 'desk' at " + address);
  }

  ChildProgram second = start_server(desk, "0.0.0.0:0");
  ASSERT_TRUE(logs(second, "announced on this network as 'desk #2'"));
  const Ended several = run_in(lab, folder_, {"--server", "auto"});
  EXPECT_EQ(several.status, 1);
  EXPECT_CONTAINS(several.errors, "2 servers announce themselves: 'desk' at " + address + ", 'desk #2' at");
  EXPECT_CONTAINS(client(lab, {"doctor", "--server", "auto/desk"}).errors, address + ": the server answers");

  second.send(SIGTERM);
  EXPECT_EQ(second.wait(), 0);
  desk.restart_avahi();
  // The server announces itself to the new daemon without a further line of its log, so a search may be too
  // early.
  std::string again;
  for (int tries = 0; tries < 10 && again.find("found 'desk'") == std::string::npos; ++tries)
    again = client(lab, {"doctor", "--server", "auto"}).errors;
  EXPECT_CONTAINS(again, "found 'desk' at " + address);
  server.send(SIGTERM);
  EXPECT_EQ(server.wait(), 0);
  // The announcement ends with the server. Its record stays in caches for one more second.
  Ended none{};
  for (int tries = 0; tries < 10 && none.errors.find("no server announces itself") == std::string::npos;
       ++tries)
    none = client(lab, {"doctor", "--server", "auto"});
  EXPECT_EQ(none.status, 1);
  EXPECT_CONTAINS(none.errors, "FAIL  announcement: no server announces itself on this network");
}

TEST_F(Announce, IsOffByOptionAndOnlyOnTheInterfaceWhereTheServerListens) {
  AnnouncingMachine desk, lab;
  join(desk, lab);
  desk.shell(
      "ip link add other type veth peer name end; ip addr add 198.51.100.2/24 dev other; ip link set other "
      "up; ip link set end up");
  desk.start_avahi("desk");
  lab.start_avahi("lab");
  ChildProgram silent = start_server(desk, "0.0.0.0:0", {"--no-announce"}),
               local = start_server(desk, "127.0.0.1:0"), elsewhere = start_server(desk, "198.51.100.2:0");
  for (ChildProgram* program : {&silent, &local})
    ASSERT_TRUE(program->line_after("rt_server: listening on ")) << program->errors();
  ASSERT_TRUE(logs(elsewhere, "announced on this network as 'desk'")) << "the name is free";
  EXPECT_CONTAINS(client(lab, {"doctor", "--server", "auto"}).errors, "no server announces itself");
  EXPECT_CONTAINS(client(desk, {"doctor", "--server", "auto"}).errors, "found 'desk' at 198.51.100.2:");
  for (ChildProgram* program : {&silent, &local}) {
    program->send(SIGTERM);
    EXPECT_EQ(program->errors().find("announce"), std::string::npos);
  }
}

TEST_F(Announce, AServerWithSeveralAddressesIsFoundOnEachOfTheirInterfaces) {
  AnnouncingMachine desk, lab;
  join(desk, lab);
  desk.shell(
      "ip link add other type veth peer name end; ip addr add 198.51.100.2/24 dev other; ip link set other "
      "up; ip link set end up");
  desk.start_avahi("desk");
  lab.start_avahi("lab");
  ChildProgram server =
      start_server(desk, "127.0.0.1:0", {"--listen", "198.51.100.2:0", "--listen", "192.0.2.2:0"});
  const auto other = server.line_after("rt_server: listening on 198.51.100.2:"),
             cable = server.line_after("rt_server: listening on 192.0.2.2:");
  ASSERT_TRUE(other && cable) << server.errors();
  ASSERT_TRUE(logs(server, "announced on this network as 'desk'"));
  EXPECT_CONTAINS(client(lab, {"doctor", "--server", "auto"}).errors,
                  "192.0.2.2:" + *cable + ": the server answers, knows the key");
}

TEST_F(Announce, WithoutADaemonBothProgramsSayWhatIsMissing) {
  AnnouncingMachine desk, lab;
  join(desk, lab);
  desk.start_bus();
  ChildProgram server = start_server(desk, "0.0.0.0:0");
  const auto listening = server.line_after("rt_server: listening on 0.0.0.0:");
  ASSERT_TRUE(listening) << server.errors();
  ASSERT_TRUE(logs(server, "avahi-daemon does not run on this machine"));
  const Ended search = run_in(lab, folder_, {"--server", "auto"});
  EXPECT_EQ(search.status, 1);
  EXPECT_CONTAINS(search.errors, "--server auto needs avahi-daemon");
  EXPECT_CONTAINS(client(lab, {"doctor", "--server", "auto"}).errors,
                  "FAIL  announcement: --server auto needs");
  EXPECT_CONTAINS(client(lab, {"doctor", "--server", "192.0.2.2:" + *listening}).errors,
                  "the server answers, knows the key");

  desk.start_avahi("desk");
  lab.start_avahi("lab");
  ASSERT_TRUE(logs(server, "announced on this network as 'desk'")) << "a daemon that starts later is used";
  server.send(SIGTERM);
  const std::string rest = server.errors();
  EXPECT_EQ(rest.find("does not run on this machine"), rest.rfind("does not run on this machine")) << rest;
}

}  // namespace
}  // namespace farshade
