#include "rt_server/commands/commands.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include "stereo/sealing/key_file.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

/// Runs `rt_server keygen ARGUMENTS`.
Expected<std::string> keygen_with(const std::string& arguments) {
  CLI::App program;
  KeygenOptions options;
  add_keygen(program, options);
  program.parse("keygen " + arguments);
  return keygen(options);
}

/// Both default files are in a scratch folder.
class Keygen : public testing::Test {
 protected:
  void SetUp() override { ::setenv("XDG_CONFIG_HOME", folder_.path().c_str(), 1); }
  void TearDown() override { ::unsetenv("XDG_CONFIG_HOME"); }
  ScratchFolder folder_;
};

TEST_F(Keygen, WritesTheClientsFileAndAddsToTheRing) {
  const auto said = keygen_with("desk");
  ASSERT_TRUE(said) << said.error().what;
  const SharedKey key = load_key(folder_.path() / "farshade" / "client.key").value();
  EXPECT_EQ(key.name, "desk");
  EXPECT_EQ(load_key_ring(folder_.path() / "farshade" / "ring.keys").value(), std::vector{key});
  EXPECT_NE(said->find(default_key_path().string()), std::string::npos) << *said;
  EXPECT_NE(said->find(default_ring_path().string()), std::string::npos) << *said;
  EXPECT_EQ(said->find(key_line(key).substr(20, 64)), std::string::npos) << "the secret is not printed";
}

TEST_F(Keygen, TakesOtherPlaces) {
  const fs::path file = folder_.path() / "b.key", ring = folder_.path() / "ring";
  ASSERT_TRUE(keygen_with("a --key " + (folder_.path() / "a.key").string() + " --ring " + ring.string()));
  ASSERT_TRUE(keygen_with("b --key " + file.string() + " --ring " + ring.string()));
  EXPECT_EQ(load_key_ring(ring).value().size(), 2u);
  EXPECT_EQ(load_key_ring(ring).value()[1], load_key(file).value());
  EXPECT_FALSE(fs::exists(folder_.path() / "farshade"));
}

TEST_F(Keygen, WritesLimitsIntoTheRingAlone) {
  ASSERT_TRUE(keygen_with("desk --until 2027-01-31 --sessions 2 --bytes-per-second 1000000"));
  EXPECT_EQ(load_key(default_key_path()).value().limits, KeyLimits{});
  const KeyLimits limits = load_key_ring(default_ring_path()).value().at(0).limits;
  EXPECT_EQ(limits.until, parse_day("2027-01-31"));
  EXPECT_EQ(limits.sessions, 2u);
  EXPECT_EQ(limits.bytes_per_second, 1'000'000u);
  for (const char* bad :
       {"a --until tomorrow", "a --until 2027-02-30", "a --sessions 0", "a --bytes-per-second 1"})
    EXPECT_THROW(static_cast<void>(keygen_with(bad)), CLI::ParseError) << bad;
}

TEST_F(Keygen, AsksForAPlaceWhereTheDefaultOneIsTaken) {
  ASSERT_TRUE(keygen_with("a"));
  const auto said = keygen_with("b");
  ASSERT_FALSE(said);
  EXPECT_EQ(said.error().fault, Fault::Unavailable);
  EXPECT_NE(said.error().what.find("--key"), std::string::npos) << said.error().what;
  EXPECT_EQ(load_key_ring(default_ring_path()).value().size(), 1u);
}

TEST_F(Keygen, LeavesNoFileForANameThatTheRingHas) {
  ASSERT_TRUE(keygen_with("a"));
  const fs::path file = folder_.path() / "again.key";
  EXPECT_EQ(keygen_with("a --key " + file.string()).error().fault, Fault::Unavailable);
  EXPECT_FALSE(fs::exists(file));
}

}  // namespace
}  // namespace farshade
