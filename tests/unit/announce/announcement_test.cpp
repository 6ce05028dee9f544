#include "stereo/announce/announcement.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "stereo/messages/messages.h"

namespace farshade {
namespace {

Peer v4(std::uint8_t last) {
  return {.address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 192, 0, 2, last}, .port = 7447};
}

Peer link_local(std::uint32_t interface) {
  Peer peer{.scope = interface, .port = 7447};
  peer.address[0] = 0xfe;
  peer.address[1] = 0x80;
  peer.address[15] = 1;
  return peer;
}

FoundServer server(std::string name, const Peer& address,
                   std::optional<std::uint16_t> protocol = kProtocolVersion) {
  return {std::move(name), address, protocol};
}

std::optional<std::uint16_t> protocol_of(const std::vector<std::string>& txt) {
  return announced_protocol(txt);
}

TEST(AnnouncementTxt, ReadsBackAndSaysNothingElse) {
  EXPECT_EQ(announced_protocol(announcement_txt()), kProtocolVersion);
  EXPECT_EQ(announcement_txt(), (std::vector<std::string>{"txtvers=1", "protocol=10",
                                                          "newest=" + std::to_string(kProtocolVersion)}));
}

TEST(AnnouncementTxt, TakesWhatTheStandardAllows) {
  EXPECT_EQ(protocol_of({"colour=red", "PROTOCOL=7", "protocol=8"}), 7) << "the first one counts";
  EXPECT_EQ(protocol_of({"protocol=65535"}), 65535);
  EXPECT_EQ(protocol_of({std::string(255, 'a'), "=", "", "protocol=6"}), 6);
}

TEST(AnnouncementTxt, AServerThatSpeaksSeveralVersionsIsOneOfOurs) {
  const std::string ours = std::to_string(kProtocolVersion);
  EXPECT_EQ(protocol_of({"protocol=10", "newest=" + ours}), kProtocolVersion);
  EXPECT_EQ(protocol_of({"protocol=" + ours, "newest=65000"}), kProtocolVersion)
      << "the next version's server";
  EXPECT_EQ(protocol_of({"protocol=9", "newest=10"}), 9);
  EXPECT_EQ(protocol_of({"protocol=10"}), 10);
}

TEST(AnnouncementTxt, RefusesEverythingElse) {
  using namespace std::string_literals;
  const std::vector<std::string> hostile{
      "protocol",      "protocol=",           "protocol=65536",
      "protocol=-1",   "protocol=6 ",         "protocol= 6",
      "protocol=6x",   "protocol=0x6",        "protocol=6\0"s,
      "protocol\0=6"s, "protocols=6",         "",
      "protocol=\xff", std::string(255, '9'), "protocol=" + std::string(246, '6')};
  for (const std::string& text : hostile) EXPECT_EQ(protocol_of({text}), std::nullopt) << text;
  EXPECT_EQ(protocol_of({"protocol=x", "protocol=6"}), std::nullopt) << "the first one counts";
  EXPECT_EQ(protocol_of({}), std::nullopt);
}

TEST(ServerSearch, IsAutoWithOrWithoutAName) {
  for (const char* search : {"auto", "auto/desk", "auto/my desk #2", "auto/"})
    EXPECT_TRUE(is_search(search)) << search;
  for (const char* address : {"", "aut", "auto:7447", "automat", "192.0.2.2", "[::1]:7447", "AUTO"})
    EXPECT_FALSE(is_search(address)) << address;
}

TEST(ServerChoice, TakesTheOnlyServer) {
  const auto one = choose_server("auto", {server("desk", v4(2))});
  ASSERT_TRUE(one) << one.error().what;
  EXPECT_EQ(address_text(one->address), "192.0.2.2:7447");
  EXPECT_EQ(in_words(*one), "'desk' at 192.0.2.2:7447");
}

TEST(ServerChoice, JoinsTheAddressesOfOneServer) {
  Peer global{.address = {0x20, 1, 0xd, 0xb8}, .port = 7447};
  std::vector<FoundServer> found{server("desk", link_local(3)), server("desk", global),
                                 server("desk", v4(2))};
  EXPECT_EQ(choose_server("auto", found).value().address, v4(2));
  found.pop_back();
  EXPECT_EQ(choose_server("auto", found).value().address, global);
  found.pop_back();
  EXPECT_EQ(address_text(choose_server("auto", found).value().address), "[fe80::1%3]:7447");
}

TEST(ServerChoice, SaysWhatToDoIfThereIsNone) {
  const auto none = choose_server("auto", {});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().fault, Fault::Missing);
  for (const char* cure : {"--listen 0.0.0.0", "avahi-daemon", "UDP 5353", "--server ADDRESS"})
    EXPECT_NE(none.error().what.find(cure), std::string::npos) << none.error().what;
}

