#include <gtest/gtest.h>

#include <random>

#include "stereo/base/files.h"
#include "tests/unit/client_record/capture_samples.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

using namespace record_samples;

constexpr Time kEarliest(-Duration(std::int64_t{1} << 61)), kLatest(Duration(std::int64_t{1} << 61));

/// Reads all frames up to the first error, and returns that error.
std::optional<Error> read_all(std::span<const std::byte> bytes, std::vector<CapturedFrame>& frames) {
  Expected<CaptureReader> reader = reader_of(bytes);
  if (!reader) return reader.error();
  for (;;) {
    Expected<std::optional<CapturedFrame>> next = reader->next();
    if (!next) return next.error();
    if (!*next) return std::nullopt;
    frames.push_back(std::move(**next));
  }
}

/// Reading a file and writing it again must give the same bytes.
void expect_round_trip(const CaptureHeader& header, const std::vector<CapturedFrame>& frames) {
  const Bytes file = file_of(header, frames);
  std::vector<CapturedFrame> read;
  const std::optional<Error> wrong = read_all(file, read);
  ASSERT_FALSE(wrong.has_value()) << wrong->what;
  ASSERT_EQ(read.size(), frames.size());
  EXPECT_EQ(file_of(reader_of(file)->header(), read), file);
}

TEST(CaptureFile, IsReadAsItWasWritten) {
  const CaptureHeader expected = header();
  const Bytes file = file_of(expected, std::vector{frame(1), frame(2)});
  const CaptureHeader got = reader_of(file)->header();
  EXPECT_EQ(got.scene, expected.scene);
  EXPECT_EQ(got.scene_hash, expected.scene_hash);
  EXPECT_EQ(got.lights, expected.lights);
  EXPECT_EQ(got.origin, expected.origin);
  EXPECT_EQ(got.limits.size, expected.limits.size);
  EXPECT_EQ(got.limits.traced_size, expected.limits.traced_size);
  EXPECT_EQ(got.limits.depth_frames, expected.limits.depth_frames);
  EXPECT_EQ(got.requests, expected.requests);
  EXPECT_EQ(got.refresh_hz, expected.refresh_hz);
  EXPECT_EQ(got.policy.pace, expected.policy.pace);
  EXPECT_EQ(got.policy.round_trip, expected.policy.round_trip);
  EXPECT_EQ(got.device, expected.device);
  std::vector<CapturedFrame> read;
  ASSERT_FALSE(read_all(file, read).has_value());
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[1].input.timing.display_time, frame(2).input.timing.display_time);
  EXPECT_EQ(read[1].input.timing.period, frame(2).input.timing.period);
  EXPECT_EQ(read[1].input.views, frame(2).input.views);
  ASSERT_EQ(read[1].before.size(), 2u);
  EXPECT_EQ(read[1].before[1].bytes, frame(2).before[1].bytes);
  ASSERT_TRUE(read[1].request.has_value());
  EXPECT_EQ(read[1].request->request.frame, FrameId{2});
  EXPECT_EQ(read[1].request->sent, frame(2).request->sent);
  ASSERT_EQ(read[1].after.size(), 1u);
  EXPECT_EQ(read[1].after[0].arrived, frame(2).after[0].arrived);
  EXPECT_EQ(read[1].pictures, frame(2).pictures);
}

TEST(CaptureFile, KeepsExtremes) {
  CaptureHeader big = header();
  big.scene = std::string(kMaxCaptureText_bytes, 's');
  big.device = "";
  big.lights = kMaxLights;
  big.limits = {{kMaxViewSide_px, 1}, {kMaxViewSide_px, 1}, 4096};
  big.requests = Assembler::kKept + 1;
  big.policy = {Pace::Virtual, kLatest - Time{}, kLatest - Time{}, kLatest - Time{}};
  CapturedFrame all = frame(1), none;
  all.before.clear();
  for (CapturedFrame* each : {&all, &none}) {
    each->input = input(1);
    each->input.timing.display_time = each == &all ? kEarliest : kLatest;
    for (View& view : each->input.views) view.stage_from_eye.translation = {1e9, -1e9, 0x1p-1074};
  }
  FrameSettings& settings = all.input.settings;
  settings.request = {PredictorKind::Hold, GuardBandUse::Off, 1024};
  settings.reprojection = {Lookup::Direct, Eyes::This, Gaps::Unknown, Edges::Nearest};
  settings.scene = SceneClock::Paused;
  none.input.settings.request = {PredictorKind::Kalman, GuardBandUse::Off, 1};
  settings.lights.revision = kFirstLightSet;
  for (std::uint32_t light = 0; light < kMaxLights; ++light)
    change(settings.lights, kMaxLights - 1 - light, light % 2 == 0,
           light % 3 == 0 ? std::nullopt : std::optional(LightPose{.position = {{1e9, 0, -1e9}}}));
  expect_round_trip(big, {all, none});
}

