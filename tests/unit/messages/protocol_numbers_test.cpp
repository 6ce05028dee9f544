// The numbers that PROTOCOL.md shares with the code. This test reads its table of constants, every "value
// (`kName`)" in the text, the headings and the offset columns, and compares them with the code.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <optional>
#include <regex>
#include <sstream>
#include <string>

#include "stereo/codec/tile_blocks.h"
#include "stereo/messages/frame_fields.h"
#include "stereo/messages/timing.h"
#include "stereo/sealing/handshake.h"
#include "stereo/sealing/replay_window.h"
#include "tests/unit/messages/samples.h"

namespace farshade {
namespace {

using namespace wire_samples;

/// The lines of the document outside of its code blocks.
std::vector<std::string> lines_of_text() {
  std::ifstream page(FARSHADE_SOURCE "/stereo/messages/PROTOCOL.md");
  EXPECT_TRUE(page) << "PROTOCOL.md is missing";
  std::vector<std::string> lines;
  bool in_block = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("```"))
      in_block = !in_block;
    else if (!in_block)
      lines.push_back(line);
  }
  return lines;
}

/// The same as one line, because a sentence may be broken anywhere.
std::string text() {
  std::string all;
  for (const std::string& line : lines_of_text()) all += line + " ";
  return all;
}

/// 16384 in the document's notation: "16,384".
std::string count(std::uint64_t value) {
  std::string digits = std::to_string(value);
  for (std::size_t end = digits.size(); end > 3; end -= 3) digits.insert(end - 3, ",");
  return digits;
}

std::string bytes(std::uint64_t value) {
  return count(value) + " bytes";
}

std::string time(Duration value) {
  const std::int64_t us = value / std::chrono::microseconds(1);
  if (us % 1'000'000 == 0) return count(static_cast<std::uint64_t>(us / 1'000'000)) + " s";
  if (us % 1'000 == 0) return count(static_cast<std::uint64_t>(us / 1'000)) + " ms";
  return count(static_cast<std::uint64_t>(us)) + " us";
}

std::string power_of_two(std::int64_t value) {
  const int exponent = std::ilogb(static_cast<double>(value));
  EXPECT_EQ(value, std::int64_t{1} << exponent);
  return "2^" + std::to_string(exponent);
}

std::string power_of_ten(double value) {
  const long exponent = std::lround(std::log10(value));
  EXPECT_DOUBLE_EQ(value, std::pow(10.0, static_cast<double>(exponent)));
  return "1e" + std::to_string(exponent);
}

std::map<std::string, std::string> constants_of_code() {
  return {
      {"kProtocolVersion", count(kProtocolVersion)},
      {"kProtocolNumber", count(kProtocolNumber)},
      {"kLayoutHash", count(kLayoutHash)},
      {"kPreviousVersion", count(kPreviousVersion)},
      {"kBaseDatagram_bytes", bytes(kBaseDatagram_bytes)},
      {"kMaxDatagram_bytes", bytes(kMaxDatagram_bytes)},
      {"kSealing_bytes", bytes(kSealing_bytes)},
      {"kSealedHeader_bytes", bytes(kSealedHeader_bytes)},
      {"kAcceptHeader_bytes", bytes(kAcceptHeader_bytes)},
      {"kHelloLasting_bytes", bytes(kHelloLasting_bytes)},
      {"kHelloProved_bytes", bytes(kHelloProved_bytes)},
      {"kTag_bytes", bytes(kTag_bytes)},
      {"kBaseMessage_bytes", bytes(kBaseMessage_bytes)},
      {"kMaxMessage_bytes", bytes(kMaxMessage_bytes)},
      {"kHelloInterval", time(kHelloInterval)},
      {"kServerSilence", time(kServerSilence)},
      {"kServerSilenceAfterNoSession", time(kServerSilenceAfterNoSession)},
      {"kLeastUnanswered", count(kLeastUnanswered)},
      {"kKeepaliveInterval", time(kKeepaliveInterval)},
      {"kCookiePeriod", time(kCookiePeriod)},
      {"kUnconfirmedTimeout", time(kUnconfirmedTimeout)},
      {"kSessionTimeout", time(kSessionTimeout)},
      {"kPartsTimeout", time(kPartsTimeout)},
      {"ReplayWindow::kSize", count(ReplayWindow::kSize)},
      {"ReplayWindow::kMostJump", count(ReplayWindow::kMostJump)},
      {"kEpoch_datagrams", count(kEpoch_datagrams)},
      {"kEpochTime", time(kEpochTime)},
      {"kMostEpochStep", count(kMostEpochStep)},
      {"kEpochGrace", count(kEpochGrace)},
      {"kGoodbyes", count(kGoodbyes)},
      {"kBetweenGoodbyes", time(kBetweenGoodbyes)},
      {"kMaxTime_ns", power_of_two(kMaxTime_ns)},
      {"kMaxCoordinate_m", power_of_ten(kMaxCoordinate_m)},
      {"kMaxOffUnit", power_of_ten(kMaxOffUnit)},
      {"kMaxViewSide_px", count(kMaxViewSide_px)},
      {"kTileSide_px", count(kTileSide_px)},
      {"kMaxLights", count(kMaxLights)},
      {"kFirstLightSet", count(kFirstLightSet.value)},
      {"RequestMessage::kMostLightChanges", count(RequestMessage::kMostLightChanges)},
      {"ArrivalReport::kMost", count(ArrivalReport::kMost)},
      {"ArrivalReport::kTick", time(ArrivalReport::kTick)},
      {"kLeastVideo_bits", count(kLeastVideo_bits)},
      {"kMostVideo_bits", count(kMostVideo_bits)},
      {"kMostPictureInterval", time(kMostPictureInterval)},
      {"kLeastPosition_bits", count(kLeastPosition_bits)},
      {"kMostPosition_bits", count(kMostPosition_bits)},
      {"kSliceHeader_bytes", bytes(kSliceHeader_bytes)},
      {"kAskSliceHeader_bytes", bytes(kAskSliceHeader_bytes)},
      {"kPlaneSliceHeader_bytes", bytes(kPlaneSliceHeader_bytes)},
      {"kMaxOpened_bytes", bytes(kMaxOpened_bytes)},
      {"kMaxPlaneWord_bytes", count(kMaxPlaneWord_bytes)},
      {"kVideoPartHeader_bytes", bytes(kVideoPartHeader_bytes)},
      {"kVideoPart_bytes", bytes(kVideoPart_bytes)},
      {"kMostVideoParts", count(kMostVideoParts)},
      {"ViewScale::kFull_eighths", count(ViewScale::kFull_eighths)},
  };
}

