#include "vr_client/report/timeline.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "stereo/base/files.h"
#include "tests/support/packed.h"
#include "tests/unit/scratch_folder.h"

namespace farshade {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr Time kBegin(7h);
constexpr Extent kSize{16, 16};

/// Builds the timeline of a run step by step. Times are relative to kBegin.
class Told {
 public:
  Told() { receiver_.begin({}); }

  /// Frame `number` begins at `at`. Its stages are 1 ms request (sent after 0.5 ms), 2 ms collect and 5 ms
  /// draw.
  void show(std::uint32_t number, Duration at, std::optional<std::uint32_t> newest_mask = std::nullopt,
            const StageTimes& times = {{.gbuffer = 1ms, .shade = 3ms, .total = 5ms}},
            std::optional<StageStarts> late = std::nullopt,
            const std::optional<FinishedPicture>& finished = std::nullopt) {
    const Time begin = kBegin + at;
    FrameRequest request{{.frame = {number}, .display_time = {}, .scene_time = {}, .views = {}}};
    for (View& view : request.views) view = {{}, {-0.7, 0.8, 0.6, -0.5}, kSize};
    (void)receiver_.ask(request, {}, late ? *late->requested_late - 100us : begin + 500us);
    std::vector<TracedMask> masks;
    if (newest_mask) masks.push_back({{*newest_mask}, {}, {}, request.views, no_masks_, no_tiles_});
    const StageStarts starts = late.value_or(StageStarts{begin, begin + 1ms, begin + 3ms, begin + 8ms});
    FrameView view{request, &request, state_, masks, nullptr, std::nullopt, times, starts, settings_, {}};
    view.finished = finished;
    timeline.add(view, &receiver_);
  }

  void first_slice_comes(std::uint32_t number, Duration at) {
    const PerEye<EyeMask> masks{EyeMask(kSize, 1), EyeMask(kSize, 1)};
    const auto messages =
        pack(packer_, {{number}, kFirstLightSet, receiver_.find({number})->request.views, masks}, {});
    receiver_.take(std::get<Slice>(*decode_server(messages.front())), kBegin + at);
  }

  void report_comes(FrameReport report, Duration at) { receiver_.take(report, kBegin + at); }

  Timeline timeline;

 private:
  FrameReceiver receiver_{8, {1}};
  FramePacker packer_;
  const SceneState state_;
  const FrameSettings settings_;
  const PerEye<EyeMask> no_masks_;
  const PerEye<ReceivedTiles> no_tiles_;
};

/// 7 ms of work.
FrameReport report_of(std::uint32_t frame) {
  return {.frame = {frame}, .primary = 2ms, .shadow = 3ms, .pack = 1ms, .waited = 1ms};
}

struct Event {
  std::string phase, name, thread;
  double begin_us, end_us;
  std::uint32_t frame;
  std::uint32_t tid;
  friend bool operator==(const Event&, const Event&) = default;
};

/// All events except metadata, in the order of the file. Threads are named "process thread".
std::vector<Event> events_of(const std::string& text) {
  const json trace = json::parse(text);
  EXPECT_EQ(trace["displayTimeUnit"], "ms");
  std::map<int, std::string> processes;
  std::map<int, std::string> threads;
  for (const json& event : trace["traceEvents"])
    if (event["name"] == "process_name") processes[event["pid"]] = event["args"]["name"];
  for (const json& event : trace["traceEvents"])
    if (event["name"] == "thread_name")
      threads[event["tid"]] = processes.at(event["pid"]) + " " + event["args"]["name"].get<std::string>();
  std::vector<Event> events;
  for (const json& event : trace["traceEvents"]) {
    if (event["ph"] == "M") continue;
    const double begin = event["ts"];
    events.push_back({event["ph"], event["name"], threads.at(event["tid"]), begin,
                      begin + event.value("dur", 0.0), event["args"]["frame"], event["tid"]});
  }
  return events;
}

std::vector<Event> events_on(const std::string& thread, const Told& told) {
  std::vector<Event> found;
  for (const Event& event : events_of(told.timeline.text()))
    if (event.thread == thread && event.phase == "X") found.push_back(event);
  return found;
}

std::vector<Event> arrows_of(const Told& told) {
  std::vector<Event> found;
  for (const Event& event : events_of(told.timeline.text()))
    if (event.phase != "X") found.push_back(event);
  return found;
}

bool holds(const Event& outer, const Event& inner) {
  return outer.tid == inner.tid && outer.begin_us <= inner.begin_us && inner.end_us <= outer.end_us;
}

/// Checks what every viewer needs: no negative length; spans of a thread are disjoint or nested, the outer
/// one first; arrows lead forwards in time and end in spans.
void expect_sound(const std::vector<Event>& events) {
  std::map<std::pair<std::string, std::uint32_t>, std::vector<Event>> arrows;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const Event& event = events[i];
    EXPECT_GE(event.end_us, event.begin_us) << event.name << " of " << event.frame;
    if (event.phase != "X") {
      arrows[{event.name, event.frame}].push_back(event);
      EXPECT_TRUE(std::ranges::any_of(
          events, [&](const Event& span) { return span.phase == "X" && holds(span, event); }));
      continue;
    }
    for (std::size_t k = 0; k < i; ++k) {
      const Event& earlier = events[k];
      const bool apart = earlier.end_us <= event.begin_us || event.end_us <= earlier.begin_us;
      if (earlier.phase == "X" && earlier.tid == event.tid) {
        EXPECT_TRUE(apart || holds(earlier, event))
            << earlier.name << " of " << earlier.frame << ", " << event.name << " of " << event.frame;
      }
    }
  }
  for (const auto& [key, ends] : arrows) {
    ASSERT_EQ(ends.size(), 2u) << key.first << " of " << key.second;
    EXPECT_EQ(ends[0].phase + ends[1].phase, "sf");
    EXPECT_LE(ends[0].begin_us, ends[1].begin_us);
  }
}