TEST(CaptureFile, KeepsAllFrameSettings) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    CapturedFrame one = frame(1);
    FrameSettings& settings = one.input.settings;
    settings.request = {kPredictorKinds[random() % std::size(kPredictorKinds)],
                        static_cast<GuardBandUse>(random() % 2),
                        1 + static_cast<std::uint32_t>(random() % 64),
                        static_cast<std::uint32_t>(random() % (kWidestBand_percent + 1))};
    settings.reprojection = {static_cast<Lookup>(random() % 2), static_cast<Eyes>(random() % 2),
                             static_cast<Gaps>(random() % 2), static_cast<Edges>(random() % 2)};
    settings.scene = static_cast<SceneClock>(random() % 2);
    std::vector<CapturedFrame> read;
    ASSERT_FALSE(read_all(file_of(header(), std::vector{one}), read).has_value());
    const FrameSettings& got = read.at(0).input.settings;
    EXPECT_EQ(got.request.predictor, settings.request.predictor);
    EXPECT_EQ(got.request.guard_band, settings.request.guard_band);
    EXPECT_EQ(got.request.every, settings.request.every);
    EXPECT_EQ(got.request.guard_band_percent, settings.request.guard_band_percent);
    EXPECT_EQ(got.reprojection, settings.reprojection);
    EXPECT_EQ(got.scene, settings.scene);
  }
}

TEST(CaptureFile, RefusesPredictorsThatWereRemoved) {
  CapturedFrame hold = frame(1), kalman = frame(1);
  hold.input.settings.request.predictor = PredictorKind::Hold;
  kalman.input.settings.request.predictor = PredictorKind::Kalman;
  Bytes file = file_of(header(), std::vector{hold});
  const Bytes other = file_of(header(), std::vector{kalman});
  const auto predictor = std::ranges::mismatch(file, other).in1;
  ASSERT_NE(predictor, file.end());
  for (const int removed : {1, 2, 4}) {
    *predictor = std::byte(removed);
    std::vector<CapturedFrame> read;
    const auto error = read_all(with_right_checksums(file), read);
    ASSERT_TRUE(error.has_value()) << removed;
    EXPECT_TRUE(read.empty());
  }
}

TEST(CaptureFile, CutsTextsAndReplacesControlCharacters) {
  CaptureHeader odd = header();
  odd.scene = "a\x1b[2Jb\n" + std::string(1000, 'c');
  odd.device = "Gr\xc3\xa4te";
  const CaptureHeader got = reader_of(file_of(odd, {}))->header();
  EXPECT_EQ(got.scene, "a?[2Jb?" + std::string(kMaxCaptureText_bytes - 7, 'c'));
  EXPECT_EQ(got.device, odd.device);
}

TEST(CaptureFile, MessagesOfAFrameWithoutRequestComeBefore) {
  CapturedFrame quiet = frame(1);
  quiet.request.reset();
  std::vector<CapturedFrame> read;
  ASSERT_FALSE(read_all(file_of(header(), std::vector{quiet}), read).has_value());
  EXPECT_EQ(read.at(0).before.size(), 3u);
  EXPECT_TRUE(read.at(0).after.empty());
}

/// What a reader says about a file, and how many frames it reads.
struct Examined {
  std::uint32_t frames = 0;
  std::string error, cut_off;
};

Examined examine(std::span<const std::byte> bytes) {
  Expected<CaptureReader> reader = reader_of(bytes);
  if (!reader) return {0, reader.error().what, ""};
  for (Examined found;; ++found.frames) {
    const Expected<std::optional<CapturedFrame>> next = reader->next();
    if (next && *next) continue;
    if (!next) found.error = next.error().what;
    found.cut_off = reader->cut_off().value_or("");
    return found;
  }
}

TEST(CaptureFileTruncated, AnywhereIsNoticedAndGivesTheWholeFramesBefore) {
  Bytes file;
  append(header(), file);
  const std::size_t header_end = file.size();
  append(frame(1), file);
  const std::size_t first_end = file.size();
  append(frame(2), file);
  const std::size_t second_end = file.size();
  append(CaptureEnd{2}, file);
  for (std::size_t size = 0; size < file.size(); ++size) {
    const Bytes cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size));
    const Examined found = examine(cut);
    EXPECT_EQ(!found.error.empty(), size < header_end) << size;
    EXPECT_EQ(!found.cut_off.empty(), size >= header_end) << size;
    EXPECT_EQ(found.frames, size < first_end ? 0u : size < second_end ? 1u : 2u) << size;
  }
  EXPECT_EQ(examine(std::span(file).first(first_end)).cut_off,
            "a.capture is cut off after 1 frames, at byte " + std::to_string(first_end) +
                ": it has no end record, so later frames may be missing");
  const Examined whole = examine(file);
  EXPECT_EQ(whole.error + whole.cut_off, "");
  EXPECT_EQ(whole.frames, 2u);
}

