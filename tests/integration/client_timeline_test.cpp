// Reads a timeline from its file, as a viewer would.
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/integration/client_program.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

using nlohmann::json;

struct TimeSpan {
  double begin_us, end_us;
};

/// The events by name, phase and frame. Each occurs once.
using Spans = std::map<std::string, std::map<std::uint32_t, TimeSpan>>;

Spans spans_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  const json trace = json::parse(file);
  Spans spans;
  for (const json& event : trace["traceEvents"]) {
    if (event["ph"] == "M") continue;
    const double begin = event["ts"], length = event.value("dur", 0.0);
    EXPECT_GE(length, 0) << event;
    const std::string name = event["name"].get<std::string>() + " " + event["ph"].get<std::string>();
    const auto frame = event["args"]["frame"].get<std::uint32_t>();
    EXPECT_TRUE(spans[name].emplace(frame, TimeSpan{begin, begin + length}).second) << event;
  }
  return spans;
}

void expect_inside(const TimeSpan& inner, const TimeSpan& outer, const std::string& what) {
  EXPECT_GE(inner.begin_us, outer.begin_us) << what;
  EXPECT_LE(inner.end_us, outer.end_us) << what;
}

TEST(ClientTimeline, HasEveryFrameAndTheWorkOfTheServer) {
  const ScratchFolder folder;
  const RunningServer server;
  const std::filesystem::path file = folder.path() / "timeline.json";
  const Ended run = run_client(
      {{"--server", server.address()}, {"--timeline", file.string()}, {"--out", folder.path().string()}});
  ASSERT_EQ(run.status, 0) << run.errors;
  Spans spans = spans_of(file);
  EXPECT_EQ(spans["frame X"].size(), 8u);
  EXPECT_EQ(spans["frame X"][1].begin_us, 0);
  for (const auto& [frame, whole] : spans["frame X"])
    for (const std::string stage : {"request X", "collect X", "draw X", "G-buffer X", "shade X"}) {
      ASSERT_TRUE(spans[stage].contains(frame)) << stage << " of frame " << frame;
      expect_inside(spans[stage][frame], whole, stage);
    }
  EXPECT_EQ(spans["work X"].size(), 8u) << "in virtual time every frame's masks are awaited";
  for (const auto& [frame, work] : spans["work X"]) {
    const TimeSpan exchange{spans["request s"][frame].begin_us, spans["datagrams X"][frame].begin_us};
    expect_inside(spans["request s"][frame], spans["request X"][frame], "sending");
    expect_inside(work, exchange, "work");
    expect_inside(spans["waited X"][frame], exchange, "waited");
    for (const std::string stage : {"primary X", "shadow X", "pack X"})
      expect_inside(spans[stage][frame], work, stage);
    EXPECT_EQ(spans["request f"][frame].begin_us, work.begin_us);
  }
  // A delay of 20 ms is two frames: frames 3 to 8 are drawn with the masks of frames 1 to 6.
  EXPECT_EQ(spans["masks f"].size(), 6u);
  for (const auto& [frame, drawn] : spans["masks f"])
    EXPECT_EQ(drawn.begin_us, spans["draw X"][frame + 2].begin_us);
}

TEST(ClientTimeline, IsWrittenAfterASignal) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder.path() / "timeline.json";
  ChildProgram client(client_arguments({{"--mode", "full"},
                                        {"--frames", "1400"},
                                        {"--reference-every", "0"},
                                        {"--timeline", file.string()},
                                        {"--out", folder.path().string()}}));
  ASSERT_TRUE(client.error_line_after("frame 140 of 1400"));
  client.send(SIGINT);
  const std::string errors = client.errors();
  EXPECT_EQ(client.wait(), 130) << errors;
  const std::size_t shown = spans_of(file)["frame X"].size();
  EXPECT_EQ(shown, read_csv(folder.path() / "frames.csv").at("frame").size());
  EXPECT_GE(shown, 140u);
}

TEST(ClientTimeline, FailsAtOnceIfItCannotBeWritten) {
  const ScratchFolder folder;
  const Ended run = run_client({{"--mode", "full"},
                                {"--timeline", (folder.path() / "no" / "timeline.json").string()},
                                {"--out", folder.path().string()}});
  EXPECT_EQ(run.status, 1);
  EXPECT_NE(run.errors.find("timeline.json"), std::string::npos) << run.errors;
  EXPECT_EQ(run.errors.find("frame 1 of"), std::string::npos) << run.errors;
}

}  // namespace
}  // namespace farshade
