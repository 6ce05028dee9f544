#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "stereo/gltf/gltf.h"
#include "stereo/link/network_link.h"
#include "stereo/net/udp.h"
#include "stereo/sealing/handshake.h"
#include "tests/integration/child_program.h"
#include "tests/integration/one_triangle.h"
#include "tests/integration/test_keys.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

const std::string kScene = FARSHADE_ASSETS "/box_over_plane.gltf";
const std::string kRoomFile = FARSHADE_ASSETS "/room.glb";

std::vector<std::string> server(const std::string& scene, const std::string& listen = "127.0.0.1:0") {
  return {RT_SERVER, "--scene", scene, "--listen", listen, "--keys", test_keys().ring};
}

/// Runs a program that must fail with one line of text; returns that line.
std::string complaint_of(const std::vector<std::string>& arguments) {
  ChildProgram program(arguments);
  const int status = program.wait();
  EXPECT_GT(status, 0);
  std::string errors = program.errors();
  EXPECT_EQ(std::ranges::count(errors, '\n'), 1) << errors;
  EXPECT_TRUE(errors.starts_with("rt_server: ")) << errors;
  return errors;
}

/// The answer of the server at `address` to the hello of a client with `key` and `scene`.
ServerMessage answer_to(const SharedKey& key, const ContentHash& scene, const std::string& address) {
  const auto client = connect_udp(address);
  ClientHandshake handshake(key, scene);
  std::array<std::byte, kMaxDatagram_bytes> buffer;
  std::vector<std::byte> hello;
  for (int round_trip = 0; round_trip < 2; ++round_trip) {
    handshake.write_hello(hello);
    client->port->send(client->server, hello);
    const auto datagram = client->port->receive(buffer, std::chrono::seconds(30));
    if (!datagram) throw std::runtime_error("rt_server does not answer");
    const auto envelope = open_server_envelope(datagram->bytes).value();
    if (const auto* retry = std::get_if<Retry>(&envelope)) {
      if (!handshake.take(*retry)) throw std::runtime_error("not our cookie");
    } else {
      return handshake.take(std::get<Accept>(envelope), datagram->bytes).value().answer;
    }
  }
  throw std::runtime_error("a handshake takes two round trips");
}

TEST(ServerProgram, PrintsItsPlanAndEnds) {
  for (const auto& [plan, said] : {std::pair{"--plan", "plan for box_over_plane.gltf: what it needs"},
                                   {"--plan=", "plan for box_over_plane.gltf: what it needs"}}) {
    ChildProgram program({RT_SERVER, "--scene", kScene, plan});
    EXPECT_TRUE(program.line_after(said)) << plan;
    EXPECT_TRUE(program.line_after("  masks        2 of 2 lights cast shadows")) << plan;
    EXPECT_EQ(program.wait(), 0) << program.errors();
  }
  ChildProgram wrong({RT_SERVER, "--scene", kScene, "--plan=all"});
  EXPECT_NE(wrong.wait(), 0);
}

TEST(ServerProgram, HasOneListOfSessionsForAllItsAddresses) {
  std::vector<std::string> arguments = server(kScene);
  arguments.insert(arguments.end(),
                   {"--listen", "127.0.0.2:0", "--listen", "127.0.0.3:0", "--sessions", "2"});
  ChildProgram program(arguments);
  const ContentHash hash = load_scene(kScene)->hash;
  std::vector<ServerMessage> answers;
  for (int i = 1; i <= 3; ++i) {
    const std::string host = "127.0.0." + std::to_string(i) + ":";
    const auto port = program.line_after("rt_server: listening on " + host);
    ASSERT_TRUE(port.has_value()) << program.errors();
    answers.push_back(answer_to(test_keys().key, hash, host + *port));
  }
  EXPECT_TRUE(std::holds_alternative<Welcome>(answers[0]) && std::holds_alternative<Welcome>(answers[1]));
  EXPECT_EQ(std::get<Refusal>(answers[2]).reason, RefusalReason::Busy);
}

