#include "stereo/sealing/key_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>
#include <new>
#include <set>
#include <thread>

#include "stereo/base/files.h"
#include "tests/support/watched_sodium.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

SharedKey key_of(std::string name, std::uint8_t first_byte) {
  SharedKey key{std::move(name), {}};
  key.secret.fill(0xa5);
  key.secret[0] = first_byte;
  return key;
}

fs::perms mode_of(const fs::path& path) {
  return fs::status(path).permissions();
}
constexpr fs::perms k0600 = fs::perms::owner_read | fs::perms::owner_write;

std::string text_of(const fs::path& path) {
  const auto bytes = read_file(path, kMaxKeyFileBytes).value();
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void write_0600(const fs::path& path, std::string_view text) {
  ASSERT_TRUE(write_private_file(path, text, IfThere::Replace));
}

TEST(KeyFile, LineIsFormatNameAndHex) {
  EXPECT_EQ(key_line(key_of("desk", 0x0f)),
            "farshade-key-1 desk 0fa5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5a5\n");
}

TEST(KeyFile, ComesBackAsWritten) {
  const ScratchFolder folder;
  const SharedKey key = new_key("desk-2.left_hand").value();
  ASSERT_TRUE(write_key(folder.path() / "a.key", key));
  EXPECT_EQ(load_key(folder.path() / "a.key").value(), key);
}

TEST(KeyFile, IsItsOwnersAloneWhateverTheUmask) {
  const ScratchFolder folder;
  const mode_t before = ::umask(0);
  const bool written = write_key(folder.path() / "new" / "a.key", key_of("a", 1)).has_value() &&
                       append_to_ring(folder.path() / "ring", key_of("a", 1)).has_value() &&
                       append_to_ring(folder.path() / "ring", key_of("b", 2)).has_value();
  ::umask(before);
  ASSERT_TRUE(written);
  EXPECT_EQ(mode_of(folder.path() / "new" / "a.key"), k0600);
  EXPECT_EQ(mode_of(folder.path() / "ring"), k0600);
  EXPECT_EQ(mode_of(folder.path() / "new"), fs::perms::owner_all);
}

TEST(KeyFile, RefusesWhatOthersMayReadOrWrite) {
  const ScratchFolder folder;
  const fs::path path = folder.path() / "a.key";
  ASSERT_TRUE(write_key(path, key_of("a", 1)));
  for (const auto perm :
       {fs::perms::group_read, fs::perms::group_write, fs::perms::others_read, fs::perms::others_write}) {
    fs::permissions(path, k0600 | perm);
    const auto key = load_key(path);
    ASSERT_FALSE(key) << static_cast<unsigned>(perm);
    EXPECT_EQ(key.error().fault, Fault::Unreadable);
    EXPECT_NE(key.error().what.find("chmod 600 " + path.string()), std::string::npos) << key.error().what;
    EXPECT_FALSE(append_to_ring(path, key_of("b", 2)));
  }
  fs::permissions(path, fs::perms::owner_read);
  EXPECT_TRUE(load_key(path));
}

TEST(KeyFile, RefusesWhatIsAnotherUsers) {
  const ScratchFolder folder;
  const fs::path path = folder.path() / "a.key";
  ASSERT_TRUE(write_key(path, key_of("a", 1)));
  if (::chown(path.c_str(), ::geteuid() + 1, static_cast<gid_t>(-1)) != 0)
    GTEST_SKIP() << "only root may change the owner of a file";
  const auto key = load_key(path);
  ASSERT_FALSE(key);
  EXPECT_EQ(key.error().fault, Fault::Unreadable);
  EXPECT_NE(key.error().what.find("another user"), std::string::npos) << key.error().what;
}

TEST(KeyFile, IsNeverOverwritten) {
  const ScratchFolder folder;
  const fs::path path = folder.path() / "a.key";
  ASSERT_TRUE(write_key(path, key_of("a", 1)));
  const auto again = write_key(path, key_of("b", 2));
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().fault, Fault::Unavailable);
  EXPECT_EQ(load_key(path).value(), key_of("a", 1));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
}

