#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "stereo/gltf/gltf.h"
#include "stereo/net/explain.h"
#include "stereo/net/udp.h"
#include "stereo/sealing/handshake.h"
#include "tests/integration/client_program.h"
#include "tests/integration/test_keys.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

const std::string kOtherScene = FARSHADE_ASSETS "/box_over_plane.gltf";

/// The output of a doctor, line by line.
struct Diagnosis {
  int status = -1;
  std::vector<std::string> lines;

  /// The line about `subject`, including its severity. Empty if there is no such line.
  [[nodiscard]] std::string on(const std::string& subject) const {
    const auto at =
        std::ranges::find_if(lines, [&](const auto& l) { return l.substr(6).starts_with(subject + ": "); });
    return at == lines.end() ? "" : *at;
  }
};

/// Runs `program doctor` with `arguments`. `environment` holds NAME=VALUE, or -u and NAME to unset a
/// variable.
Diagnosis ask(const std::string& program, const std::vector<std::string>& arguments,
              const std::vector<std::string>& environment = {}) {
  // Drivers that the Vulkan loader unloads leak memory, see client_arguments().
  std::vector<std::string> all{"/usr/bin/env"};
  all.insert(all.end(), environment.begin(), environment.end());
  all.insert(all.end(), {"LSAN_OPTIONS=detect_leaks=0", program, "doctor"});
  all.insert(all.end(), arguments.begin(), arguments.end());
  ChildProgram child(all);
  Diagnosis diagnosis;
  while (const auto line = child.line_after("")) diagnosis.lines.push_back(*line);
  diagnosis.status = child.wait();
  const std::string secret =
      key_line(test_keys().key).substr(std::string("farshade-key-1 tester ").size(), 64);
  for (const std::string& line : diagnosis.lines) {
    EXPECT_TRUE(line.starts_with("ok    ") || line.starts_with("warn  ") || line.starts_with("FAIL  "))
        << line;
    EXPECT_EQ(line.starts_with("ok"), line.find("; cure: ") == std::string::npos) << line;
    EXPECT_EQ(line.find(secret), std::string::npos) << line;
  }
  return diagnosis;
}

Diagnosis ask_server(const std::vector<std::string>& arguments) {
  return ask(RT_SERVER, arguments);
}

Diagnosis ask_client(const std::vector<std::string>& arguments) {
  return ask(VR_CLIENT, arguments);
}

void expect_ok(const Diagnosis& diagnosis, const std::string& subject, const std::string& words) {
  EXPECT_TRUE(diagnosis.on(subject).starts_with("ok ")) << subject << ": " << diagnosis.on(subject);
  EXPECT_NE(diagnosis.on(subject).find(words), std::string::npos) << diagnosis.on(subject);
}

/// Expects a FAIL line about `subject` that contains `found` and, in its cure, `cure`, and exit status 1.
void expect_fail(const Diagnosis& diagnosis, const std::string& subject, const std::string& found,
                 const std::string& cure) {
  EXPECT_EQ(diagnosis.status, 1);
  const std::string line = diagnosis.on(subject);
  EXPECT_TRUE(line.starts_with("FAIL  ")) << subject << ": " << line;
  EXPECT_NE(line.find(found), std::string::npos) << line;
  const std::size_t told = line.find("; cure: ");
  ASSERT_NE(told, std::string::npos) << line;
  EXPECT_NE(line.find(cure, told), std::string::npos) << line;
}

/// Makes a copy of the test's key file that other users may read.
std::string open_copy(const std::string& file, const fs::path& folder) {
  const fs::path copy = folder / "open.key";
  fs::copy_file(file, copy);
  fs::permissions(copy, fs::perms::others_read, fs::perm_options::add);
  return copy.string();
}

TEST(ServerDoctor, FindsNoFault) {
  const Diagnosis diagnosis =
      ask_server({"--keys", test_keys().ring, "--listen", "127.0.0.1:0", "--scene", kRoom});
  EXPECT_EQ(diagnosis.status, 0);
  expect_ok(diagnosis, "key ring", "1 key");
  expect_ok(diagnosis, "scene", short_form(load_scene(kRoom)->hash));
  expect_ok(diagnosis, "port", "is free");
  expect_ok(diagnosis, "build", "protocol version " + std::to_string(kProtocolVersion));
  expect_ok(diagnosis, "firewall", "this machine only");
}

TEST(ServerDoctor, FailsOnAKeyRingThatIsMissingOrReadableByOthers) {
  const ScratchFolder folder;
  const std::string none = (folder.path() / "none.keys").string();
  expect_fail(ask_server({"--keys", none, "--listen", "127.0.0.1:0"}), "key ring", none, "rt_server keygen");
  const std::string open = open_copy(test_keys().ring, folder.path());
  expect_fail(ask_server({"--keys", open, "--listen", "127.0.0.1:0"}), "key ring", "others than its owner",
              "chmod 600 " + open);
}