TEST(PlaceWork, PlacesTheWorkInTheMiddle) {
  const TimeSpan placed = place_work(kBegin, kBegin + 17ms, 7ms);
  EXPECT_EQ(placed.begin, kBegin + 5ms);
  EXPECT_EQ(placed.end, kBegin + 12ms);
}

TEST(PlaceWork, StaysWithinTheInterval) {
  for (const Duration between : {-3ms, 0ms, 2ms}) {
    const TimeSpan placed = place_work(kBegin, kBegin + between, 7ms);
    EXPECT_EQ(placed.begin, kBegin);
    EXPECT_EQ(placed.end, kBegin + std::max(between, Duration::zero()));
  }
  EXPECT_EQ(place_work(kBegin, kBegin + 4ms, -1ms).end, kBegin + 2ms);
}

TEST(Timeline, PlacesTheStagesOfTheClient) {
  Told told;
  told.show(1, 0ms);
  told.show(2, 20ms);
  const auto frames = events_on("vr_client frame", told);
  ASSERT_EQ(frames.size(), 8u);
  const std::uint32_t tid = frames[0].tid;
  const auto on = [&](const char* name, double begin, double end, std::uint32_t frame) {
    return Event{"X", name, "vr_client frame", begin, end, frame, tid};
  };
  EXPECT_EQ(frames, (std::vector{on("frame", 0, 8000, 1), on("request", 0, 1000, 1),
                                 on("collect", 1000, 3000, 1), on("draw", 3000, 8000, 1),
                                 on("frame", 20000, 28000, 2), on("request", 20000, 21000, 2),
                                 on("collect", 21000, 23000, 2), on("draw", 23000, 28000, 2)}));
}

/// It is sent from 4 to 6 ms, while the device still draws.
TEST(Timeline, ShowsALateRequestBesideThePictureAndItsPassesBeforeIt) {
  Told told;
  const StageStarts starts{kBegin, kBegin + 1ms, kBegin + 3ms, kBegin + 8ms, kBegin + 4ms, kBegin + 6ms};
  told.show(1, 0ms, std::nullopt,
            {{.gbuffer = 1ms, .depth = 500us, .shade = 1500us, .request_reprojection = 1ms, .total = 3ms}},
            starts);
  expect_sound(events_of(told.timeline.text()));
  const auto frames = events_on("vr_client frame", told);
  ASSERT_EQ(frames.size(), 5u);
  EXPECT_EQ(frames[3].name, "draw");
  EXPECT_EQ(frames[3].end_us, 8000);
  EXPECT_EQ(frames[4].name, "request");
  EXPECT_EQ(frames[4].begin_us, 4000);
  EXPECT_EQ(frames[4].end_us, 6000);
  const auto passes = events_on("vr_client device", told);
  std::vector<std::string> names;
  for (const Event& pass : passes) names.push_back(pass.name);
  EXPECT_EQ(names, (std::vector<std::string>{"depth", "carry", "G-buffer", "shade"}));
  EXPECT_EQ(passes.front().begin_us, 4000);
  EXPECT_EQ(passes.back().end_us, 8000);
}