TEST(ProtocolNumbers, TableOfConstantsIsTheCodes) {
  const std::regex row(R"(^\| `([\w:]+)` \| ([^|]+) \|.*)");
  std::map<std::string, std::string> of_page;
  for (const std::string& line : lines_of_text())
    if (std::smatch parts; std::regex_match(line, parts, row)) of_page[parts[1]] = parts[2];
  const std::map<std::string, std::string> of_code = constants_of_code();
  for (const auto& [name, value] : of_code) EXPECT_EQ(of_page[name], value) << name;
  for (const auto& [name, value] : of_page) EXPECT_TRUE(of_code.contains(name)) << name << " is not compared";
}

TEST(ProtocolNumbers, ValueBesideANameIsThatConstants) {
  const std::string page = text();
  const std::map<std::string, std::string> of_code = constants_of_code();
  const std::regex mention(R"(([^ ]+) ?(ms|us|s|bytes)? \(`([\w:]+)`\))");
  std::size_t mentions = 0;
  for (std::sregex_iterator at(page.begin(), page.end(), mention), end; at != end; ++at) {
    const std::string name = (*at)[3], unit = (*at)[2];
    if (!of_code.contains(name)) continue;
    // A number has no unit of its own if the column or the noun after it has the unit.
    const std::string& value = of_code.at(name);
    const std::string number = value.substr(0, value.find(' '));
    EXPECT_EQ((*at)[1], number) << name;
    EXPECT_TRUE(unit.empty() || number + " " + unit == value) << at->str();
    ++mentions;
  }
  EXPECT_GT(mentions, 40u);
}

TEST(ProtocolNumbers, EveryTimeHasTheNameOfItsConstant) {
  std::string page;
  for (const std::string& line : lines_of_text())
    if (!line.starts_with("| `")) page += line + " ";
  const std::regex time(R"([0-9][0-9,.]* (ms|us|s)\b)");
  for (std::sregex_iterator at(page.begin(), page.end(), time), end; at != end; ++at)
    EXPECT_EQ(page.substr(static_cast<std::size_t>(at->position() + at->length()), 3), " (`")
        << "the document says " << at->str() << " without the name of its constant";
}

struct Size {
  std::size_t type = 0, least = 0, most = 0;
  friend bool operator==(const Size&, const Size&) = default;
};
std::ostream& operator<<(std::ostream& out, const Size& size) {
  return out << "type " << size.type << ", " << size.least << " to " << size.most << " bytes";
}

Size size_of_envelope(const Bytes& datagram) {
  return {std::to_integer<std::size_t>(datagram.at(6)), datagram.size(), datagram.size()};
}
Size size_of_message(const Bytes& message) {
  return {std::to_integer<std::size_t>(message.at(0)), message.size(), message.size()};
}
/// Messages that end with any number of bytes.
Size open_size(const Bytes& message, std::size_t header, std::size_t most = kMaxMessage_bytes) {
  return {std::to_integer<std::size_t>(message.at(0)), header + 1, most};
}