TEST(KeyFile, OfAClientHasExactlyOneKey) {
  const ScratchFolder folder;
  write_0600(folder.path() / "none", "# empty\n");
  write_0600(folder.path() / "two", key_line(key_of("a", 1)) + key_line(key_of("b", 2)));
  EXPECT_EQ(load_key(folder.path() / "none").error().fault, Fault::Malformed);
  EXPECT_EQ(load_key(folder.path() / "two").error().fault, Fault::Malformed);
  EXPECT_EQ(load_key(folder.path() / "missing").error().fault, Fault::Missing);
}

TEST(KeyRing, IsKeyFilesPutTogether) {
  const std::string text = "# of Monday\n\n  \t\n" + key_line(key_of("a", 1)) + "# of Tuesday\r\n" +
                           "\tfarshade-key-1  b   02" + std::string(62, 'F') + " \r\n" +
                           key_line(key_of("c", 3)).substr(0, 81);  // without its end of line
  const auto keys = parse_keys(text, "ring");
  ASSERT_TRUE(keys) << keys.error().what;
  ASSERT_EQ(keys->size(), 3u);
  EXPECT_EQ((*keys)[0], key_of("a", 1));
  EXPECT_EQ((*keys)[1].name, "b");
  EXPECT_EQ((*keys)[1].secret[0], 2);
  EXPECT_EQ((*keys)[1].secret[31], 0xff);
  EXPECT_EQ((*keys)[2], key_of("c", 3));
}

TEST(KeyRing, GrowsByAppending) {
  const ScratchFolder folder;
  const fs::path path = folder.path() / "ring";
  for (std::uint8_t i = 0; i < 40; ++i)
    ASSERT_TRUE(append_to_ring(path, key_of("client-" + std::to_string(i), i)));
  const auto keys = load_key_ring(path).value();
  ASSERT_EQ(keys.size(), 40u);
  for (std::uint8_t i = 0; i < 40; ++i) EXPECT_EQ(keys[i], key_of("client-" + std::to_string(i), i));
}

TEST(KeyRing, KeepsItsEarlierLines) {
  const ScratchFolder folder;
  const fs::path path = folder.path() / "ring";
  write_0600(path, "# mine, no end of line");
  ASSERT_TRUE(append_to_ring(path, key_of("a", 1)));
  EXPECT_EQ(text_of(path), "# mine, no end of line\n" + key_line(key_of("a", 1)));
}

TEST(KeyRing, HasLimitsBehindTheSecret) {
  SharedKey key = key_of("a", 1);
  key.limits = {.until = std::chrono::sys_days(std::chrono::year(2027) / 1 / 31),
                .sessions = 2,
                .bytes_per_second = 1'000'000};
  const std::string line = key_line(key);
  EXPECT_EQ(line, key_line(key_of("a", 1)).substr(0, line.find(" until=")) +
                      " until=2027-01-31 sessions=2 bytes-per-second=1000000\n");
  EXPECT_EQ(parse_keys(line, "ring").value(), std::vector{key});
  const auto other_order = parse_keys(
      "farshade-key-1 a " + line.substr(17, 64) + " bytes-per-second=1000000\tsessions=2 until=2027-01-31",
      "ring");
  EXPECT_EQ(other_order.value(), std::vector{key});
}

TEST(KeyLimits, TheLastDayIsAValidOne) {
  SharedKey key = key_of("a", 1);
  const auto day = parse_day("2028-02-29").value();
  EXPECT_TRUE(is_valid_on(key, day));
  key.limits.until = day;
  EXPECT_TRUE(is_valid_on(key, day));
  EXPECT_FALSE(is_valid_on(key, day + std::chrono::days(1)));
}