/// With frames in flight the times on the device are those of an earlier frame.
TEST(Timeline, ShowsThePassesOfAFrameInFlightWhereTheyWere) {
  Told told;
  const StageTimes times{{.gbuffer = 2ms, .shade = 4ms, .total = 1ms, .frames_ago = 1}};
  told.show(1, 0ms, {}, times);
  told.show(2, 10ms, {}, times, {}, FinishedPicture{{1}, kBegin, kBegin + 12ms});
  const auto passes = events_on("vr_client device", told);
  ASSERT_EQ(passes.size(), 2u);
  EXPECT_EQ(passes[0].begin_us, 6000);
  EXPECT_EQ(passes[1].end_us, 12000);
  EXPECT_EQ(passes[1].frame, 1u);
}

TEST(Timeline, EndsThePassesOfTheDeviceWithDraw) {
  Told told;
  told.show(1, 0ms, {}, {{.gbuffer = 500us, .depth = 250us, .shade = 2ms, .total = 4ms}});
  const auto passes = events_on("vr_client device", told);
  ASSERT_EQ(passes.size(), 3u);
  EXPECT_EQ(passes[0].name, "G-buffer");
  EXPECT_EQ(passes[0].begin_us, 4250);
  EXPECT_EQ(passes[1].begin_us, 4750);
  EXPECT_EQ(passes[2].begin_us, 5000);
  EXPECT_EQ(passes[2].end_us, 7000);
}

TEST(Timeline, ScalesDownDevicePassesThatAreLongerThanDraw) {
  Told told;
  told.show(1, 0ms, {}, {{.gbuffer = 6ms, .shade = 2ms, .total = 4ms}});
  const auto passes = events_on("vr_client device", told);
  ASSERT_EQ(passes.size(), 2u) << "no depth was drawn";
  EXPECT_EQ(passes[0].begin_us, 3000);
  EXPECT_EQ(passes[1].begin_us, 6000);
  EXPECT_EQ(passes[1].end_us, 7000);
}

TEST(Timeline, PlacesTheWorkOfTheServerBetweenRequestAndFirstSlice) {
  Told told;
  told.show(1, 0ms);
  told.first_slice_comes(1, 17500us);  // 17 ms after it was sent; 10 ms of this are network delay
  told.report_comes(report_of(1), 21ms);
  for (const std::uint32_t frame : {2u, 3u, 4u}) told.show(frame, frame * 10ms);
  const auto waiting = events_on("rt_server waiting", told);
  ASSERT_EQ(waiting.size(), 1u) << "the exchange of a frame appears once";
  EXPECT_EQ(waiting[0].begin_us, 5500);
  EXPECT_EQ(waiting[0].end_us, 6500);
  const auto work = events_on("rt_server worker", told);
  ASSERT_EQ(work.size(), 4u);
  const std::array<std::tuple<std::string, double, double>, 4> expected{
      {{"work", 6500, 12500}, {"primary", 6500, 8500}, {"shadow", 8500, 11500}, {"pack", 11500, 12500}}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(std::tuple(work[i].name, work[i].begin_us, work[i].end_us), expected[i]);
    EXPECT_EQ(work[i].frame, 1u);
  }
  const auto datagrams = events_on("vr_client network", told);
  ASSERT_EQ(datagrams.size(), 1u);
  EXPECT_EQ(datagrams[0].begin_us, 17500);
  EXPECT_EQ(datagrams[0].end_us, 21000);
}

TEST(Timeline, ScalesDownServerWorkThatIsLongerThanTheExchange) {
  Told told;
  told.show(1, 0ms);
  told.first_slice_comes(1, 4000us);  // 3.5 ms after it was sent, for 7 ms of work
  told.report_comes(report_of(1), 5ms);
  told.show(2, 10ms);
  EXPECT_EQ(events_on("rt_server waiting", told)[0].begin_us, 500);
  const auto work = events_on("rt_server worker", told);
  EXPECT_EQ(work[0].begin_us, 1000);
  EXPECT_EQ(work[0].end_us, 4000);
  EXPECT_EQ(work[2].begin_us, 2000);
  expect_sound(events_of(told.timeline.text()));
}