TEST(CaptureFileFlipped, EverySingleBitIsNoticed) {
  const Bytes good = file_of(header(), std::vector{frame(1), frame(2)});
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes bad = good;
    bad[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    const Examined found = examine(bad);
    EXPECT_NE(found.error + found.cut_off, "") << "bit " << bit % 8 << " of byte " << bit / 8;
    EXPECT_TRUE((found.error + found.cut_off).starts_with("a.capture")) << found.error;
  }
}

/// Behind right checksums, too, the reader reads or refuses, and does nothing else.
TEST(CaptureFileFlipped, BytesBehindRightChecksumsAreRefusedOrRead) {
  const Bytes good = file_of(header(), std::vector{frame(1), frame(2)});
  std::size_t refused = 0;
  for (std::size_t at = 0; at < good.size(); ++at)
    for (const unsigned mask : {1u, 0x80u, 0xffu}) {
      Bytes bad = good;
      bad[at] ^= static_cast<std::byte>(mask);
      const Examined found = examine(with_right_checksums(bad));
      if (found.error.empty()) continue;
      ++refused;
      EXPECT_TRUE(found.error.starts_with("a.capture")) << found.error;
    }
  EXPECT_GT(refused, 100u);
}

TEST(CaptureFileFault, AnEndThatContradictsTheFileIsRefused) {
  Bytes file = file_of(header(), std::vector{frame(1), frame(2)});
  Bytes longer = file;
  longer.push_back({});
  EXPECT_NE(examine(longer).error.find("bytes after the end record"), std::string::npos);
  Bytes other;
  append(header(), other);
  append(frame(1), other);
  append(CaptureEnd{2}, other);
  EXPECT_NE(examine(other).error.find("the file has 1 frames instead of 2"), std::string::npos);
}

struct Wrong {
  const char* name;
  std::function<void(Bytes& file)> spoil;
  const char* what;
};

/// The byte at which the second record begins.
std::size_t first_frame_at() {
  Bytes file;
  append(header(), file);
  return file.size();
}

void set_u32(Bytes& file, std::size_t at, std::uint32_t value) {
  for (int i = 0; i < 4; ++i, value >>= 8) file[at++] = static_cast<std::byte>(value);
}

TEST(CaptureFileFault, IsNamedWithFileAndByte) {
  const std::size_t frame_at = first_frame_at();
  const std::string at = "a.capture: byte " + std::to_string(frame_at) + ": ";
  const std::vector<Wrong> all{
      {"magic", [](Bytes& f) { f[0] = {}; }, "a.capture is not a capture file"},
      {"version", [](Bytes& f) { f[4] = std::byte{9}; }, "a.capture is a capture file of version 9."},
      {"no header", [](Bytes& f) { f[8] = std::byte{2}; },
       "a.capture: byte 8: the first record is not a header"},
      {"kind", [=](Bytes& f) { f[frame_at] = std::byte{77}; }, "unknown kind of record"},
      {"length", [=](Bytes& f) { set_u32(f, frame_at + 1, kMaxRecord_bytes + 1); },
       "a record of 16385 bytes"},
      {"short", [=](Bytes& f) { set_u32(f, frame_at + 1, 3); }, "frame: truncated"},
      {"order", [=](Bytes& f) { f[frame_at] = std::byte{5}; }, "pictures outside of a frame"},
      {"time", [=](Bytes& f) { f[frame_at + kRecordHead_bytes + 7] = std::byte{0x7f}; }, "frame: time range"},
      {"period",
       [=](Bytes& f) {
         for (int i = 8; i < 16; ++i) f[frame_at + 5 + static_cast<unsigned>(i)] = {};
       },
       "frame: time range"},
      {"view",
       [=](Bytes& f) {
         for (unsigned i = 16; i < 24; ++i) f[frame_at + 5 + i] = std::byte{0xff};
       },
       "frame: view range"},
      {"code", [=](Bytes& f) { f[frame_at + 5 + 16 + 176] = std::byte{4}; }, "frame: code"},
  };
  for (const Wrong& wrong : all) {
    Bytes file = file_of(header(), std::vector{frame(1)});
    wrong.spoil(file);
    std::vector<CapturedFrame> read;
    const std::optional<Error> error = read_all(with_right_checksums(file), read);
    ASSERT_TRUE(error.has_value()) << wrong.name;
    const std::string expected =
        std::string(wrong.what).starts_with("a.capture") ? wrong.what : at + wrong.what;
    EXPECT_TRUE(error->what.starts_with(expected)) << wrong.name << ": " << error->what;
  }
}

