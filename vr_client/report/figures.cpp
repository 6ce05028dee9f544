#include "vr_client/report/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>

#include "stereo/options/command_line.h"

namespace farshade {
namespace {

using Value = std::optional<double>;

constexpr double kDegrees = 180 / std::numbers::pi;

template <class... Modes>
constexpr ModeSet in(Modes... modes) {
  return ((ModeSet{1} << static_cast<unsigned>(modes)) | ...);
}
constexpr ModeSet kMasks = in(Mode::Hybrid, Mode::ClientPositions),
                  kPictures = in(Mode::ServerGBuffer, Mode::Remote, Mode::Delta),
                  kServed = kMasks | kPictures, kAll = kServed | in(Mode::Local, Mode::Full),
                  kDraws = kMasks | in(Mode::Delta, Mode::Local, Mode::Full),
                  kShades = kDraws | in(Mode::ServerGBuffer), kWider = kMasks | in(Mode::Remote, Mode::Delta),
                  kInFilesOnly = 0;

constexpr const char *kByClient = "By the client's clock around the step, in each frame.",
                     *kByDevice =
                         "By time stamps of the graphics device around the pass, in each frame; with "
                         "frames in flight, those of the newest frame that the device has finished.",
                     *kCounted = "Counted in each frame.",
                     *kByServer =
                         "By the server's clock, which its report of the answer carries; once for "
                         "each answer, in the frame that shows it first.",
                     *kByReport =
                         "Counted by the server, which its report of the answer carries; once for "
                         "each answer, in the frame that shows it first.",
                     *kByLink =
                         "Counted at the client's socket between two frames, with headers of this "
                         "protocol but not of UDP and IP.",
                     *kByViews = "From the poses of the left eye, in each frame with an answer.",
                     *kByCubeMask =
                         "Summed over the answers of the cube mask that came during the frame; "
                         "other frames have no value.",
                     *kByReference =
                         "Against a full trace at the shown pose, in every frame that --reference-every "
                         "names; without frames before the first answer and eyes that show no surface.";

Figure stage(const char* name, Duration StageTimes::*time, ModeSet printed_in, const char* meaning,
             const char* measured) {
  return {{"client", name, "ms", meaning, measured},
          [time](const FrameRecord& r) -> Value { return ms_of(r.times.*time); },
          Worse::High,
          printed_in};
}

/// A stage on the device. With frames in flight the first frames have no value.
Figure device_stage(const char* name, Duration StageTimes::*time, ModeSet printed_in, const char* meaning,
                    const char* measured = kByDevice) {
  Figure figure = stage(name, time, printed_in, meaning, measured);
  figure.of = [time](const FrameRecord& r) -> Value {
    const bool has_finished = r.times.frames_ago == 0 || r.times.ready > Duration::zero();
    return has_finished ? Value(ms_of(r.times.*time)) : std::nullopt;
  };
  return figure;
}

std::vector<Figure> client_figures() {
  using T = StageTimes;
  return {
      stage("frame", &T::frame, kAll,
            "The client's work on a frame: request, collect masks and draw, without waiting for the "
            "server or the display.",
            kByClient),
      stage("request", &T::request, kServed,
            "Locating the views, animating the scene, predicting the views to ask for, and sending.",
            kByClient),
      stage("collect masks", &T::collect, kServed | in(Mode::Full),
            "Decoding what has arrived; in mode full: tracing.", kByClient),
      stage("draw", &T::total, kAll, "Recording, uploads, all passes on the device and the wait for them.",
            kByClient),
      device_stage("picture ready after", &T::ready, kAll,
                   "From the beginning of a frame until the device has finished its picture.", kByClient),
      device_stage("G-buffer", &T::gbuffer, kDraws,
                   "Drawing depth, normals and materials of the shown views."),
      device_stage("depth of requested views", &T::depth, kMasks,
                   "Drawing the depth of the views that are asked for."),
      device_stage("carry over to requested views", &T::request_reprojection, in(Mode::Hybrid),
                   "Reprojecting the newest mask to the requested views, to find what to ask for."),
      device_stage("shadow maps", &T::maps, in(Mode::Local), "Drawing the shadow maps that have changed."),
      device_stage("reproject and shade", &T::shade, kShades,
                   "Looking up the visibility of each light at each pixel, and shading."),
      device_stage("turn", &T::timewarp, kPictures, "Turning a picture of the server to the shown views.")};
}

std::vector<Figure> triangle_figures() {
  const auto triangles = [](const char* name, std::uint64_t DrawnTriangles::*of_pass, const char* meaning) {
    return Figure{{"client", name, "triangles", meaning, kCounted}, [of_pass](const FrameRecord& r) -> Value {
                    return static_cast<double>(r.times.triangles.*of_pass);
                  }};
  };
  return {
      triangles("triangles of the G-buffer", &DrawnTriangles::gbuffer,
                "Triangles that the G-buffer of both eyes draws."),
      triangles("triangles of requested views", &DrawnTriangles::depth,
                "Triangles that the depth of the requested views draws."),
      triangles("triangles of shadow maps", &DrawnTriangles::maps, "Triangles that the shadow maps draw.")};
}

/// The figure that `get` reads from `from`, an optional member of the record.
template <class From, class Get>
Figure figure(FigureText text, std::optional<From> FrameRecord::*from, ModeSet printed_in, Get get) {
  return {std::move(text),
          [=](const FrameRecord& r) -> Value {
            return r.*from ? Value(static_cast<double>(get(*(r.*from)))) : std::nullopt;
          },
          Worse::High, printed_in};
}

double percent_of_full_trace(const FrameReport& report) {
  if (report.full_shadow_rays == 0) return 0;
  return 100.0 * static_cast<double>(report.shadow_rays) / static_cast<double>(report.full_shadow_rays);
}

std::vector<Figure> server_times() {
  using Report = FrameReport;
  const auto time = [](const char* name, ModeSet printed_in, const char* meaning, auto get) {
    return figure({"server", name, "ms", meaning, kByServer}, &FrameRecord::server, printed_in,
                  [=](const Report& r) { return ms_of(get(r)); });
  };
  return {
      time("frame", kServed,
           "The server's work on an answer: scene update, primary visibility, shadow rays, draw, code and "
           "pack, without waiting.",
           [](const Report& r) { return total_work(r); }),
      time("scene update", kServed, "Bringing vertices and hierarchies to the time of the request.",
           [](const Report& r) { return r.update; }),
      time("primary visibility", kServed, "Finding the surface point of each requested pixel.",
           [](const Report& r) { return r.primary; }),
      time("shadow rays", kServed, "Tracing shadow rays and what decides which are needed.",
           [](const Report& r) { return r.shadow; }),
      time("draw", kPictures, "Drawing the G-buffer or the picture on the server.",
           [](const Report& r) { return r.draw; }),
      time("code and pack", kServed, "Compressing the answer and cutting it into datagrams.",
           [](const Report& r) { return r.pack; }),
      time("request waited", kServed, "From the arrival of a request to the beginning of the work on it.",
           [](const Report& r) { return r.waited; })};
}

std::vector<Figure> server_counts() {
  using Report = FrameReport;
  return {figure({"server", "primary rays", "rays", "Primary rays of an answer.", kByReport},
                 &FrameRecord::server, kInFilesOnly, [](const Report& r) { return r.primary_rays; }),
          figure({"server", "traced shadow rays", "rays", "Shadow rays of an answer.", kByReport},
                 &FrameRecord::server, kInFilesOnly, [](const Report& r) { return r.shadow_rays; }),
          figure({"server", "share of a full trace", "%",
                  "Traced shadow rays as a share of those without any saving: one for each pixel and light.",
                  kByReport},
                 &FrameRecord::server, in(Mode::Hybrid), percent_of_full_trace),
          figure({"server", "frame of the surround", "ms", "The server's work on answers of the cube mask.",
                  kByCubeMask},
                 &FrameRecord::cube_mask, kInFilesOnly,
                 [](const CubeMaskCost& cost) { return ms_of(cost.server); }),
          figure({"server", "rays of the surround", "rays", "Primary and shadow rays of the cube mask.",
                  kByCubeMask},
                 &FrameRecord::cube_mask, kInFilesOnly, [](const CubeMaskCost& cost) { return cost.rays; })};
}

std::vector<Figure> traffic_figures() {
  using Report = FrameReport;
  std::vector<Figure> all{
      figure({"wire", "bytes down a frame", "B", "Bytes of the datagrams received since the frame before.",
              kByLink},
             &FrameRecord::traffic, kServed, [](const LinkTraffic& traffic) { return traffic.down; }),
      figure(
          {"wire", "bytes up a frame", "B", "Bytes of the datagrams sent since the frame before.", kByLink},
          &FrameRecord::traffic, kServed, [](const LinkTraffic& traffic) { return traffic.up; }),
      figure({"wire", "datagrams of an answer", "datagrams", "Datagrams of an answer, with its report.",
              kByReport},
             &FrameRecord::server, kInFilesOnly, [](const Report& r) { return r.slices + 1.0; }),
      figure({"wire", "bytes of an answer", "B", "Bytes of an answer's messages before they are sealed.",
              kByReport},
             &FrameRecord::server, kInFilesOnly, [](const Report& r) { return r.payload_bytes; }),
      figure({"wire", "bytes of the surround", "B",
              "Bytes of the cube mask's messages before they are sealed.", kByCubeMask},
             &FrameRecord::cube_mask, kInFilesOnly, [](const CubeMaskCost& cost) { return cost.bytes; }),
      figure({"wire", "rate of the path", "Mbit/s",
              "What the path from the server carries, by the server's estimate, which begins at 32 Mbit/s.",
              "From the arrivals that the client reports (docs/link.md), once for each answer."},
             &FrameRecord::server, kInFilesOnly, [](const Report& r) { return r.bytes_per_second * 8e-6; }),
      figure({"wire", "size of requested views", "%",
              "The width of views that the server asks for, as a share of the full width; less than 100 on a "
              "path that does not carry masks of full size.",
              kByReport},
             &FrameRecord::server, kInFilesOnly,
             [](const Report& r) { return 100 * factor_of(r.view_scale); })};
  all.back().worse = Worse::Low;
  return all;
}

std::vector<Figure> age_and_head_figures() {
  return {
      figure({"wire", "asked for", "% of the views",
              "The part of the requested views that the request asks for.", kCounted},
             &FrameRecord::requested, in(Mode::Hybrid), [](double share) { return share * 100; }),
      figure({"wire", "staleness", "ms",
              "Display time of the frame minus the display time that its newest answer was made for, without "
              "its sign.",
              kByViews},
             &FrameRecord::delta, kInFilesOnly, [](const PoseDelta& d) { return std::abs(ms_of(d.age)); }),
      figure(
          {"wire", "age", "ms", "Display time of the frame minus the time its newest answer was requested.",
           "In each frame with an answer."},
          &FrameRecord::age, kServed, [](Duration age) { return ms_of(age); }),
      figure({"head", "turned since traced view", "deg",
              "The rotation from the view of the newest answer to the shown view.", kByViews},
             &FrameRecord::delta, kServed, [](const PoseDelta& d) { return d.angle_rad * kDegrees; }),
      figure({"head", "moved since traced view", "mm",
              "The distance from the view of the newest answer to the shown view.", kByViews},
             &FrameRecord::delta, kServed, [](const PoseDelta& d) { return d.distance_m * 1e3; }),
      figure({"head", "guard band", "% of pixels",
              "Requested pixels beyond the shown ones, as a share of the shown ones.", kCounted},
             &FrameRecord::guard_band, kWider, [](double share) { return share * 100; })};
}

/// A figure of the comparison with the reference.
Figure error(Side side, FigureText text, ModeSet printed_in, Worse worse, double (*get)(const EyeErrors&)) {
  text.group = "eye";
  text.measured = kByReference;
  return {std::move(text),
          [get, side](const FrameRecord& r) -> Value {
            if (!r.errors || r.start_up) return std::nullopt;
            const EyeErrors& eye = (*r.errors)[index_of(side)];
            const double value = eye.covered == 0 ? kNotMeasured : get(eye);
            return std::isnan(value) ? std::nullopt : Value(value);
          },
          worse, printed_in, side};
}

std::vector<Figure> picture_figures(Side side) {
  const auto percent = [&](const char* name, ModeSet printed_in, const char* meaning,
                           double (*get)(const EyeErrors&)) {
    return error(side, {"", name, "%", meaning, ""}, printed_in, Worse::High, get);
  };
  return {percent("mask error", kDraws,
                  "The mean of |visibility shown - visibility in the reference| over covered pixels x "
                  "lights. Not in modes that show a picture of the server.",
                  [](const EyeErrors& e) { return 100 * e.mask_error; }),
          percent("mask error among known", kInFilesOnly,
                  "The mask error over the pixel-lights that are not unknown.",
                  [](const EyeErrors& e) { return 100 * e.known_error; }),
          percent("mask error unreprojected", kInFilesOnly,
                  "The mask error if the newest mask were shown without reprojection.",
                  [](const EyeErrors& e) { return 100 * e.unmoved_error.value_or(kNotMeasured); }),
          error(side,
                {"", "PSNR", "dB",
                 "Of the shown sRGB picture against the reference picture; 99 dB: equal pictures.", ""},
                kAll, Worse::Low, [](const EyeErrors& e) { return e.psnr_db; }),
          error(side,
                {"", "FLIP", "",
                 "The mean FLIP of the shown picture against the reference picture: what a viewer sees who "
                 "flips between both (Andersson et al. 2020); 0: equal.",
                 ""},
                kAll, Worse::High, [](const EyeErrors& e) { return e.flip; }),
          error(side,
                {"", "SSIM", "",
                 "The mean SSIM of the shown picture and the reference picture (Wang et al. 2004); 1: equal.",
                 ""},
                kAll, Worse::Low, [](const EyeErrors& e) { return e.ssim; })};
}

/// Where the visibility of a pixel-light comes from.
std::vector<Figure> source_figures(Side side) {
  const auto share = [&](const char* name, const char* meaning, double (*get)(const EyeErrors&),
                         Worse worse = Worse::High) {
    return error(side, {"", name, "%", meaning, ""}, kMasks, worse, get);
  };
  return {
      share(
          "from newest mask",
          "Share of covered pixels x lights whose visibility comes from the eye's newest mask. The "
          "newest mask is the newest one that is as complete as it will be. With the next six figures "
          "the shares add up to 100 %.",
          [](const EyeErrors& e) { return 100 * e.newest; }, Worse::Low),
      share("from other eye's newest", "The share that comes from the other eye's newest mask.",
            [](const EyeErrors& e) { return 100 * e.other_eye; }),
      share("from older masks",
            "The share that comes from older masks of either eye, or from a newer one that is not "
            "complete.",
            [](const EyeErrors& e) { return 100 * e.older; }),
      share("from the surround", "The share that comes from the cube mask (docs/cube-mask.md).",
            [](const EyeErrors& e) { return 100 * e.cube_mask; }),
      share("neighbours", "The share that comes from the nearest pixel on the same surface.",
            [](const EyeErrors& e) { return 100 * e.neighbours; }),
      share(
          "own rays",
          "The share of points that the newest mask does not know, for which the client traces its own rays "
          "(docs/edge-rays.md).",
          [](const EyeErrors& e) { return 100 * e.own_rays; }),
      share("unknown", "The share without any source.", [](const EyeErrors& e) { return 100 * e.unknown; }),
      share("stale",
            "The share that is known but outdated: the light or what shadows it has moved since the "
            "trace.",
            [](const EyeErrors& e) { return 100 * e.stale; })};
}

/// Figures that eyes without any surface have, too.
std::vector<Figure> cover_figures(Side side) {
  const std::size_t eye = index_of(side);
  return {
      {{"eye", "other surface", "% of pixels",
        "Pixels in which the rasteriser, in full detail, and the rays of the reference see another surface: "
        "only one of them sees any, or their distances differ by more than 1 %.",
        "In every frame that is compared with the reference."},
       [eye](const FrameRecord& r) -> Value {
         if (!r.errors || std::isnan((*r.errors)[eye].other_surface)) return std::nullopt;
         return 100 * (*r.errors)[eye].other_surface;
       },
       Worse::High,
       kAll,
       side},
      {{"eye", "shows a surface", "% of pixels",
        "Pixels of the eye that show a surface. The other figures of the eye count only these.",
        "In every frame that is compared with the reference."},
       [eye](const FrameRecord& r) -> Value {
         if (!r.errors || std::isnan((*r.errors)[eye].covered)) return std::nullopt;
         return 100 * (*r.errors)[eye].covered;
       },
       Worse::Low,
       kInFilesOnly,
       side},
      {{"eye", "not reached by the picture", "%",
        "Pixels of the eye that the turned picture of the server does not reach.", kCounted},
       [eye](const FrameRecord& r) -> Value { return r.start_up ? std::nullopt : Value(100 * r.black[eye]); },
       Worse::High,
       kPictures,
       side}};
}

void append(std::vector<Figure>& all, std::vector<Figure> part) {
  std::ranges::move(part, std::back_inserter(all));
}

std::vector<Figure> make_figures() {
  std::vector<Figure> all;
  for (auto* part : {&client_figures, &triangle_figures, &server_times, &server_counts, &traffic_figures,
                     &age_and_head_figures})
    append(all, part());
  for (const Side side : kSides)
    for (auto* part : {&picture_figures, &source_figures, &cover_figures}) append(all, part(side));
  return all;
}

const std::array<RunFigure, 8> kRunFigures{{
    {{"run", "frame period", "ms", "The display's time for a frame: the budget of client and server.",
      "1 / --refresh."},
     [](const RunTotals& t) { return ms_of(t.period); }},
    {{"run", "frames", "frames", "Frames that were shown.", "Counted."},
     [](const RunTotals& t) { return static_cast<double>(t.frames); }},
    {{"run", "start-up frames", "frames",
      "Frames that were shown before the first answer. The figures of the eyes exclude them.", "Counted."},
     [](const RunTotals& t) { return static_cast<double>(t.start_up_frames); }},
    {{"run", "missed display times", "display times",
      "Display times that passed before their frame could begin; only with --clock real.", "Counted."},
     [](const RunTotals& t) { return static_cast<double>(t.missed); }},
    {{"run", "silent frames", "frames",
      "Frames that were shown while the server answered nothing. Only the figures of the eyes include them.",
      "Counted from the first request without an answer."},
     [](const RunTotals& t) { return static_cast<double>(t.silent_frames); }},
    {{"run", "silent time", "s", "The time during which the server answered nothing.",
      "By the client's clock."},
     [](const RunTotals& t) { return seconds_of(t.silent); }},
    {{"run", "memory on the device", "B", "The most memory on the graphics device at one time.",
      "Summed over the client's own allocations there."},
     [](const RunTotals& t) { return static_cast<double>(t.memory_bytes); }},
    {{"run", "planned memory", "B", "The plan's estimate of the memory on the device.",
      "Computed before the run; --plan prints its parts."},
     [](const RunTotals& t) { return static_cast<double>(t.planned_memory_bytes); }},
}};

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::string full_name(const FigureText& text) {
  return text.group + " " + text.name;
}

/// `name` in lower case, without the eye's side and without the unit of a column of frames.csv.
std::string plain(const std::string& name) {
  std::string text = lower(name.substr(0, name.find(" [")));
  for (const char* eye : {"left eye ", "right eye "})
    if (text.starts_with(eye)) text.erase(0, text.find("eye"));
  return text;
}

}  // namespace

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : name + ", " + unit;
}