TEST(KeyRing, LosesNoKeyOfThoseAddedAtTheSameTime) {
  const ScratchFolder folder;
  const fs::path path = folder.path() / "ring";
  constexpr std::uint8_t kEach = 25;
  std::vector<std::thread> writers;
  for (std::uint8_t writer = 0; writer < 4; ++writer)
    writers.emplace_back([&path, writer] {
      for (std::uint8_t i = 0; i < kEach; ++i) {
        const auto number = static_cast<std::uint8_t>(writer * kEach + i);
        EXPECT_TRUE(append_to_ring(path, key_of("client-" + std::to_string(number), number)));
      }
    });
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(load_key_ring(path).value().size(), std::size_t{4} * kEach);
}

TEST(KeyRing, BehindALinkStaysWhereItIs) {
  const ScratchFolder folder;
  const fs::path real = folder.path() / "elsewhere" / "ring", link = folder.path() / "ring";
  fs::create_directory(real.parent_path());
  ASSERT_TRUE(append_to_ring(real, key_of("a", 1)));
  fs::create_symlink(real, link);
  ASSERT_TRUE(append_to_ring(link, key_of("b", 2)));
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(load_key_ring(real).value().size(), 2u);
}

TEST(SharedKey, LeavesNoSecretBehind) {
  alignas(SharedKey) std::array<std::byte, sizeof(SharedKey)> room{};
  auto* const key = new (room.data()) SharedKey(key_of("a", 0xa5));
  const std::size_t at =
      static_cast<std::size_t>(reinterpret_cast<std::byte*>(key->secret.data()) - room.data());
  key->~SharedKey();
  for (std::size_t i = 0; i < 32; ++i) EXPECT_EQ(room.at(at + i), std::byte{0}) << i;
}

constexpr std::size_t kDigits_bytes = 2 * sizeof SharedKey::secret + 1;

TEST(KeyFile, LeavesNoDigitsOfItsSecretBehind) {
  if (!WatchedSodium::is_possible()) GTEST_SKIP() << "libsodium is a static library";
  const ScratchFolder folder;
  const SharedKey key = key_of("a", 1);
  const std::string line = key_line(key);
  const WatchedSodium watched;
  ASSERT_TRUE(write_key(folder.path() / "a.key", key));
  EXPECT_EQ(std::ranges::count(watched.wiped, kDigits_bytes), 1);
  EXPECT_EQ(std::ranges::count(watched.wiped, line.size()), 1);
}

TEST(KeyRing, LeavesNoTextBehindWhenItIsRead) {
  if (!WatchedSodium::is_possible()) GTEST_SKIP() << "libsodium is a static library";
  const ScratchFolder folder;
  const fs::path path = folder.path() / "ring";
  ASSERT_TRUE(append_to_ring(path, key_of("a", 1)));
  const WatchedSodium watched;
  ASSERT_TRUE(load_key_ring(path));
  EXPECT_EQ(std::ranges::count(watched.wiped, fs::file_size(path)), 2) << "its bytes and its text";
}

TEST(KeyRing, LeavesNoTextBehindWhenItGrows) {
  if (!WatchedSodium::is_possible()) GTEST_SKIP() << "libsodium is a static library";
  const ScratchFolder folder;
  const fs::path path = folder.path() / "ring";
  const SharedKey key = key_of("another", 2);
  const std::string line = key_line(key);
  ASSERT_TRUE(append_to_ring(path, key_of("a", 1)));
  const auto before = fs::file_size(path);
  const WatchedSodium watched;
  ASSERT_TRUE(append_to_ring(path, key));
  EXPECT_EQ(std::ranges::count(watched.wiped, before), 2) << "its bytes and its text";
  EXPECT_EQ(std::ranges::count(watched.wiped, line.size()), 1);
  EXPECT_EQ(std::ranges::count(watched.wiped, before + line.size()), 1);
}

TEST(KeyRing, RefusesADuplicateNameOrSecret) {
  const ScratchFolder folder;
  const fs::path path = folder.path() / "ring";
  ASSERT_TRUE(append_to_ring(path, key_of("a", 1)));
  const std::string before = text_of(path);
  EXPECT_EQ(append_to_ring(path, key_of("a", 2)).error().fault, Fault::Unavailable);
  EXPECT_EQ(append_to_ring(path, key_of("b", 1)).error().fault, Fault::Unavailable);
  EXPECT_EQ(text_of(path), before);
}