TEST(ServerChoice, ListsSeveralAndTakesOneByItsName) {
  const std::vector<FoundServer> found{server("lab", v4(3)), server("desk", v4(2))};
  const auto several = choose_server("auto", found);
  ASSERT_FALSE(several);
  EXPECT_EQ(several.error().fault, Fault::Unavailable);
  EXPECT_NE(several.error().what.find("'desk' at 192.0.2.2:7447, 'lab' at 192.0.2.3:7447"), std::string::npos)
      << several.error().what;
  EXPECT_NE(several.error().what.find("--server auto/NAME"), std::string::npos);
  EXPECT_EQ(choose_server("auto/lab", found).value().address, v4(3));
  const auto unknown = choose_server("auto/attic", found);
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().fault, Fault::Missing);
  EXPECT_NE(unknown.error().what.find("'desk' at"), std::string::npos) << unknown.error().what;
}

TEST(ServerChoice, SkipsServersOfAnotherProtocolAndSaysSoIfThereIsNoOther) {
  const FoundServer old = server("old", v4(9), std::uint16_t{1}), mute = server("mute", v4(8), std::nullopt);
  EXPECT_EQ(choose_server("auto", {old, server("desk", v4(2)), mute}).value().name, "desk");
  for (const char* search : {"auto", "auto/old"}) {
    const auto none = choose_server(search, {old});
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().fault, Fault::Mismatch);
    EXPECT_NE(none.error().what.find("'old' at 192.0.2.9:7447"), std::string::npos) << none.error().what;
  }
}

TEST(ServerChoice, PrintsHostileNamesReadablyAndShortly) {
  using namespace std::string_literals;
  const std::vector<std::string> hostile{"\x1b[2J\x1b]0;owned\x07",
                                         "two\nlines\r",
                                         "nul\0byte"s,
                                         std::string(4000, 'a'),
                                         "B\xc3\xbcro",
                                         "\xff\xfe",
                                         ""};
  std::vector<FoundServer> found;
  for (std::size_t i = 0; i < hostile.size(); ++i)
    found.push_back(server(hostile[i], v4(static_cast<std::uint8_t>(i))));
  for (const char* search : {"auto", "auto/x\x1b[2J"}) {
    const auto several = choose_server(search, found);
    ASSERT_FALSE(several);
    EXPECT_TRUE(std::ranges::all_of(several.error().what, [](char c) { return c >= ' ' && c <= '~'; }))
        << several.error().what;
    EXPECT_LT(several.error().what.size(), 900u);
  }
  EXPECT_EQ(choose_server("auto/B\xc3\xbcro", found).value().name, "B\xc3\xbcro");
  EXPECT_EQ(choose_server("auto/B??ro", found).value().name, "B\xc3\xbcro") << "as it was printed";
}

TEST(ServerChoice, ListsAFewOfVeryMany) {
  std::vector<FoundServer> found;
  for (int i = 0; i < 200; ++i)
    found.push_back(server("s" + std::to_string(i), v4(static_cast<std::uint8_t>(i))));
  const auto several = choose_server("auto", found);
  ASSERT_FALSE(several);
  EXPECT_NE(several.error().what.find("200 servers announce themselves"), std::string::npos);
  EXPECT_NE(several.error().what.find("and 192 more"), std::string::npos) << several.error().what;
}

}  // namespace
}  // namespace farshade