std::string Figure::group() const {
  return side ? std::string(name_of(*side)) + " " + text.group : text.group;
}

const std::vector<Figure>& figures() {
  static const std::vector<Figure> all = make_figures();
  return all;
}

std::span<const RunFigure> run_figures() {
  return kRunFigures;
}

std::vector<FigureText> figure_texts() {
  std::vector<FigureText> texts;
  for (const RunFigure& figure : run_figures()) texts.push_back(figure.text);
  for (const Figure& figure : figures())
    if (figure.side != Side::Right) texts.push_back(figure.text);
  return texts;
}

Expected<std::string> explain(const std::string& name) {
  const std::string wanted = plain(name);
  std::string text;
  std::vector<std::string> names;
  for (const FigureText& figure : figure_texts()) {
    const std::string full = lower(full_name(figure)), alone = lower(figure.name);
    for (const std::string& known : {full, alone}) names.push_back(known);
    if (name.empty())
      text += fmt::format("{:<48}{}\n", with_unit(full_name(figure), figure.unit), figure.meaning);
    else if (wanted == full || wanted == alone)
      text += fmt::format("{}\n  {}\n  {}\n", with_unit(full_name(figure), figure.unit), figure.meaning,
                          figure.measured);
  }
  if (!text.empty()) return text;
  const std::string meant = suggestion(wanted, names);
  return fail(Fault::Missing, fmt::format("there is no figure '{}'{}{} --explain without a name lists them",
                                          name, meant, meant.empty() ? ";" : ""));
}

}  // namespace farshade
