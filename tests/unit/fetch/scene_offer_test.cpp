#include "stereo/fetch/scene_offer.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "stereo/messages/fetch_messages.h"
#include "stereo/options/parse_light.h"

namespace farshade {
namespace {

OfferedFile offered(const std::string& name, std::uint64_t bytes = 7) {
  return {name, bytes, digest_of(std::as_bytes(std::span(name)))};
}

SceneOffer sample_offer() {
  SceneOffer offer;
  offer.lighting.lights = {parse_light("spot,at=0:3:0,to=0:0:0,cone=30,candela=100,range=8").value(),
                           parse_sun("145,50,3").value()};
  offer.lighting.ambient = 0.05f;
  offer.lighting.choice = {.scene = 2, .camera = "left", .variant = "blue", .animation = "walk"};
  offer.files = {offered("a.gltf"), offered("textures/wood.png", 1 << 20), offered("b.bin", 1)};
  return offer;
}

TEST(OfferedName, IsBelowEveryFolder) {
  for (const char* good : {"a.glb", "textures/a b.png", "a/b/c", "..a", "a..", "...", "\xc3\xa4.png"})
    EXPECT_TRUE(is_offered_name(good)) << good;
  using namespace std::string_literals;
  for (const std::string& bad :
       {""s, "/"s, "/etc/passwd"s, "."s, ".."s, "../a"s, "a/../b"s, "a/.."s, "a//b"s, "a/"s, "./a"s, "a\0b"s,
        "a\nb"s, std::string(256, 'a'), std::string(1025, 'a'), "a/b/c/d/e/f/g/h/i/j/k/l/m/n/o/p/q"s})
    EXPECT_FALSE(is_offered_name(bad)) << bad;
}

TEST(SceneOffer, ReadsWhatWasWritten) {
  const SceneOffer offer = sample_offer();
  const Expected<SceneOffer> read = decode_offer(encode(offer));
  ASSERT_TRUE(read.has_value()) << read.error().what;
  EXPECT_EQ(read->files, offer.files);
  ASSERT_EQ(read->lighting.lights.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const AddedLight &a = offer.lighting.lights[i], &b = read->lighting.lights[i];
    EXPECT_EQ(a.source.kind, b.source.kind);
    EXPECT_EQ(a.source.intensity, b.source.intensity);
    EXPECT_EQ(a.source.range_m, b.source.range_m);
    EXPECT_EQ(a.source.inner_cone_rad, b.source.inner_cone_rad);
    EXPECT_EQ(a.source.outer_cone_rad, b.source.outer_cone_rad);
    EXPECT_EQ(a.position.v, b.position.v);
    EXPECT_EQ(a.direction.v, b.direction.v);
  }
  EXPECT_EQ(read->lighting.ambient, offer.lighting.ambient);
  EXPECT_EQ(read->lighting.choice.scene, 2u);
  EXPECT_EQ(read->lighting.choice.camera, "left");
  EXPECT_EQ(read->lighting.choice.variant, "blue");
  EXPECT_EQ(read->lighting.choice.animation, "walk");
  EXPECT_EQ(read->lighting.exposure, std::nullopt);
}

/// Programs before this choice read a flag of 0 or 1, and nothing between the variant and the lights.
TEST(SceneOffer, HasNothingOfAnAnimationThatIsNotChosen) {
  SceneOffer offer = sample_offer();
  const std::vector<std::byte> with = encode(offer);
  offer.lighting.choice.animation = "";
  const std::vector<std::byte> without = encode(offer);
  EXPECT_EQ(with.at(0), std::byte{3});
  EXPECT_EQ(without.at(0), std::byte{1});
  EXPECT_EQ(with.size() - without.size(), 2 + std::string_view("walk").size());
}

TEST(SceneOffer, RefusesEveryTruncationAndAppendix) {
  std::vector<std::byte> bytes = encode(sample_offer());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(decode_offer(std::vector(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size))))
        << size;
  bytes.push_back(std::byte{0});
  EXPECT_FALSE(decode_offer(bytes));
}

TEST(SceneOffer, RefusesBadFiles) {
  const auto fault = [](std::vector<OfferedFile> files) { return check_offered(files).error().what; };
  EXPECT_NE(fault({}).find("0 files"), std::string::npos);
  EXPECT_NE(fault(std::vector(kMostSceneFiles + 1, offered("a"))).find("4097 files"), std::string::npos);
  EXPECT_NE(fault({offered("a"), offered("a")}).find("twice"), std::string::npos);
  EXPECT_NE(fault({offered("a", 0)}).find("empty"), std::string::npos);
  EXPECT_NE(fault({offered("a"), offered("../b")}).find("leads out"), std::string::npos);
  EXPECT_TRUE(check_offered({offered("a", kMostScene_bytes)}));
  EXPECT_NE(fault({offered("a", kMostScene_bytes), offered("b", 1)}).find("--scene"), std::string::npos);
  EXPECT_NE(fault({offered("a", UINT64_MAX), offered("b", 2)}).find("--scene"), std::string::npos)
      << "no overflow";
}

/// A server that has been changed, or is hostile: names and lights that encode() never writes.
TEST(SceneOffer, RefusesBadNamesAndLightsFromTheWire) {
  SceneOffer offer = sample_offer();
  std::vector<std::byte> bytes = encode(offer);
  const std::string name = "textures/wood.png", evil = "../..////wood.png";
  const auto searched = std::as_bytes(std::span(name));
  const auto at = std::search(bytes.begin(), bytes.end(), searched.begin(), searched.end());
  std::ranges::copy(std::as_bytes(std::span(evil)), at);
  EXPECT_FALSE(decode_offer(bytes));

  const auto refused = [&](auto change) {
    SceneOffer changed = offer;
    change(changed.lighting);
    return !decode_offer(encode(changed));
  };
  EXPECT_FALSE(refused([](Lighting&) {}));
  EXPECT_TRUE(refused([](Lighting& l) { l.lights[0].source.intensity.x = NAN; }));
  EXPECT_TRUE(refused([](Lighting& l) { l.lights[0].source.intensity.x = -1; }));
  EXPECT_TRUE(refused([](Lighting& l) { l.lights[0].position.v.y = INFINITY; }));
  EXPECT_TRUE(refused([](Lighting& l) { l.lights[0].direction.v *= 2; }));
  EXPECT_TRUE(refused([](Lighting& l) { l.lights[0].source.outer_cone_rad = 3; }));
  EXPECT_TRUE(refused([](Lighting& l) { l.lights[0].source.kind = static_cast<LightKind>(3); }));
  EXPECT_TRUE(refused([](Lighting& l) { l.exposure = 0; }));
  EXPECT_TRUE(refused([](Lighting& l) { l.ambient = -1; }));
}

TEST(SceneOffer, FilesAreIdentifiedWithoutTheLighting) {
  SceneOffer offer = sample_offer();
  const Digest key = digest_of(offer.files);
  offer.files[1].hash[31] ^= 1;
  EXPECT_NE(digest_of(offer.files), key);
}

TEST(FetchMessages, ReadWhatWasWrittenAndRefuseTheRest) {
  std::vector<std::byte> bytes;
  encode(FetchRequest(ContentRequest{3, 9}), bytes);
  const auto request = decode_fetch_request(bytes);
  ASSERT_TRUE(request.has_value());
  EXPECT_EQ(std::get<ContentRequest>(*request).end, 9u);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(decode_fetch_request(std::span(bytes).first(size)));
  bytes.push_back(std::byte{0});
  EXPECT_EQ(decode_fetch_request(bytes).error(), WireRefusal::TrailingBytes);
  EXPECT_EQ(decode_fetch_answer(bytes).error(), WireRefusal::Type) << "a request is no answer";
  bytes[1] = std::byte{9};  // an empty range
  bytes.pop_back();
  EXPECT_FALSE(decode_fetch_request(bytes));

  const std::array<std::byte, 3> content{};
  encode(FetchAnswer(Content{5, content}), bytes);
  EXPECT_EQ(std::get<Content>(*decode_fetch_answer(bytes)).bytes.size(), 3u);
  EXPECT_FALSE(decode_fetch_answer(std::span(bytes).first(kContentHeader_bytes))) << "no content";
  encode(FetchAnswer(OfferPart{OfferPart::More::Yes, content}), bytes);
  bytes[1] = std::byte{2};
  EXPECT_FALSE(decode_fetch_answer(bytes));
  encode(FetchAnswer(FetchRefusal::Changed), bytes);
  EXPECT_TRUE(decode_fetch_answer(bytes));
  bytes[1] = std::byte{4};
  EXPECT_FALSE(decode_fetch_answer(bytes));
}

}  // namespace
}  // namespace farshade
