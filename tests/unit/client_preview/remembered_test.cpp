#include "vr_client/preview/remembered.h"

#include <gtest/gtest.h>

#include "stereo/base/files.h"
#include "stereo/base/user_folders.h"
#include "tests/unit/scratch_folder.h"
#include "vr_client/preview/controls.h"

namespace farshade {
namespace {

constexpr Remembered kOther{
    .window = Extent{1280, 720}, .panel = false, .overlay = Overlay::GuardBand, .picture_share = 0.5};

TEST(Remembered, SurvivesItsText) {
  EXPECT_EQ(parse_remembered(text_of(kOther)).value(), kOther);
  EXPECT_EQ(parse_remembered(text_of({})).value(), Remembered{});
}

TEST(Remembered, KeepsDefaultsForWhatIsNotThereAndIgnoresWhatItDoesNotKnow) {
  const Remembered read = parse_remembered(R"({"panel": false, "from a later version": [1, {}]})").value();
  EXPECT_EQ(read, (Remembered{.window = std::nullopt, .panel = false}));
}

TEST(Remembered, RefusesWrongTypesAndRanges) {
  for (const char* text : {"",
                           "[]",
                           "3",
                           "null",
                           "{",
                           R"({"panel": 1})",
                           R"({"overlay": "nonsense"})",
                           R"({"overlay": 2})",
                           R"({"window": 5})",
                           R"({"window": [1280]})",
                           R"({"window": [1280, 720, 3]})",
                           R"({"window": [0, 720]})",
                           R"({"window": [1280, -720]})",
                           R"({"window": [1e30, 720]})",
                           R"({"window": [1280.5, 720]})",
                           R"({"window": [16385, 720]})",
                           R"({"window": {"0": 1, "1": 2}})",
                           R"({"picture_share": -0.1})",
                           R"({"picture_share": 0.8})",
                           R"({"picture_share": true})"}) {
    const auto read = parse_remembered(text);
    ASSERT_FALSE(read) << text;
    EXPECT_EQ(read.error().fault, Fault::Malformed) << text;
  }
}

TEST(Remembered, RefusesEveryTruncation) {
  const std::string text = text_of(kOther);
  for (std::size_t size = 0; size + 2 < text.size(); ++size) {
    const std::string cut = text.substr(0, size);
    EXPECT_FALSE(parse_remembered(cut)) << cut;
  }
}

TEST(RememberedFile, IsWrittenWithItsFolderAndReadBack) {
  const ScratchFolder scratch;
  const std::filesystem::path path = scratch.path() / "state" / "farshade" / "preview.json";
  EXPECT_EQ(load_remembered(path).value(), Remembered{}) << "no file";
  ASSERT_TRUE(save_remembered(path, kOther));
  EXPECT_EQ(load_remembered(path).value(), kOther);
}

TEST(RememberedFile, NamesItselfIfItIsBroken) {
  const ScratchFolder scratch;
  const std::filesystem::path path = scratch.path() / "preview.json";
  ASSERT_TRUE(write_file_atomically(path, std::string_view("not JSON")));
  const auto read = load_remembered(path);
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().what.find(path.string()), std::string::npos) << read.error().what;
  ASSERT_TRUE(write_file_atomically(path, std::string(1 << 17, ' ')));
  EXPECT_FALSE(load_remembered(path)) << "too long";
}

TEST(RememberedFile, IsInTheStateFolder) {
  setenv("XDG_STATE_HOME", "/somewhere/state", 1);
  EXPECT_EQ(remembered_path(), "/somewhere/state/farshade/preview.json");
  setenv("XDG_STATE_HOME", "relative", 1);
  EXPECT_TRUE(remembered_path().string().ends_with("/.local/state/farshade/preview.json"));
  unsetenv("XDG_STATE_HOME");
  EXPECT_TRUE(remembered_path().string().ends_with("/.local/state/farshade/preview.json"));
}

TEST(Remembered, IsWhatTheControlsHave) {
  Controls controls;
  recall(kOther, controls);
  Remembered again = remembered_of(controls);
  again.window = kOther.window;
  EXPECT_EQ(again, kOther);
}

}  // namespace
}  // namespace farshade