TEST(KeyRing, HoldsAsManyKeysAsStatedAndNoMore) {
  const ScratchFolder folder;
  std::string text;
  for (std::size_t i = 0; i < kMaxRingKeys; ++i) {
    SharedKey key = key_of("k" + std::to_string(i), 0);
    key.secret[1] = static_cast<std::uint8_t>(i);
    key.secret[2] = static_cast<std::uint8_t>(i >> 8);
    text += key_line(key);
  }
  EXPECT_EQ(parse_keys(text, "ring").value().size(), kMaxRingKeys);
  EXPECT_EQ(parse_keys(text + key_line(key_of("more", 1)), "ring").error().fault, Fault::OutOfRange);
  write_0600(folder.path() / "ring", text);
  EXPECT_EQ(append_to_ring(folder.path() / "ring", key_of("more", 1)).error().fault, Fault::OutOfRange);
  EXPECT_EQ(parse_keys(std::string(kMaxKeyFileBytes + 1, '\n'), "ring").error().fault, Fault::OutOfRange);
}

struct BadLine {
  const char* name;
  std::string line;
  const char* says;
  Fault fault = Fault::Malformed;
};
void PrintTo(const BadLine& bad, std::ostream* out) {
  *out << bad.name;
}
class KeyRingRefusal : public testing::TestWithParam<BadLine> {};

const std::string kDigits(64, '7');

TEST_P(KeyRingRefusal, NamesTheLineAndNoSecret) {
  const auto keys = parse_keys("# first\n" + key_line(key_of("a", 1)) + GetParam().line + "\n", "my.keys");
  ASSERT_FALSE(keys);
  EXPECT_EQ(keys.error().fault, GetParam().fault);
  EXPECT_TRUE(keys.error().what.starts_with("my.keys:3: ")) << keys.error().what;
  EXPECT_NE(keys.error().what.find(GetParam().says), std::string::npos) << keys.error().what;
  EXPECT_EQ(keys.error().what.find("77"), std::string::npos) << keys.error().what;
  EXPECT_EQ(keys.error().what.find("a5a5"), std::string::npos) << keys.error().what;
}

INSTANTIATE_TEST_SUITE_P(
    Lines, KeyRingRefusal,
    testing::Values(
        BadLine{"NoFormat", "b " + kDigits, "should be 'farshade-key-1 NAME SECRET'"},
        BadLine{"SecretAlone", kDigits, "should be 'farshade-key-1 NAME SECRET'"},
        BadLine{"OtherVersion", "farshade-key-2 b " + kDigits, "another version", Fault::Unsupported},
        BadLine{"NoName", "farshade-key-1", "a key's name"},
        BadLine{"NameTooLong", "farshade-key-1 " + std::string(65, 'b') + " " + kDigits, "a key's name"},
        BadLine{"NameWithSlash", "farshade-key-1 b/c " + kDigits, "a key's name"},
        BadLine{"NameWithControl", "farshade-key-1 b\x1b[2J " + kDigits, "a key's name"},
        BadLine{"NoSecret", "farshade-key-1 b", "64 hexadecimal digits"},
        BadLine{"SecretTooShort", "farshade-key-1 b " + kDigits.substr(1), "64 hexadecimal digits"},
        BadLine{"SecretTooLong", "farshade-key-1 b " + kDigits + "7", "64 hexadecimal digits"},
        BadLine{"SecretNoHex", "farshade-key-1 b " + kDigits.substr(1) + "g", "64 hexadecimal digits"},
        BadLine{"SecretWithNul", "farshade-key-1 b " + kDigits.substr(1) + std::string(1, '\0'),
                "64 hexadecimal digits"},
        BadLine{"MoreBehind", "farshade-key-1 b " + kDigits + " 1", "more behind the secret"},
        BadLine{"NoSuchDay", "farshade-key-1 b " + kDigits + " until=2027-02-29", "more behind the secret"},
        BadLine{"DayInWords", "farshade-key-1 b " + kDigits + " until=2027-1-31", "more behind the secret"},
        BadLine{"NoSessions", "farshade-key-1 b " + kDigits + " sessions=0", "more behind the secret"},
        BadLine{"NegativeSessions", "farshade-key-1 b " + kDigits + " sessions=-1", "more behind the secret"},
        BadLine{"SessionsInHex", "farshade-key-1 b " + kDigits + " sessions=1x", "more behind the secret"},
        BadLine{"TooSlow", "farshade-key-1 b " + kDigits + " bytes-per-second=24999",
                "more behind the secret"},
        BadLine{"Twice", "farshade-key-1 b " + kDigits + " sessions=1 sessions=2", "more behind the secret"},
        BadLine{"UnknownLimit", "farshade-key-1 b " + kDigits + " Sessions=1", "more behind the secret"},
        BadLine{"SecretOfZeros", "farshade-key-1 b " + std::string(64, '0'), "a secret of zeros is none"},
        BadLine{"NameTwice", "farshade-key-1 a " + kDigits, "the name 'a' is already in line 2"},
        BadLine{"SecretTwice", key_line(key_of("b", 1)), "the secret of 'b' is already in line 2"}),
    [](const auto& bad) { return bad.param.name; });