TEST(Timeline, DrawsArrowsFromRequestToWorkAndToTheFirstFrameWithItsMasks) {
  Told told;
  told.show(1, 0ms);
  told.first_slice_comes(1, 17500us);
  told.show(2, 18ms, 1);  // drawn with the masks before their report arrived
  told.report_comes(report_of(1), 21ms);
  told.show(3, 30ms, 1);
  const auto arrows = arrows_of(told);
  ASSERT_EQ(arrows.size(), 4u);
  const std::array<std::tuple<std::string, std::string, std::string, double>, 4> expected{
      {{"s", "request", "vr_client frame", 500},
       {"f", "request", "rt_server worker", 6500},
       {"s", "masks", "rt_server worker", 11500},
       {"f", "masks", "vr_client frame", 21000}}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(std::tuple(arrows[i].phase, arrows[i].name, arrows[i].thread, arrows[i].begin_us), expected[i]);
    EXPECT_EQ(arrows[i].frame, 1u);
  }
  expect_sound(events_of(told.timeline.text()));
}

TEST(Timeline, OmitsTheServerIfItsReportOrSlicesNeverArrive) {
  Told told;
  told.show(1, 0ms);
  told.show(2, 10ms);
  told.first_slice_comes(1, 15ms);
  told.report_comes(report_of(2), 16ms);
  for (std::uint32_t frame = 3; frame < 40; ++frame) told.show(frame, frame * 10ms);
  EXPECT_TRUE(events_on("rt_server worker", told).empty());
  EXPECT_TRUE(arrows_of(told).empty());
  const auto datagrams = events_on("vr_client network", told);
  ASSERT_EQ(datagrams.size(), 1u);
  EXPECT_EQ(datagrams[0].begin_us, 15000);
  EXPECT_EQ(datagrams[0].end_us, 15000);
}

TEST(Timeline, PutsOverlappingSpansOnSeparateThreads) {
  Told told;
  told.show(1, 0ms);
  told.show(2, 8ms);
  told.first_slice_comes(1, 17500us);
  told.first_slice_comes(2, 18000us);  // its work begins at 9.75 ms, that of frame 1 ends at 12.5 ms
  for (const std::uint32_t frame : {1u, 2u}) told.report_comes(report_of(frame), 20ms);
  told.show(3, 20ms);
  const auto work = events_on("rt_server worker", told);
  ASSERT_EQ(work.size(), 8u);
  EXPECT_NE(work[0].tid, work[4].tid);
  EXPECT_LT(work[4].begin_us, work[0].end_us);
  expect_sound(events_of(told.timeline.text()));
}

TEST(Timeline, IsConsistentForAnyNetwork) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const auto up_to_ns = [&](std::int64_t most) {
    return Duration(std::uniform_int_distribution<std::int64_t>(0, most)(random));
  };
  Told told;
  std::optional<std::uint32_t> newest;
  for (std::uint32_t frame = 1; frame <= 60; ++frame) {
    const Duration begin = frame * 10ms;
    told.show(frame, begin, newest,
              {{.gbuffer = up_to_ns(4'000'000),
                .depth = up_to_ns(2'000'000),
                .shade = up_to_ns(2'000'000),
                .total = up_to_ns(6'000'000)}});
    if (random() % 4 == 0) continue;
    const Duration first = begin + 500us + up_to_ns(9'000'000);
    told.first_slice_comes(frame, first);
    newest = frame;
    if (random() % 4 == 0) continue;
    FrameReport report = report_of(frame);
    report.waited = up_to_ns(3'000'000);
    report.update = up_to_ns(2'000'000);
    report.shadow = up_to_ns(6'000'000);
    told.report_comes(report, first + up_to_ns(20'000'000));
  }
  const auto events = events_of(told.timeline.text());
  EXPECT_GT(events.size(), 60u * 6);
  expect_sound(events);
}

TEST(Timeline, HasOnlyTheStagesOfTheClientWithoutAServer) {
  Timeline timeline;
  EXPECT_TRUE(events_of(timeline.text()).empty());
  const FrameMoment shown{};
  const SceneState state;
  const FrameSettings settings;
  const StageTimes times{{.gbuffer = 1ms, .total = 5ms}};
  timeline.add({shown,
                nullptr,
                state,
                {},
                nullptr,
                std::nullopt,
                times,
                {kBegin, kBegin + 1ms, kBegin + 3ms, kBegin + 8ms},
                settings,
                {}},
               nullptr);
  EXPECT_EQ(events_of(timeline.text()).size(), 5u);
}

TEST(Timeline, IsWrittenWholeOrNotAtAll) {
  const ScratchFolder folder;
  Told told;
  told.show(1, 0ms);
  const std::filesystem::path file = folder.path() / "timeline.json";
  ASSERT_TRUE(told.timeline.write(file));
  const auto bytes = read_file(file, 1 << 20);
  ASSERT_TRUE(bytes);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()), told.timeline.text());
  EXPECT_FALSE(told.timeline.write(folder.path() / "no" / "such.json"));
}

}  // namespace
}  // namespace farshade