/// No CaptureWriter writes frames in this order or with this header.
TEST(CaptureFileFault, RefusesContradictions) {
  const auto error_of = [](const CaptureHeader& head, const std::vector<CapturedFrame>& frames) {
    std::vector<CapturedFrame> read;
    return read_all(file_of(head, frames), read).value_or(Error{Fault::Missing, ""}).what;
  };
  EXPECT_NE(error_of(header(), {frame(2), frame(1)}).find("the display time runs backwards"),
            std::string::npos);
  CaptureHeader alone = header();
  alone.origin = MaskOrigin::OwnTracer;
  EXPECT_NE(error_of(alone, {frame(1)}).find("without a server"), std::string::npos);
  CaptureHeader narrow = header();
  narrow.limits.traced_size = narrow.limits.size;
  EXPECT_NE(error_of(narrow, {frame(1)}).find("guard band"), std::string::npos);
  CaptureHeader other = header();
  other.lights = 4;
  EXPECT_NE(error_of(other, {frame(1)}).find("another scene"), std::string::npos);
}

TEST(CaptureFileFault, RefusesAnotherMessageAsRequest) {
  std::vector<CapturedFrame> read;
  ASSERT_FALSE(
      read_all(file_with_request(RequestMessage{.request = sent_request(1).request}), read).has_value());
  EXPECT_TRUE(read.at(0).request.has_value());
  const std::optional<Error> error = read_all(file_with_request(wire_samples::plane_slice()), read);
  ASSERT_TRUE(error.has_value());
  EXPECT_TRUE(error->what.ends_with("request: type")) << error->what;
}

TEST(CaptureFileFault, RefusesHeadersOutOfRange) {
  // Byte offsets of the origin, the traced size, the frame counts, the limit of
  // detail, the exposure and the pace.
  const std::size_t origin = 8 + 5 + 1 + header().scene.size() + 32 + 2;
  for (const auto& [at, value] : {std::pair<std::size_t, unsigned>{origin, 3},
                                  {origin + 1, 0},
                                  {origin + 5, 1},
                                  {origin + 12, 1},
                                  {origin + 20, 0x7f},
                                  {origin + 20, 0xff},
                                  {origin + 21, 1},
                                  {origin + 34, 2},
                                  {origin + 35, 2}}) {
    Bytes file = file_of(header(), {});
    file[at] = static_cast<std::byte>(value);
    EXPECT_FALSE(reader_of(with_right_checksums(file)).has_value())
        << "byte " << at - origin << " after the origin";
  }
}

TEST(CaptureFileFault, RefusesTooFewRememberedRequests) {
  CaptureHeader fewest = header();
  fewest.requests = Assembler::kKept + 1;
  const Bytes good = file_of(fewest, {});
  EXPECT_TRUE(reader_of(good).has_value());
  Bytes bad = good;
  const std::size_t requests_at = 8 + 5 + 1 + fewest.scene.size() + 32 + 2 + 1 + 4 + 4 + 4 + 8;
  ASSERT_EQ(bad.at(requests_at), static_cast<std::byte>(fewest.requests));
  bad[requests_at] = static_cast<std::byte>(Assembler::kKept);
  EXPECT_FALSE(reader_of(with_right_checksums(bad)).has_value());
}

TEST(CaptureFileOpen, NamesTheFault) {
  const ScratchFolder folder;
  EXPECT_EQ(CaptureReader::open(folder.path() / "none").error().fault, Fault::Missing);
  EXPECT_EQ(CaptureReader::open(folder.path()).error().fault, Fault::Unreadable);
  ASSERT_TRUE(write_file_atomically(folder.path() / "text", "once upon a time").has_value());
  EXPECT_EQ(CaptureReader::open(folder.path() / "text").error().fault, Fault::Unsupported);
  ASSERT_TRUE(
      write_file_atomically(folder.path() / "good", file_of(header(), std::vector{frame(1), frame(2)}))
          .has_value());
  EXPECT_EQ(count_frames(folder.path() / "good").value(), 2u);
}

TEST(PictureHash, TellsPixelsAndShapesApart) {
  Image<Rgb8> picture({4, 2});
  const PictureHash black = hash_of(picture);
  EXPECT_NE(hash_of(Image<Rgb8>({2, 4})), black);
  picture.at(3, 1).z = 1;
  EXPECT_NE(hash_of(picture), black);
  picture.at(3, 1).z = 0;
  EXPECT_EQ(hash_of(picture), black);
}

}  // namespace
}  // namespace farshade