TEST(KeyId, FollowsFromTheSecretAlone) {
  EXPECT_EQ(id_of(key_of("a", 1)), id_of(key_of("b", 1)));
  EXPECT_NE(id_of(key_of("a", 1)), id_of(key_of("a", 2)));
  SharedKey key = key_of("a", 1);
  key.secret[31] ^= 0x80;
  EXPECT_NE(id_of(key), id_of(key_of("a", 1)));
}

TEST(KeyId, IsWhatBlake2bSays) {
  // python3: hashlib.blake2b(b"farshade key id 1", digest_size=32, key=bytes(range(32))).digest()[:8]
  SharedKey key{"a", {}};
  for (std::size_t i = 0; i < key.secret.size(); ++i) key.secret[i] = static_cast<std::uint8_t>(i);
  EXPECT_EQ(id_of(key), (KeyId{0xd8, 0xd8, 0xc6, 0xac, 0x12, 0xd1, 0xb2, 0x8b}));
}

TEST(NewKey, IsAnotherEachTime) {
  std::set<decltype(SharedKey::secret)> secrets;
  for (int i = 0; i < 100; ++i) secrets.insert(new_key("a").value().secret);
  EXPECT_EQ(secrets.size(), 100u);
}

TEST(NewKey, RefusesNamesThatAreNone) {
  for (const std::string& name :
       {std::string(), std::string("a b"), std::string("a\n"), std::string("ä"), std::string(65, 'a')})
    EXPECT_EQ(new_key(name).error().fault, Fault::OutOfRange) << name;
  EXPECT_TRUE(new_key(std::string(64, 'a')));
}

TEST(DefaultKeyPlaces, AreInTheConfigFolder) {
  const std::string home = std::getenv("HOME") != nullptr ? std::getenv("HOME") : "";
  ::setenv("HOME", "/home/someone", 1);
  ::setenv("XDG_CONFIG_HOME", "relative", 1);  // must be ignored
  EXPECT_EQ(default_key_path(), "/home/someone/.config/farshade/client.key");
  ::setenv("XDG_CONFIG_HOME", "/etc/xdg", 1);
  EXPECT_EQ(default_ring_path(), "/etc/xdg/farshade/ring.keys");
  ::unsetenv("XDG_CONFIG_HOME");
  EXPECT_EQ(default_ring_path(), "/home/someone/.config/farshade/ring.keys");
  ::setenv("HOME", home.c_str(), 1);
}

}  // namespace
}  // namespace farshade
