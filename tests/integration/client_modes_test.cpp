// Runs every mode with the real programs over UDP. A command line works, or the program says why it does not.
#include <gtest/gtest.h>

#include "stereo/base/files.h"
#include "stereo/video/video.h"
#include "tests/integration/client_program.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

struct Case {
  std::string mode;
  double least_dB;  ///< median of the left eye, answers 20 ms late, at 96 x 64: as seen, less 3 dB
};

std::string mode_name(const testing::TestParamInfo<Case>& info) {
  std::string text = info.param.mode;
  std::erase(text, '-');
  return text;
}

class ClientMode : public testing::TestWithParam<Case> {};

TEST_P(ClientMode, ShowsTheRoom) {
  const auto& [mode, least_dB] = GetParam();
  if ((mode == "remote" || mode == "delta") && !has_video()) GTEST_SKIP() << video_version();
  const ScratchFolder folder;
  RunningServer server;
  const Ended run = run_client({{"--server", server.address()},
                                {"--mode", mode},
                                {"--delay", "20"},
                                {"--validate", ""},
                                {"--out", folder.path().string()}});
  ASSERT_EQ(run.status, 0) << run.errors;
  EXPECT_GE(summary_row(folder.path(), "left eye", "PSNR")[0], least_dB);
  if (mode == "local" || mode == "full") return;
  const double answer = summary_row(folder.path(), "wire", "bytes of an answer")[0];
  const double down = summary_row(folder.path(), "wire", "bytes down a frame")[0];
  const double up = summary_row(folder.path(), "wire", "bytes up a frame")[0];
  EXPECT_GT(answer, 0);
  EXPECT_GT(down, answer) << "with seals and reports";
  if (mode == "client-positions")
    EXPECT_GT(up, down) << "positions are larger than masks";
  else
    EXPECT_GT(up, 0);
}

INSTANTIATE_TEST_SUITE_P(Modes, ClientMode,
                         testing::Values(Case{"hybrid", 20}, Case{"client-positions", 20},
                                         Case{"server-gbuffer", 15}, Case{"remote", 15}, Case{"delta", 15},
                                         Case{"local", 15}, Case{"full", 50}),
                         mode_name);

/// The code changes the bytes and nothing else.
TEST(ClientModes, BlocksOfMasksShowTheSamePicturesAsSlices) {
  RunningServer server;
  const ScratchFolder range, lz4;
  std::vector<std::vector<double>> rows;
  for (const auto& [code, folder] : {std::pair("range", &range), std::pair("lz4", &lz4)}) {
    // Without reprojection there is no cube mask, which blocks go without.
    const Ended run = run_client({{"--server", server.address()},
                                  {"--mask-code", code},
                                  {"--ask", "whole"},
                                  {"--reprojection", "off"},
                                  {"--delay", "20"},
                                  {"--out", folder->path().string()}});
    ASSERT_EQ(run.status, 0) << run.errors;
    rows.push_back(summary_row(folder->path(), "left eye", "PSNR"));
    rows.push_back(summary_row(folder->path(), "wire", "bytes of an answer"));
  }
  EXPECT_EQ(rows[0], rows[2]);
  EXPECT_LT(rows[1][0], rows[3][0]) << "LZ4 of bitmaps has more bytes";
  std::size_t pictures = 0;
  for (const auto& file : std::filesystem::directory_iterator(range.path()))
    if (file.path().extension() == ".png") {
      ++pictures;
      const auto same = read_file(lz4.path() / file.path().filename(), 1 << 24);
      EXPECT_TRUE(read_file(file.path(), 1 << 24).value() == same.value()) << file.path();
    }
  EXPECT_GT(pictures, 2u);
}

TEST(ClientModes, RefusesToCaptureOtherModes) {
  const ScratchFolder folder;
  const Ended run = run_client({{"--mode", "remote"},
                                {"--record", (folder.path() / "session").string()},
                                {"--out", folder.path().string()}});
  EXPECT_NE(run.status, 0);
  EXPECT_NE(run.errors.find("only modes hybrid and full can be captured, not mode remote"), std::string::npos)
      << run.errors;
}

TEST(ClientModes, RefusesShadowMapsThatNeedTooMuchMemory) {
  const ScratchFolder folder;
  const Ended run =
      run_client({{"--mode", "local"}, {"--shadow-maps", "8192"}, {"--out", folder.path().string()}});
  EXPECT_NE(run.status, 0);
  EXPECT_NE(run.errors.find("MiB"), std::string::npos) << run.errors;
}

}  // namespace
}  // namespace farshade
