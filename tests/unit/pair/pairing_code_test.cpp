#include "stereo/pair/pairing_code.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "stereo/pair/pairing_messages.h"
#include "vr_client/pair/pair.h"

namespace farshade {
namespace {

PairingCode counted() {
  PairingCode code{.address = "192.0.2.2"};
  for (std::size_t i = 0; i < kCodeLength; ++i) code.symbols[i] = static_cast<std::uint8_t>(31 - i);
  return code;
}

TEST(PairingCode, IsOneLineThatReadsBack) {
  EXPECT_EQ(to_string(counted()), "farshade://192.0.2.2/ZYXW-VTSR-QPNM-KJHG-FEDC");
  for (const std::string address : {"192.0.2.2", "192.0.2.2:99", "[2001:db8::1]:99", "a.host"}) {
    const PairingCode code = new_pairing_code(address);
    EXPECT_EQ(parse_pairing_code(to_string(code)).value(), code);
  }
}

TEST(PairingCode, TakesWhatPeopleWrite) {
  PairingCode code = counted();
  code.symbols[0] = 1;
  code.symbols[1] = 1;
  code.symbols[2] = 0;
  for (const char* text : {"192.0.2.2/1l0w-vtsr-qpnm-kjhg-fedc", "192.0.2.2/ILOWVTSRQPNMKJHGFEDC"})
    EXPECT_EQ(parse_pairing_code(text).value(), code) << text;
}

TEST(PairingCode, RefusesEverythingElseAndDoesNotRepeatIt) {
  for (const char* text : {"", "/", "192.0.2.2", "192.0.2.2/", "/ZYXWVTSRQPNMKJHGFEDC",
                           "ZYXW-VTSR-QPNM-KJHG-FEDC", "192.0.2.2/ZYXW-VTSR-QPNM-KJHG-FED",
                           "192.0.2.2/ZYXW-VTSR-QPNM-KJHG-FEDCB", "192.0.2.2/ZYXW-VTSR-QPNM-KJHG-FEDU",
                           "192.0.2.2/ZYXW VTSR QPNM KJHG FEDC", "192.0.2.2/ZYXW-VTSR-QPNM-KJHG-FED/"}) {
    const auto code = parse_pairing_code(text);
    ASSERT_FALSE(code) << text;
    EXPECT_EQ(code.error().fault, Fault::Malformed);
    EXPECT_EQ(code.error().what.find("ZYXW"), std::string::npos) << code.error().what;
  }
}

TEST(PairingCode, HasRandomSymbolsThatAllOccurAndAllCountForTheKey) {
  std::set<std::uint8_t> seen;
  std::set<KeyId> ids;
  for (int i = 0; i < 100; ++i) {
    const PairingCode code = new_pairing_code("a");
    seen.insert(code.symbols.begin(), code.symbols.end());
    ids.insert(id_of(one_time_key(code)));
  }
  EXPECT_EQ(seen.size(), 32u);
  EXPECT_EQ(*seen.rbegin(), 31);
  EXPECT_EQ(ids.size(), 100u);
  for (std::size_t i = 0; i < kCodeLength; ++i) {
    PairingCode other = counted();
    other.symbols[i] ^= 1;
    EXPECT_NE(one_time_key(other).secret, one_time_key(counted()).secret) << i;
  }
}

TEST(PairingMessages, ReadBackAndRefuseEveryTruncation) {
  const SharedKey key = new_key("desk").value();
  const std::vector<std::byte> request = encode_pairing_request(key);
  EXPECT_EQ(decode_pairing_request(request).value(), key);
  for (std::size_t size = 0; size < 34; ++size) {  // the name is at least one byte long
    const std::vector<std::byte> cut(request.begin(), request.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(decode_pairing_request(cut)) << size;
  }
  for (const PairingAnswer answer : {PairingAnswer::Added, PairingAnswer::Taken, PairingAnswer::NotWritten})
    EXPECT_EQ(decode_pairing_answer(encode(answer)).value(), answer);
  EXPECT_FALSE(decode_pairing_answer(encode(static_cast<PairingAnswer>(0))));
  EXPECT_FALSE(decode_pairing_answer(encode(static_cast<PairingAnswer>(4))));
  EXPECT_FALSE(decode_pairing_answer(request));
  EXPECT_FALSE(decode_pairing_answer({}));
}

TEST(PairingMessages, RefuseANameThatWouldBreakTheRing) {
  for (const std::string& name :
       std::vector<std::string>{"", "two words", "line\nbreak", std::string(65, 'a')})
    EXPECT_FALSE(decode_pairing_request(encode_pairing_request({name, {1}}))) << name;
  EXPECT_FALSE(decode_pairing_request(encode_pairing_request({"zeros", {}})));
}

TEST(KeyNameOf, TurnsAMachinesNameIntoAKeysName) {
  EXPECT_EQ(key_name_of("desk-2.home"), "desk-2.home");
  EXPECT_EQ(key_name_of("my desk"), "my-desk");
  EXPECT_EQ(key_name_of(""), "client");
  EXPECT_EQ(key_name_of(std::string(100, 'a')).size(), kMaxKeyName);
}

}  // namespace
}  // namespace farshade