TEST(ServerProgram, ListensOnEachAddressOfAConfigurationFileAndOfTheCommandLineInItsPlace) {
  const ScratchFolder folder;
  const std::string file = (folder.path() / "rt_server.ini").string();
  std::ofstream(file) << "listen = 127.0.0.4:0\nlisten = 127.0.0.5:0\n";
  std::vector<std::string> arguments{RT_SERVER, "--config",      file, "--scene", kScene,
                                     "--keys",  test_keys().ring};
  ChildProgram by_file(arguments);
  EXPECT_TRUE(by_file.line_after("rt_server: listening on 127.0.0.4:")) << by_file.errors();
  EXPECT_TRUE(by_file.line_after("rt_server: listening on 127.0.0.5:"));
  arguments.insert(arguments.end(), {"--listen", "127.0.0.6:0"});
  ChildProgram by_line(arguments);
  EXPECT_TRUE(by_line.line_after("rt_server: listening on 127.0.0.6:")) << by_line.errors();
  by_line.send(SIGTERM);
  EXPECT_EQ(by_line.wait(), 0);
  EXPECT_EQ(by_line.output().find("listening on 127.0.0.4"), std::string::npos);
}

class ServerProgram : public testing::TestWithParam<int> {};

TEST_P(ServerProgram, ListensAnswersAndEndsCleanlyOnSignal) {
  ChildProgram program(server(kScene));
  const auto address = program.line_after("rt_server: listening on ");
  ASSERT_TRUE(address.has_value()) << program.errors();
  const ContentHash hash = load_scene(kScene)->hash;
  const SharedKey& key = test_keys().key;
  EXPECT_EQ(std::get<Welcome>(answer_to(key, hash, *address)).scene_hash, hash);
  EXPECT_EQ(std::get<Refusal>(answer_to(key, {1}, *address)).reason, RefusalReason::SceneMismatch);
  for (const int signal : {SIGUSR1, GetParam()}) {
    program.send(signal);
    EXPECT_TRUE(program.line_after("rt_server: 1 clients, 0 requests, ").has_value());
  }
  EXPECT_EQ(program.wait(), 0);
  EXPECT_NE(program.errors().find("give both the same scene file"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Signals, ServerProgram, testing::Values(SIGINT, SIGTERM));

TEST(ServerProgramRefuses, MissingScene) {
  EXPECT_NE(complaint_of(server("no/such.glb")).find("no/such.glb"), std::string::npos);
}

TEST(ServerProgramRefuses, BadAddress) {
  EXPECT_NE(complaint_of(server(kScene, "here:x")).find("'here:x' is no address"), std::string::npos);
}

TEST(ServerProgramRefuses, PortInUse) {
  const auto taken = listen_udp("127.0.0.1:0");
  ASSERT_TRUE(taken.has_value());
  EXPECT_NE(complaint_of(server(kScene, to_string((*taken)->local()))).find("is in use"), std::string::npos);
}

TEST(ServerProgramRefuses, AddressesThatCannotStandTogetherOrAreOfAnotherMachine) {
  for (const auto& [first, second, complaint] :
       {std::tuple{"127.0.0.1:0", "127.0.0.1:0",
                   "on both 127.0.0.1:0 and 127.0.0.1:0: give each address once"},
        {"127.0.0.1:7447", "0.0.0.0",
         "on both 0.0.0.0:7447 and 127.0.0.1:7447: the first includes the second"},
        {"127.0.0.1:0", "192.0.2.1:0", "on 192.0.2.1:0: this machine does not have that address"}}) {
    std::vector<std::string> arguments = server(kScene, first);
    arguments.insert(arguments.end(), {"--listen", second});
    EXPECT_NE(complaint_of(arguments).find(complaint), std::string::npos) << complaint;
    const std::string said =
        complaint_of({RT_SERVER, "pair", "--ring", test_keys().ring, "--listen", first, "--listen", second});
    EXPECT_TRUE(said.starts_with("rt_server: cannot listen on ")) << said;
  }
}

TEST(ServerProgramRefuses, ARingThatIsNotThereOrThatOthersCanRead) {
  const ScratchFolder folder;
  const std::filesystem::path ring = folder.path() / "ring.keys";
  const std::vector<std::string> arguments{RT_SERVER, "--scene", kScene, "--keys", ring.string()};
  EXPECT_NE(complaint_of(arguments).find("rt_server keygen"), std::string::npos);
  std::filesystem::copy_file(test_keys().ring, ring);
  std::filesystem::permissions(ring, std::filesystem::perms::others_read, std::filesystem::perm_options::add);
  EXPECT_NE(complaint_of(arguments).find("chmod 600"), std::string::npos);
}

TEST(ServerProgramRefuses, ToBeInsecureOnANetworkAlsoWithASecondAddress) {
  const auto complaint = [](const std::vector<std::string>& listen) {
    std::vector<std::string> arguments{"/usr/bin/timeout", "200", RT_SERVER, "--scene", kScene, "--insecure"};
    for (const std::string& address : listen) arguments.insert(arguments.end(), {"--listen", address});
    return complaint_of(arguments);
  };
  EXPECT_NE(complaint({"0.0.0.0:0"}).find("this machine alone: 0.0.0.0:"), std::string::npos);
  if (!listen_udp("[::1]:0")) GTEST_SKIP() << "this machine has no IPv6";
  EXPECT_NE(complaint({"[::1]:0", "0.0.0.0:0"}).find("this machine alone: 0.0.0.0:"), std::string::npos);
}

TEST(ServerProgramRefuses, ANetworkThatIsNone) {
  std::vector<std::string> arguments = server(kScene);
  arguments.insert(arguments.end(), {"--net", "lost=2%"});
  EXPECT_NE(complaint_of(arguments).find("lost"), std::string::npos);
}

TEST(ServerKeygen, MakesAKeyThatLetsAClientIn) {
  const ScratchFolder folder;
  const std::string key = (folder.path() / "a.key").string(), ring = (folder.path() / "ring.keys").string();
  for (const std::string name : {"alice", "bob"}) {
    ChildProgram keygen({RT_SERVER, "keygen", name, "--key", key + name, "--ring", ring});
    EXPECT_EQ(keygen.wait(), 0) << keygen.errors();
  }
  ChildProgram program({RT_SERVER, "--scene", kScene, "--listen", "127.0.0.1:0", "--keys", ring});
  const auto address = program.line_after("rt_server: listening on ");
  ASSERT_TRUE(address.has_value()) << program.errors();
  const ContentHash hash = load_scene(kScene)->hash;
  EXPECT_TRUE(std::holds_alternative<Welcome>(answer_to(load_key(key + "bob").value(), hash, *address)));
  program.send(SIGTERM);
  EXPECT_NE(program.errors().find("welcomed bob at 127.0.0.1:"), std::string::npos);
}

TEST(ServerProgram, ReadsItsKeysAgainAtAHangupAndLivesOn) {
  const ScratchFolder folder;
  const std::string ring = (folder.path() / "ring.keys").string();
  ASSERT_TRUE(append_to_ring(ring, new_key("first").value()));
  ChildProgram program({RT_SERVER, "--scene", kScene, "--listen", "127.0.0.1:0", "--keys", ring});
  const auto address = program.line_after("rt_server: listening on ");
  ASSERT_TRUE(address.has_value()) << program.errors();
  const SharedKey second = new_key("second").value();
  ASSERT_TRUE(append_to_ring(ring, second));
  program.send(SIGHUP);
  ASSERT_TRUE(program.error_line_with("the key ring was read again: 2 keys"));
  const ContentHash hash = load_scene(kScene)->hash;
  EXPECT_TRUE(std::holds_alternative<Welcome>(answer_to(second, hash, *address)));
  std::filesystem::permissions(ring, std::filesystem::perms::others_read, std::filesystem::perm_options::add);
  program.send(SIGHUP);
  EXPECT_TRUE(program.error_line_with("nobody new is admitted, because the key ring cannot be read"))
      << program.errors();
  program.send(SIGTERM);  // not before: the server looks for a stop first
  EXPECT_EQ(program.wait(), 0);
}

/// Whether the server welcomes a client with `key` within the time that a hello may need.
bool admits(const SharedKey& key, const std::string& address) {
  static const ContentHash hash = load_scene(kScene)->hash;
  const auto client = connect_udp(address);
  LinkTarget target{client->server, key, hash, {2}};
  const SteadyClock clock;
  NetworkLink link(*client->port, clock, target, Assembler::kKept + 2);
  return link.connect(std::chrono::seconds(1)).has_value();
}

/// Tries for so long that the slowest machine has looked at its ring.
bool admits_soon(const SharedKey& key, const std::string& address) {
  for (int tries = 0; tries < 60; ++tries)
    if (admits(key, address)) return true;
  return false;
}

TEST(ServerProgram, AdmitsNobodyWhileItsRingCannotBeReadAndTriesAgain) {
  const ScratchFolder folder;
  const std::string ring = (folder.path() / "ring.keys").string();
  const SharedKey key = new_key("first").value(), later = new_key("later").value();
  ASSERT_TRUE(append_to_ring(ring, key));
  ChildProgram program({RT_SERVER, "--scene", kScene, "--listen", "127.0.0.1:0", "--keys", ring});
  const auto address = program.line_after("rt_server: listening on ");
  ASSERT_TRUE(address.has_value()) << program.errors();
  EXPECT_TRUE(admits(key, *address));
  std::ofstream(ring, std::ios::app) << "no key\n";
  // Whoever asks for the counters all the time does not keep the server from looking.
  std::atomic<bool> over = false;
  std::jthread asks([&] {
    for (; !over; std::this_thread::sleep_for(std::chrono::milliseconds(300))) program.send(SIGUSR1);
  });
  EXPECT_TRUE(program.error_line_with("nobody new is admitted, because the key ring cannot be read"));
  EXPECT_FALSE(admits(key, *address));
  over = true;
  asks.join();
  std::filesystem::remove(ring);
  ASSERT_TRUE(append_to_ring(ring, later));  // its time may be that of the ring which could not be read
  EXPECT_TRUE(admits_soon(later, *address));
  EXPECT_FALSE(admits(key, *address)) << "it is no longer in the ring";
}

TEST(ServerProgram, ARingWithoutKeysAdmitsNobody) {
  const ScratchFolder folder;
  const std::string ring = (folder.path() / "ring.keys").string();
  const SharedKey key = new_key("first").value();
  ASSERT_TRUE(append_to_ring(ring, key));
  ChildProgram program({RT_SERVER, "--scene", kScene, "--listen", "127.0.0.1:0", "--keys", ring});
  const auto address = program.line_after("rt_server: listening on ");
  ASSERT_TRUE(address.has_value()) << program.errors();
  const ContentHash hash = load_scene(kScene)->hash;
  EXPECT_TRUE(std::holds_alternative<Welcome>(answer_to(key, hash, *address)));
  std::ofstream(ring, std::ios::trunc) << "# all are revoked\n";
  program.send(SIGHUP);
  EXPECT_TRUE(program.error_line_with("contains no key"));
  EXPECT_FALSE(admits(key, *address));
  program.send(SIGTERM);
  EXPECT_NE(program.errors().find("the session of first at "), std::string::npos) << program.errors();
}

TEST(ServerProgram, LivesOnWhenNobodyReadsItsOutputAnyMore) {
  for (const bool are_closed : {false, true}) {
    ChildProgram program(server(kScene));
    const auto address = program.line_after("rt_server: listening on ");
    ASSERT_TRUE(address.has_value()) << program.errors();
    if (are_closed)
      program.close_pipes();
    else
      program.stop_reading();
    for (int i = 0; i < 100; ++i) {
      program.send(SIGUSR1);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_TRUE(admits(test_keys().key, *address));
    program.send(SIGTERM);
    EXPECT_EQ(program.wait(), 0) << are_closed;
  }
}

TEST(ServerProgramRefuses, ACommandLineWithStatus2) {
  const std::vector<std::vector<std::string>> wrong{{RT_SERVER},
                                                    {RT_SERVER, "--no-such-option"},
                                                    {RT_SERVER, "keygen"},
                                                    {RT_SERVER, "--scene", kScene, "--plan=all"}};
  for (const std::vector<std::string>& arguments : wrong) {
    ChildProgram program(arguments);
    EXPECT_EQ(program.wait(), 2) << arguments.back();
    EXPECT_NE(program.errors().find("see --help"), std::string::npos) << program.errors();
  }
}

TEST(ServerProgramRefuses, AMisspeltOptionWithASuggestion) {
  EXPECT_EQ(complaint_of({RT_SERVER, "--scnee", kScene}),
            "rt_server: unknown option --scnee; did you mean --scene? (see --help)\n");
}

TEST(ServerProgram, ReadsAConfigurationFileAndRefusesAnUnknownKeyInIt) {
  const ScratchFolder folder;
  const std::string file = (folder.path() / "rt_server.ini").string();
  std::ofstream(file) << "scene = " << kScene << "\nplan =\n";
  ChildProgram plan({RT_SERVER, "--config", file});
  EXPECT_EQ(plan.wait(), 0) << plan.errors();
  EXPECT_NE(plan.output().find("plan for box_over_plane.gltf"), std::string::npos) << plan.output();
  std::ofstream(file) << "scnee = " << kScene << "\n";
  EXPECT_EQ(complaint_of({RT_SERVER, "--config", file}),
            "rt_server: " + file + ": unknown key 'scnee'; did you mean scene? (see --help)\n");
}

TEST(ServerProgramRefuses, SceneWhoseLightsAreDark) {
  const ScratchFolder folder;
  EXPECT_NE(complaint_of(server(scene_with_a_dark_light(folder.path()))).find("nothing to serve"),
            std::string::npos);
}

TEST(ServerProgram, GivesASceneWithoutLightsASunAndALamp) {
  const ScratchFolder folder;
  ChildProgram program(server(one_triangle(folder.path(), "unlit.gltf", "")));
  const auto note = program.line_after("rt_server: unlit.gltf has no lights: ");
  ASSERT_TRUE(note) << program.errors();
  EXPECT_NE(note->find("--sun"), std::string::npos);
  const auto served = program.line_after("rt_server: serving unlit.gltf, ");
  ASSERT_TRUE(served);
  EXPECT_NE(served->find("2 lights"), std::string::npos) << *served;
}

/// The output of rt_server inspect.
std::string inspected(const std::vector<std::string>& arguments) {
  std::vector<std::string> all{RT_SERVER, "inspect"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  ChildProgram program(all);
  EXPECT_EQ(program.wait(), 0) << program.errors();
  return program.output();
}

TEST(ServerInspect, TellsInWordsWhatAFileHasAndWhatIsChosen) {
  const std::string room = inspected({kRoomFile});
  for (const char* part : {"room.glb: ", " triangles in ", " x 2.7 x ", "camera     of the file",
                           "light      point", "animation  ", "memory     about "})
    EXPECT_NE(room.find(part), std::string::npos) << part << "\n" << room;
  EXPECT_EQ(room.find("note"), std::string::npos) << room;
  const ScratchFolder folder;
  const std::string unlit = inspected({one_triangle(folder.path(), "unlit.gltf", "")});
  for (const char* part : {"unlit.gltf: 1 triangles", "camera     chosen", "light      directional 'sun'",
                           "note       unlit.gltf has no lights"})
    EXPECT_NE(unlit.find(part), std::string::npos) << part << "\n" << unlit;
}

TEST(ServerInspect, PrintsTheSameAsJson) {
  const auto facts = nlohmann::json::parse(inspected({kRoomFile, "--json", "--sun", "90,45"}));
  EXPECT_EQ(facts["lights"].size(), 4u);
  EXPECT_EQ(facts["lights"][3]["name"], "sun");
  EXPECT_TRUE(facts["lights"][3]["casts"]);
  EXPECT_GT(facts["triangles"], 1000);
  EXPECT_NEAR(facts["size_m"][1].get<double>(), 2.7, 0.01);
  EXPECT_GT(facts["tracer_bytes"], 100'000);
}

TEST(ServerInspect, SaysWhyAFileIsRefused) {
  EXPECT_NE(complaint_of({RT_SERVER, "inspect", "no/such.glb"}).find("no/such.glb"), std::string::npos);
}

TEST(ServerProgramRefuses, LightsThatMakeNoSense) {
  std::vector<std::string> arguments = server(kScene);
  arguments.insert(arguments.end(), {"--light", "point,at=0:1"});
  ChildProgram program(arguments);
  EXPECT_GT(program.wait(), 0);
  EXPECT_NE(program.errors().find("'at=0:1' cannot be read"), std::string::npos) << program.errors();
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string> with_ready_file(std::vector<std::string> arguments,
                                         const std::filesystem::path& file) {
  arguments.insert(arguments.end(), {"--ready-file", file.string()});
  return arguments;
}

TEST(ServerReadyFile, HoldsTheAddressOnceClientsCanConnect) {
  const ScratchFolder folder;
  const std::filesystem::path ready = folder.path() / "ready";
  std::ofstream(ready) << "listening 192.0.2.1:1\n";  // of an earlier server
  ChildProgram program(with_ready_file(server(kScene), ready));
  ASSERT_TRUE(program.line_after("rt_server: the tracer holds ")) << program.errors();
  const auto expired = std::chrono::steady_clock::now() + std::chrono::seconds(200);
  std::string text;
  while (text.empty() && std::chrono::steady_clock::now() < expired) text = text_of(ready);
  ASSERT_TRUE(text.starts_with("listening 127.0.0.1:")) << text;
  ASSERT_TRUE(text.ends_with("\n"));
  const std::string address = text.substr(10, text.size() - 11);
  const ContentHash hash = load_scene(kScene)->hash;
  EXPECT_TRUE(std::holds_alternative<Welcome>(answer_to(test_keys().key, hash, address)));
}

TEST(ServerReadyFile, IsGoneWhenTheServerHasEnded) {
  const ScratchFolder folder;
  const std::filesystem::path ready = folder.path() / "ready";
  ChildProgram program(with_ready_file(server(kScene), ready));
  while (text_of(ready).empty()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  program.send(SIGTERM);
  EXPECT_EQ(program.wait(), 0);
  EXPECT_FALSE(std::filesystem::exists(ready));
}

TEST(ServerReadyFile, HasALineForEachAddress) {
  const ScratchFolder folder;
  const std::filesystem::path ready = folder.path() / "ready";
  std::vector<std::string> arguments = with_ready_file(server(kScene), ready);
  arguments.insert(arguments.end(), {"--listen", "127.0.0.2:0"});
  ChildProgram program(arguments);
  std::string lines;
  for (int i = 0; i < 2; ++i)
    lines += "listening " + program.line_after("rt_server: listening on ").value_or("") + "\n";
  const auto expired = std::chrono::steady_clock::now() + std::chrono::seconds(200);
  while (text_of(ready).empty() && std::chrono::steady_clock::now() < expired) {
  }
  EXPECT_EQ(text_of(ready), lines);
  EXPECT_NE(lines.find("\nlistening 127.0.0.2:"), std::string::npos) << lines;
}

TEST(ServerReadyFile, SaysThatNoLightCastsShadowsAndTheServerSucceeds) {
  const ScratchFolder folder;
  const std::filesystem::path ready = folder.path() / "ready";
  ChildProgram program(with_ready_file(server(scene_with_a_dark_light(folder.path())), ready));
  EXPECT_EQ(program.wait(), 0) << program.errors();
  EXPECT_EQ(text_of(ready), "no-shadows\n");
}

TEST(ServerReadyFile, IsGoneWhenTheServerCannotStart) {
  const ScratchFolder folder;
  const std::filesystem::path ready = folder.path() / "ready";
  std::ofstream(ready) << "listening 192.0.2.1:1\n";
  complaint_of(with_ready_file(server("no/such.glb"), ready));
  EXPECT_FALSE(std::filesystem::exists(ready));
}

TEST(ServerReadyFile, ThatCannotBeWrittenIsAnError) {
  const ScratchFolder folder;
  const std::filesystem::path ready = folder.path() / "no" / "ready";
  ChildProgram program(with_ready_file(server(kScene), ready));
  EXPECT_GT(program.wait(), 0);
  EXPECT_NE(program.errors().find(ready.string()), std::string::npos);
}

}  // namespace
}  // namespace farshade