TEST(ServerDoctor, FailsOnAPortInUse) {
  const auto taken = listen_udp("127.0.0.1:0");
  const std::string address = to_string((*taken)->local());
  expect_fail(ask_server({"--keys", test_keys().ring, "--listen", address}), "port", address + " is in use",
              "ss -ulpn");
}

TEST(ServerDoctor, WarnsOfAFirewallBeforeAnAddressOfTheNetwork) {
  const Diagnosis diagnosis = ask_server({"--keys", test_keys().ring, "--listen", "0.0.0.0:0"});
  EXPECT_EQ(diagnosis.status, 0);
  EXPECT_TRUE(diagnosis.on("firewall").starts_with("warn ")) << diagnosis.on("firewall");
  EXPECT_NE(diagnosis.on("firewall").find("vr_client doctor --server"), std::string::npos);
}

TEST(ServerDoctor, ChecksEachAddressAndWarnsOnceForEachPortOfTheNetwork) {
  if (!listen_udp("[::1]:0")) GTEST_SKIP() << "this machine has no IPv6";
  const Diagnosis diagnosis =
      ask_server({"--keys", test_keys().ring, "--listen", "[::1]:0", "--listen", "0.0.0.0:0"});
  EXPECT_EQ(diagnosis.status, 0);
  const auto count = [&](const std::string& begin) {
    return std::ranges::count_if(diagnosis.lines, [&](const auto& line) { return line.starts_with(begin); });
  };
  EXPECT_EQ(count("ok    port: [::1]:"), 1);
  EXPECT_EQ(count("ok    port: 0.0.0.0:"), 1);
  EXPECT_EQ(count("warn  firewall: "), 1);
  EXPECT_EQ(count("ok    firewall: "), 0);
  expect_fail(ask_server({"--keys", test_keys().ring, "--listen", "127.0.0.1:0", "--listen", "192.0.2.1:0"}),
              "port", "192.0.2.1:0: this machine does not have that address", "--listen on a free port");
}

TEST(ServerDoctor, FailsOnAMissingScene) {
  expect_fail(ask_server({"--keys", test_keys().ring, "--listen", "127.0.0.1:0", "--scene", "no/such.glb"}),
              "scene", "no/such.glb", "--scene");
}

TEST(ServerDoctor, FailsOnASceneWhoseLightsAreAllDark) {
  const ScratchFolder folder;
  const fs::path dark = folder.path() / "dark.gltf";
  std::ifstream original(FARSHADE_ASSETS "/box_over_plane.gltf");
  nlohmann::json scene = nlohmann::json::parse(original);
  for (nlohmann::json& light : scene["extensions"]["KHR_lights_punctual"]["lights"]) light["intensity"] = 0;
  std::ofstream(dark) << scene;
  expect_fail(ask_server({"--keys", test_keys().ring, "--listen", "127.0.0.1:0", "--scene", dark.string()}),
              "scene", "no light casts shadows", "--light");
}

