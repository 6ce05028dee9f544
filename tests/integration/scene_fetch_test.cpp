// rt_server and vr_client as processes: the client has no --scene.
#include <gtest/gtest.h>

#include <filesystem>
#include <thread>

#include "stereo/base/clock.h"
#include "stereo/base/files.h"
#include "stereo/base/quantile.h"
#include "tests/integration/client_program.h"
#include "tests/integration/one_triangle.h"
#include "tests/integration/test_keys.h"
#include "tests/support/sanitized.h"
#include "tests/support/tcp_proxy.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

/// Runs vr_client without --scene, with a cache of its own.
class SceneFetch : public testing::Test {
 protected:
  [[nodiscard]] std::vector<std::string> arguments(const std::string& server,
                                                   const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{"/usr/bin/env",
                                 "LSAN_OPTIONS=detect_leaks=0",
                                 "XDG_CACHE_HOME=" + (folder_.path() / "cache").string(),
                                 VR_CLIENT,
                                 "--server",
                                 server,
                                 "--key",
                                 test_keys().client,
                                 "--trace",
                                 kWalk,
                                 "--size",
                                 "48x32",
                                 "--frames",
                                 "3",
                                 "--pictures",
                                 "0",
                                 "--out",
                                 (folder_.path() / "out").string()};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  [[nodiscard]] Ended run(const std::vector<std::string>& command) const {
    ChildProgram program(command);
    const std::string errors = program.errors();
    return {program.wait(), errors};
  }
  /// A scene whose buffer is a file of `bytes` bytes, of which the triangle needs 36.
  [[nodiscard]] std::string large_scene(std::size_t bytes) const {
    std::vector<std::byte> content(bytes);
    const std::array<float, 9> triangle{0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::ranges::copy(std::as_bytes(std::span(triangle)), content.begin());
    for (std::size_t i = 36; i < bytes; ++i) content[i] = static_cast<std::byte>(i * i >> 3);
    fs::create_directories(folder_.path() / "scene/data");
    EXPECT_TRUE(write_file_atomically(folder_.path() / "scene/data/the points.bin", content));
    std::string text;
    const std::string inline_scene =
        one_triangle(folder_.path(), "inline.gltf", R"({"type":"point","intensity":30})");
    const auto bytes_of_text = read_file(inline_scene, 1 << 20).value();
    text.assign(reinterpret_cast<const char*>(bytes_of_text.data()), bytes_of_text.size());
    const std::size_t buffers = text.find(R"("buffers")");
    text = text.substr(0, buffers) + R"("buffers":[{"byteLength":)" + std::to_string(bytes) +
           R"(,"uri":"./data/the%20points.bin"}]})";
    const fs::path path = folder_.path() / "scene/large.gltf";
    EXPECT_TRUE(write_file_atomically(path, text));
    return path.string();
  }

  ScratchFolder folder_;
};

TEST_F(SceneFetch, ShowsTheServersSceneWithItsLighting) {
  RunningServer server(kRoom, "127.0.0.1:0", {"--sun", "145,50,3", "--ambient", "0.1"});
  const Ended first = run(arguments(server.address()));
  EXPECT_EQ(first.status, 0) << first.errors;
  EXPECT_NE(first.errors.find("fetched "), std::string::npos) << first.errors;
  const Ended second = run(arguments(server.address()));
  EXPECT_EQ(second.status, 0) << second.errors;
  EXPECT_EQ(second.errors.find("fetched "), std::string::npos) << "it is in the cache";
  // One that has the file, and names other lighting, is told what to do.
  const Ended other = run(arguments(server.address(), {"--scene", kRoom}));
  EXPECT_EQ(other.status, 1);
  EXPECT_NE(other.errors.find("start the client again without --scene"), std::string::npos) << other.errors;
}

TEST_F(SceneFetch, GoesOnAfterCtrlCAndACutWithFilesOfAFolder) {
  constexpr std::size_t kBytes = 16'000'000;
  RunningServer server(large_scene(kBytes));
  const Peer address = resolve_tcp(server.address()).value().front();
  {
    TcpProxy slow(address, {.bytes_per_second = 1e6, .delay = std::chrono::milliseconds(20)});
    ChildProgram program(arguments(to_string(slow.address())));
    ASSERT_TRUE(program.error_line_after("fetching the scene: ")) << "progress is shown";
    program.send(SIGINT);
    const std::string errors = program.errors();
    EXPECT_EQ(program.wait(), 130);
    EXPECT_LT(slow.passed_bytes(), kBytes / 2) << "it stops at once; all bytes would take 16 s";
    EXPECT_NE(errors.find("the next start goes on from there"), std::string::npos) << errors;
  }
  TcpProxy cutting(address, {.bytes_per_second = 20e6, .cuts = {600'000, 40'000}});
  const Ended rest = run(arguments(to_string(cutting.address()), {"--plan"}));
  EXPECT_EQ(rest.status, 0) << rest.errors;
  EXPECT_EQ(cutting.connections(), 3u);
  EXPECT_LT(cutting.passed_bytes(), kBytes) << "what came before Ctrl-C was not sent again";
  const Ended whole = run(arguments(server.address(), {"--plan"}));
  EXPECT_EQ(whole.status, 0) << whole.errors;
  EXPECT_EQ(whole.errors.find("fetched "), std::string::npos) << whole.errors;
}

/// The ages of the masks of frames that were shown in one of the spans, and of the others. The spans
/// are in seconds after frame number `zero`.
std::pair<std::vector<double>, std::vector<double>> ages_ms(
    const fs::path& out, unsigned long zero, const std::vector<std::pair<double, double>>& spans_s) {
  const Csv frames = read_csv(out / "frames.csv");
  const std::vector<std::string>&shown_ns = frames.at("display_time_ns"), &ages = frames.at("wire age [ms]");
  const auto zero_row =
      std::ranges::find(frames.at("frame"), std::to_string(zero)) - frames.at("frame").begin();
  const double zero_ns = std::stod(shown_ns.at(static_cast<std::size_t>(zero_row)));
  std::vector<double> inside, outside;
  for (std::size_t i = 0; i < ages.size(); ++i) {
    if (ages[i].empty()) continue;
    const double shown_s = (std::stod(shown_ns[i]) - zero_ns) * 1e-9;
    const bool is_inside = std::ranges::any_of(
        spans_s, [&](const auto& span) { return span.first <= shown_s && shown_s <= span.second; });
    (is_inside ? inside : outside).push_back(std::stod(ages[i]));
  }
  EXPECT_GT(inside.size(), 20u);
  EXPECT_GT(outside.size(), 20u);
  return {inside, outside};
}

// The scene's bytes yield to masks: 100 Mbit/s without masks, a quarter beside them.
TEST_F(SceneFetch, LeavesTheMasksOfOthersAsYoungAsTheyWere) {
  const std::string scene = large_scene(6'000'000);
  RunningServer server(scene);
  const fs::path out = folder_.path() / "masks";
  ChildProgram shows(client_arguments({{"--scene", scene},
                                       {"--server", server.address()},
                                       {"--clock", "real"},
                                       {"--frames", "1000"},
                                       {"--size", "48x32"},
                                       {"--reference-every", "0"},
                                       {"--pictures", "0"},
                                       {"--out", out.string()}}));
  unsigned long zero = 0;
  while (zero < 200) {  // a frame that is skipped has no line
    const auto line = shows.error_line_after("frame ");
    ASSERT_TRUE(line) << shows.errors();
    zero = std::stoul(*line);
  }
  const Stopwatch since_zero;
  std::vector<std::pair<double, double>> fetches_s;
  for (int fetch = 0; fetch < 2; ++fetch) {
    fs::remove_all(folder_.path() / "cache");
    const double from_s = seconds_of(since_zero.elapsed());
    const Ended fetches = run(arguments(server.address(), {"--plan"}));
    EXPECT_EQ(fetches.status, 0) << fetches.errors;
    fetches_s.emplace_back(from_s, seconds_of(since_zero.elapsed()));
    EXPECT_GT(fetches_s.back().second - from_s, 1.5) << "6 MB at a quarter of 100 Mbit/s take 1.9 s";
  }
  const std::string errors = shows.errors();
  ASSERT_EQ(shows.wait(), 0) << errors;
  const auto [beside_ms, alone_ms] = ages_ms(out, zero, fetches_s);
  std::printf("median age of masks: %.2f ms beside a fetch, %.2f ms before and after\n",
              quantile(beside_ms, 0.5), quantile(alone_ms, 0.5));
  constexpr double kFrame_ms = 1e3 / 72;
  // The client that fetches works on this machine, too. If it is busy, that holds some frames up, but not
  // most.
  if (!kSanitized) {  // with sanitizers the fetch itself takes most of both cores
    EXPECT_LE(quantile(beside_ms, 0.25), quantile(alone_ms, 0.25) + 0.5 * kFrame_ms);
  }
}

TEST_F(SceneFetch, SaysWhatToDoIfTheServerSendsNoScene) {
  RunningServer server(kRoom, "127.0.0.1:0", {"--no-scene-fetch"});
  const Ended refused = run(arguments(server.address()));
  EXPECT_EQ(refused.status, 1);
  EXPECT_NE(refused.errors.find("--no-scene-fetch"), std::string::npos) << refused.errors;
  EXPECT_NE(refused.errors.find("give --scene"), std::string::npos) << refused.errors;
}

TEST_F(SceneFetch, WorksWithoutKeys) {
  ChildProgram server({RT_SERVER, "--scene", kRoom, "--listen", "127.0.0.1:0", "--insecure"});
  const auto address = server.line_after("rt_server: listening on ");
  ASSERT_TRUE(address);
  const Ended run_insecure = run(arguments(*address, {"--insecure", "--plan"}));
  EXPECT_EQ(run_insecure.status, 0) << run_insecure.errors;
}

TEST_F(SceneFetch, TheDoctorSaysWhatTheServerSends) {
  RunningServer server;
  ChildProgram doctor({VR_CLIENT, "doctor", "--server", server.address(), "--key", test_keys().client});
  const auto line =
      doctor.line_after("ok    scene: the server sends it to clients without --scene: 1 file, ");
  EXPECT_TRUE(line) << doctor.output();
}

}  // namespace
}  // namespace farshade