RequestMessage shortest_request() {
  RequestMessage message = request();
  message.request.lights.lights.clear();
  message.arrivals = {};
  return message;
}
Size size_of_request() {
  RequestMessage longest = request();
  longest.request.lights = {};
  for (std::uint32_t i = 0; i < RequestMessage::kMostLightChanges; ++i)
    change(longest.request.lights, i, true, LightPose{});
  longest.arrivals.count = ArrivalReport::kMost;
  Size size = size_of_message(encoded(ClientMessage(shortest_request())));
  size.most = encoded(ClientMessage(longest)).size();
  return size;
}

std::map<std::string, Size> sizes_of_code() {
  const Sealed sealed_alone;  // without message and tag
  return {{"Hello", size_of_envelope(enveloped(hello()))},
          {"Retry", size_of_envelope(enveloped(retry()))},
          {"OpenRefusal", size_of_envelope(enveloped(open_refusal()))},
          {"Accept", size_of_envelope(enveloped(accept_sample({})))},
          {"NoSession", size_of_envelope(enveloped(no_session()))},
          {"Sealed", size_of_envelope(enveloped(sealed_alone))},
          {"Request", size_of_request()},
          {"AskSlice", open_size(ask_sample(), kAskSliceHeader_bytes, kBaseMessage_bytes)},
          {"Leave", size_of_message(encoded(ClientMessage(Leave{})))},
          {"Goodbye", size_of_message(encoded(ServerMessage(Goodbye{})))},
          {"Welcome", size_of_message(encoded(ServerMessage(welcome())))},
          {"Refusal", size_of_message(encoded(ServerMessage(refusal())))},
          {"Slice", open_size(packed(small_frame(), Side::Right).at(0), kSliceHeader_bytes)},
          {"FrameReport", size_of_message(encoded(ServerMessage(report())))},
          {"Probe", size_of_message(encoded(ServerMessage(probe())))},
          {"PlaneSlice", open_size(encoded(ServerMessage(plane_slice())), kPlaneSliceHeader_bytes)},
          {"VideoPart",
           open_size(encoded(ServerMessage(video_part())), kVideoPartHeader_bytes, kBaseMessage_bytes)},
          {"PathProbe", open_size(encoded(ServerMessage(path_probe())), 1)}};
}

std::size_t number_in(std::string digits) {
  std::erase(digits, ',');
  return std::stoul(digits);
}

TEST(ProtocolNumbers, HeadingsHaveTypeAndSize) {
  const std::regex heading(R"(^### (\w+) \((\d+)\), ([\d,]+)(?: to ([\d,]+))? bytes?.*)");
  std::map<std::string, Size> of_page;
  for (const std::string& line : lines_of_text())
    if (std::smatch parts; std::regex_match(line, parts, heading)) {
      const std::size_t least = number_in(parts[3]);
      of_page[parts[1]] = {number_in(parts[2]), least, parts[4].matched ? number_in(parts[4]) : least};
    }
  EXPECT_EQ(of_page, sizes_of_code());
}

TEST(ProtocolNumbers, ProbeIsShorterThanTheShortestRequest) {
  const std::size_t probes = encoded(ServerMessage(probe())).size() + kSealing_bytes;
  const std::size_t requests = encoded(ClientMessage(shortest_request())).size() + kSealing_bytes;
  EXPECT_NE(text().find("(" + bytes(probes) + ") is shorter than the captured Request (" + bytes(requests) +
                        " or more)"),
            std::string::npos)
      << probes << " and " << requests;
}

TEST(ProtocolNumbers, OffsetsOfEveryTableAddUp) {
  const std::regex row(R"(^\| (\d+) \| ([\d,]+)(?: x (\d+))? \|.*)");
  std::optional<std::size_t> expected;
  std::size_t checked = 0;
  for (const std::string& line : lines_of_text()) {
    std::smatch parts;
    if (std::smatch offset; expected && std::regex_search(line, offset, std::regex(R"(^\| (\d+) \|)"))) {
      EXPECT_EQ(number_in(offset[1]), *expected) << line;
      ++checked;
    }
    expected.reset();
    if (std::regex_match(line, parts, row))
      expected = number_in(parts[1]) + number_in(parts[2]) * (parts[3].matched ? number_in(parts[3]) : 1);
  }
  EXPECT_GT(checked, 40u);
}

TEST(ProtocolNumbers, FovIsRefusedBeyondThePagesAngle) {
  const std::string page = text();
  std::smatch parts;
  ASSERT_TRUE(std::regex_search(page, parts, std::regex(R"(each within ([\d.]+) degrees)")));
  const double angle = std::stod(parts[1]) * std::numbers::pi / 180;
  View view = request().request.views[0];
  view.fov = {-angle, angle, angle, -angle};
  EXPECT_TRUE(is_valid(view));
  view.fov.right_rad = angle + 1e-3;
  EXPECT_FALSE(is_valid(view));
}

}  // namespace
}  // namespace farshade