class ClientDoctor : public testing::Test {
 protected:
  /// Runs the doctor against `server_` with the additional arguments `more`.
  Diagnosis visit(const std::vector<std::string>& more, const std::string& key = test_keys().client) {
    std::vector<std::string> arguments{"--key", key, "--server", server_.address()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return ask_client(arguments);
  }

  ScratchFolder folder_;
  RunningServer server_;
};

TEST_F(ClientDoctor, FindsNoFault) {
  const Diagnosis diagnosis = visit({"--scene", kRoom});
  EXPECT_EQ(diagnosis.status, 0);
  expect_ok(diagnosis, "server", "the same scene");
  expect_ok(diagnosis, "drawing", " opens: ");
  expect_ok(diagnosis, "key file", "1 key");
}

TEST_F(ClientDoctor, NamesTheServersSceneIfItWasGivenNone) {
  const Diagnosis diagnosis = visit({});
  EXPECT_EQ(diagnosis.status, 0);
  expect_ok(diagnosis, "server", short_form(load_scene(kRoom)->hash));
}

TEST_F(ClientDoctor, FailsOnAnotherScene) {
  expect_fail(visit({"--scene", kOtherScene}), "server", short_form(load_scene(kOtherScene)->hash),
              "the same scene file");
}

TEST_F(ClientDoctor, FailsOnAKeyThatTheServerDoesNotKnow) {
  const std::string path = (folder_.path() / "stranger.key").string();
  ASSERT_TRUE(write_key(path, new_key("stranger").value()));
  expect_fail(visit({}, path), "server", "'stranger'", "rt_server keygen");
}

TEST_F(ClientDoctor, FailsOnAKeyFileThatIsMissingOrReadableByOthers) {
  const std::string none = (folder_.path() / "none.key").string();
  const Diagnosis without = visit({}, none);
  expect_fail(without, "key file", none, "rt_server keygen");
  expect_fail(without, "server", "no key", "key file");
  const std::string open = open_copy(test_keys().client, folder_.path());
  expect_fail(visit({}, open), "key file", "others than its owner", "chmod 600 " + open);
}

TEST(ClientDoctorAlone, FailsOnAMissingScene) {
  expect_fail(ask_client({"--key", test_keys().client, "--scene", "no/such.glb"}), "scene", "no/such.glb",
              "--scene");
}

TEST(ClientDoctorAlone, FailsOnAServerThatDoesNotAnswer) {
  auto gone = listen_udp("127.0.0.1:0");
  const std::string address = to_string((*gone)->local());
  const std::vector<std::string> arguments{"--key", test_keys().client, "--server", address};
  // First a port that never answers, as behind a firewall; then a closed port.
  expect_fail(ask_client(arguments), "server", "no answer", "firewall");
  gone->reset();
  expect_fail(ask_client(arguments), "server", "no answer", "start rt_server");
  expect_fail(ask_client({"--key", test_keys().client, "--server", "here:x"}), "server",
              "'here:x' is no address", "rt_server prints");
  expect_fail(ask_client({"--key", test_keys().client, "--server", "no-such-host.invalid"}), "server",
              "'no-such-host.invalid'", "getent hosts");
}

TEST(ClientDoctorAlone, FailsOnAServerOfAnotherVersion) {
  const auto port = listen_udp("127.0.0.1:0");
  std::jthread server([&](const std::stop_token& stop) {
    std::array<std::byte, kMaxDatagram_bytes> buffer;
    std::vector<std::byte> answer;
    while (!stop.stop_requested()) {
      const auto datagram = (*port)->receive(buffer, std::chrono::seconds(1));
      if (!datagram) continue;
      const auto envelope = open_client_envelope(datagram->bytes);
      encode(OpenRefusal{.version = 77, .echo = echo_of(std::get<Hello>(*envelope).client)}, answer);
      (*port)->send(datagram->from, answer);
    }
  });
  const Diagnosis diagnosis =
      ask_client({"--key", test_keys().client, "--server", to_string((*port)->local())});
  const std::string ours = std::to_string(kProtocolVersion);
  expect_fail(diagnosis, "server", "version 77, the client " + ours, "the same source");
}

TEST(ClientDoctorAlone, OnlyWarnsWithoutAWindowSystem) {
  const Diagnosis diagnosis =
      ask(VR_CLIENT, {"--key", test_keys().client}, {"-u", "DISPLAY", "-u", "WAYLAND_DISPLAY"});
  EXPECT_EQ(diagnosis.status, 0);
  EXPECT_TRUE(diagnosis.on("window system").starts_with("warn ")) << diagnosis.on("window system");
}

TEST(ClientDoctorAlone, NamesThePackageOfAMissingVulkanDriver) {
  const Diagnosis diagnosis = ask(VR_CLIENT, {"--key", test_keys().client},
                                  {"VK_DRIVER_FILES=/no/such.json", "VK_ICD_FILENAMES=/no/such.json"});
  expect_fail(diagnosis, "drawing", "no usable Vulkan", "mesa-vulkan-drivers");
}

TEST(DeviceFacts, AreJsonWithTheLimitsOfTheDevice) {
  ChildProgram child(
      {"/usr/bin/env", "LSAN_OPTIONS=detect_leaks=0", VR_CLIENT, "device", "--gpu", "llvmpipe"});
  const auto facts = nlohmann::json::parse(child.output());
  EXPECT_EQ(child.wait(), 0);
  EXPECT_NE(facts.at("name").get<std::string>().find("llvmpipe"), std::string::npos);
  EXPECT_TRUE(facts.at("draws_on_the_cpu").get<bool>());
  EXPECT_GE(facts.at("limits").at("maxImageDimension2D").get<int>(), 4096);
  EXPECT_EQ(facts.at("limits").at("maxComputeWorkGroupCount").size(), 3u);
  EXPECT_FALSE(facts.at("memory").at("heaps").empty());
}

TEST(DeviceFacts, OfNoDeviceAreAFailureThatNamesTheOthers) {
  ChildProgram child(
      {"/usr/bin/env", "LSAN_OPTIONS=detect_leaks=0", VR_CLIENT, "device", "--gpu", "Voodoo2"});
  EXPECT_NE(child.errors().find("its name lacks 'Voodoo2'"), std::string::npos);
  EXPECT_EQ(child.wait(), 1);
}

TEST(Doctors, HaveHelp) {
  for (const std::string program : {RT_SERVER, VR_CLIENT}) {
    ChildProgram child({program, "doctor", "--help"});
    EXPECT_TRUE(child.line_after("  --scene").has_value()) << program;
    EXPECT_EQ(child.wait(), 0);
  }
}

}  // namespace
}  // namespace farshade
