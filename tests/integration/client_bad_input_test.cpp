#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "stereo/base/files.h"
#include "tests/integration/client_program.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

class ClientProgramRefuses : public testing::Test {
 protected:
  /// Runs the client. It must fail with one sentence that names `culprit`, and write nothing.
  void expect_refusal(std::map<std::string, std::string> options, const std::string& culprit) {
    options.insert({{"--out", out_.string()}, {"--mode", "full"}});
    const Ended run = run_client(options);
    EXPECT_GT(run.status, 0);
    EXPECT_EQ(std::ranges::count(run.errors, '\n'), 1) << run.errors;
    EXPECT_TRUE(run.errors.starts_with("vr_client: ")) << run.errors;
    EXPECT_NE(run.errors.find(culprit), std::string::npos) << run.errors;
    EXPECT_EQ(files_below(out_), std::vector<std::string>{});
  }

  [[nodiscard]] std::string file(const std::string& name, const std::string& text) const {
    const std::filesystem::path path = folder_.path() / name;
    std::ofstream(path) << text;
    return path.string();
  }

  ScratchFolder folder_;
  std::filesystem::path out_ = folder_.path() / "out";
};

constexpr const char* kHeader =
    "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\n";

TEST_F(ClientProgramRefuses, MissingScene) {
  expect_refusal({{"--scene", "no/such.glb"}}, "no/such.glb");
}

TEST_F(ClientProgramRefuses, TruncatedScene) {
  const auto whole = read_file(kRoom, 1 << 24);
  ASSERT_TRUE(whole.has_value());
  const std::filesystem::path cut = folder_.path() / "cut.glb";
  for (const std::size_t size : {std::size_t{0}, std::size_t{11}, std::size_t{5000}, whole->size() - 1}) {
    std::ofstream(cut, std::ios::binary)
        .write(reinterpret_cast<const char*>(whole->data()), static_cast<std::streamsize>(size));
    expect_refusal({{"--scene", cut.string()}}, "cut.glb");
  }
}

TEST_F(ClientProgramRefuses, MissingHeadRecording) {
  expect_refusal({{"--trace", "no/such.csv"}}, "no/such.csv");
}

TEST_F(ClientProgramRefuses, HeadRecordingWithNaN) {
  expect_refusal(
      {{"--trace", file("nan.csv", std::string(kHeader) + "0,0,0,0,1,0,0,0\n10,nan,0,0,1,0,0,0\n")}},
      "nan.csv:3");
}

TEST_F(ClientProgramRefuses, HeadRecordingWithTwoRows) {
  expect_refusal(
      {{"--trace", file("short.csv", std::string(kHeader) + "0,0,0,0,1,0,0,0\n10,0,0,0,1,0,0,0\n")}},
      "short.csv");
}

TEST_F(ClientProgramRefuses, HeadRecordingWithTooFewRowsInTimeOrder) {
  expect_refusal({{"--trace", file("back.csv", std::string(kHeader) + "20,0,0,0,1,0,0,0\n10,0,0,0,1,0,0,0\n"
                                                                      "30,0,0,0,1,0,0,0\n")}},
                 "back.csv: holds 2 head samples in time order");
}

TEST_F(ClientProgramRefuses, SkipBeyondTheHeadRecording) {
  expect_refusal({{"--skip", "1000"}}, "--skip 1000");
}

/// The frames that there are are shown all the same.
TEST_F(ClientProgramRefuses, MoreFramesThanTheHeadRecordingHas) {
  const std::string trace =
      file("short.csv", "0,0,1.6,0,1,0,0,0\n14000000,0,1.6,0,1,0,0,0\n28000000,0,1.6,0,1,0,0,0\n");
  const Ended run = run_client({{"--out", out_.string()},
                                {"--mode", "full"},
                                {"--trace", trace},
                                {"--frames", "4"},
                                {"--refresh", "72"}});
  EXPECT_EQ(run.status, 1);
  EXPECT_NE(run.errors.find("--frames 4: " + trace + " has only 3 frames at 72 Hz"), std::string::npos)
      << run.errors;
  EXPECT_TRUE(std::filesystem::exists(out_ / "summary.csv"));
}

TEST_F(ClientProgramRefuses, HeadRecordingOfAnotherLayout) {
  expect_refusal({{"--trace", file("kitti.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n")}}, "KITTI");
}

TEST_F(ClientProgramRefuses, OutputFolderThatIsAFile) {
  const std::string taken = file("taken", "mine");
  expect_refusal({{"--out", taken}}, "taken");
  expect_refusal({{"--out", taken + "/below"}}, "taken/below");
  EXPECT_EQ(std::filesystem::file_size(taken), 4u);
}

TEST_F(ClientProgramRefuses, SizesOutOfRange) {
  for (const std::string size : {"0x0", "100000x100000", "96"})
    expect_refusal({{"--size", size}}, "size '" + size + "' is not WIDTHxHEIGHT");
}

TEST_F(ClientProgramRefuses, MissingDevice) {
  expect_refusal({{"--gpu", "Voodoo2"}}, "no usable Vulkan 1.3 device");
}

/// As on a full disk: the numbers are written and printed all the same.
TEST_F(ClientProgramRefuses, OutputThatCannotBeWrittenLater) {
  std::filesystem::create_directories(out_ / "frame_0001_left.png");  // a folder with the name of a picture
  const Ended run =
      run_client({{"--out", out_.string()}, {"--mode", "full"}, {"--frames", "1"}, {"--pictures", "1"}});
  EXPECT_GT(run.status, 0);
  EXPECT_NE(run.errors.find("frame_0001_left.png"), std::string::npos) << run.errors;
  EXPECT_EQ(files_below(out_), (std::vector<std::string>{"frames.csv", "summary.csv"}));
}

TEST_F(ClientProgramRefuses, ServerOfAnotherScene) {
  RunningServer server(FARSHADE_ASSETS "/box_over_plane.gltf");
  const Ended run = run_client({{"--server", server.address()}, {"--out", out_.string()}});
  EXPECT_GT(run.status, 0);
  const std::string cure = "give both the same scene file";
  EXPECT_NE(run.errors.find(cure), std::string::npos) << run.errors;
  EXPECT_EQ(files_below(out_), std::vector<std::string>{});
  server.program().send(SIGTERM);
  EXPECT_NE(server.program().errors().find(cure), std::string::npos);
}

TEST_F(ClientProgramRefuses, InvalidAddress) {
  const Ended run = run_client({{"--server", "here:x"}, {"--out", out_.string()}});
  EXPECT_GT(run.status, 0);
  EXPECT_NE(run.errors.find("'here:x' is no address"), std::string::npos) << run.errors;
}

}  // namespace
}  // namespace farshade
