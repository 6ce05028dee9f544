// rt_server pair and vr_client pair as processes, beside a running server with the same ring.
#include <gtest/gtest.h>

#include "stereo/base/files.h"
#include "tests/integration/client_program.h"
#include "tests/integration/test_keys.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

Ended vr_client(std::vector<std::string> arguments) {
  // The Vulkan loader unloads drivers at the end. A leak suppression cannot name a module that is unloaded.
  const std::vector<std::string> command{"/usr/bin/env", "LSAN_OPTIONS=detect_leaks=0", VR_CLIENT};
  arguments.insert(arguments.begin(), command.begin(), command.end());
  ChildProgram program(arguments);
  std::string errors = program.errors();
  return {program.wait(), errors + program.output()};
}

TEST(PairPrograms, ARunningServerTakesTheKeyOfANewClient) {
  const ScratchFolder folder;
  const std::string ring = (folder.path() / "ring.keys").string(), key = (folder.path() / "a.key").string();
  ASSERT_TRUE(append_to_ring(ring, test_keys().key));
  ChildProgram server({RT_SERVER, "--scene", FARSHADE_ASSETS "/box_over_plane.gltf", "--listen",
                       "127.0.0.1:0", "--keys", ring});
  const auto address = server.line_after("rt_server: listening on ");
  ASSERT_TRUE(address) << server.errors();
  ChildProgram pair({RT_SERVER, "pair", "--listen", "127.0.0.1:0", "--ring", ring});
  const auto code = pair.line_after("  vr_client pair ");
  ASSERT_TRUE(code) << pair.errors();

  std::string mistyped = *code;
  mistyped.back() = mistyped.back() == 'X' ? 'Y' : 'X';
  const Ended wrong = vr_client({"pair", mistyped, "--key", key});
  EXPECT_EQ(wrong.status, 1);
  EXPECT_NE(wrong.errors.find("mistyped"), std::string::npos) << wrong.errors;
  EXPECT_FALSE(std::filesystem::exists(key));

  const Ended paired = vr_client({"pair", *code, "--key", key, "--name", "desk"});
  EXPECT_EQ(paired.status, 0) << paired.errors;
  EXPECT_NE(paired.errors.find("paired with 127.0.0.1: the key 'desk'"), std::string::npos) << paired.errors;
  EXPECT_TRUE(pair.line_after("rt_server: paired with 127.0.0.1:"));
  EXPECT_EQ(pair.wait(), 0);
  EXPECT_EQ(load_key_ring(ring).value().back(), load_key(key).value());

  ASSERT_TRUE(server.error_line_after("[").has_value())
      << "the running server reads its ring again by itself";
  const Ended doctor = vr_client({"doctor", "--server", *address, "--key", key});
  EXPECT_NE(doctor.errors.find("the server answers, knows the key 'desk'"), std::string::npos)
      << doctor.errors;
  server.send(SIGTERM);
  EXPECT_NE(server.errors().find("the key ring was read again: 2 keys"), std::string::npos);

  const Ended again = vr_client({"pair", *code, "--key", key + "2", "--name", "thief"});
  EXPECT_EQ(again.status, 1) << "a code works once";
  EXPECT_NE(again.errors.find("Start rt_server pair again"), std::string::npos) << again.errors;
  const Ended taken = vr_client({"pair", *code, "--key", key});
  EXPECT_EQ(taken.status, 1);
  EXPECT_NE(taken.errors.find("name another file with --key"), std::string::npos) << taken.errors;
  EXPECT_EQ(load_key_ring(ring).value().size(), 2u);
}

TEST(PairPrograms, AClientPairsAtTheSecondAddress) {
  const ScratchFolder folder;
  const std::string ring = (folder.path() / "ring.keys").string(), key = (folder.path() / "a.key").string();
  ChildProgram pair(
      {RT_SERVER, "pair", "--listen", "127.0.0.1:0", "--listen", "127.0.0.2:0", "--ring", ring});
  const auto code = pair.line_after("  vr_client pair farshade://");
  ASSERT_TRUE(code && code->starts_with("127.0.0.1:")) << pair.errors();
  const auto other =
      pair.line_after("rt_server: this machine has more addresses; if " + code->substr(0, code->find('/')) +
                      " does not answer, put another one in its place: 127.0.0.2:");
  ASSERT_TRUE(other);
  const std::string there = "farshade://127.0.0.2:" + *other + code->substr(code->find('/'));
  const Ended paired = vr_client({"pair", there, "--key", key, "--name", "desk"});
  EXPECT_EQ(paired.status, 0) << paired.errors;
  EXPECT_NE(paired.errors.find("paired with 127.0.0.2: the key 'desk'"), std::string::npos) << paired.errors;
  EXPECT_EQ(pair.wait(), 0);
  EXPECT_EQ(load_key_ring(ring).value().back(), load_key(key).value());
}

/// The name may lead to each of the addresses.
TEST(PairPrograms, AHostThatTheUserNamesHasThePortOfEachAddress) {
  const ScratchFolder folder;
  ChildProgram pair({RT_SERVER, "pair", "--listen", "127.0.0.1:0", "--listen", "127.0.0.2:0", "--address",
                     "desk", "--ring", (folder.path() / "ring.keys").string()});
  const auto code = pair.line_after("  vr_client pair farshade://");
  ASSERT_TRUE(code && code->starts_with("desk:")) << pair.errors();
  const std::string first = code->substr(0, code->find('/'));
  const auto other = pair.line_after("rt_server: this machine has more addresses; if " + first +
                                     " does not answer, put another one in its place: ");
  ASSERT_TRUE(other && other->starts_with("desk:"));
  EXPECT_NE(*other, first);
}

TEST(PairPrograms, TheServersAddressesOfAConfigurationFileAreNotThoseOfThePairing) {
  const ScratchFolder folder;
  const std::string file = (folder.path() / "rt_server.ini").string();
  ASSERT_TRUE(write_file_atomically(file, std::string("listen = 192.0.2.1:0\n")));  // of no machine
  ChildProgram pair({RT_SERVER, "--config", file, "pair", "--ring", (folder.path() / "ring.keys").string(),
                     "--minutes", "0.01"});
  const std::string errors = pair.errors();  // nobody came, or another program has the usual port
  EXPECT_EQ(errors.find("192.0.2.1"), errors.npos) << errors;
}

TEST(PairPrograms, EndWithASentenceWithoutAClientOrACode) {
  const ScratchFolder folder;
  const std::string ring = (folder.path() / "ring.keys").string();
  ChildProgram late({RT_SERVER, "pair", "--listen", "127.0.0.1:0", "--ring", ring, "--minutes", "0.01"});
  EXPECT_EQ(late.wait(), 1);
  EXPECT_NE(late.errors().find("no client came"), std::string::npos) << late.errors();
  ChildProgram stopped({RT_SERVER, "pair", "--listen", "127.0.0.1:0", "--ring", ring});
  ASSERT_TRUE(stopped.line_after("  vr_client pair "));
  stopped.send(SIGINT);
  EXPECT_GT(stopped.wait(), 0);
  EXPECT_FALSE(std::filesystem::exists(ring));
  const Ended nonsense = vr_client({"pair", "nonsense"});
  EXPECT_EQ(nonsense.status, 1);
  EXPECT_NE(nonsense.errors.find("copy the whole line"), std::string::npos) << nonsense.errors;
}

}  // namespace
}  // namespace farshade
