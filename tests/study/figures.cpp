#include "tests/study/figures.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "stereo/base/check.h"
#include "stereo/reproject/reprojection.h"

namespace farshade::study {
namespace {

constexpr const char* kGroupNames[] = {"error", "wire", "time"};

/// Rounds to nine digits, which keeps the files short.
double rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return std::strtod(text, nullptr);
}

std::span<const FrameRecord> after(const Played& played, std::uint32_t warm_up) {
  const std::span<const FrameRecord> all = played.log.records();
  return all.subspan(std::min<std::size_t>(warm_up, all.size()));
}

/// The server's reports on requests after frame `warm_up`.
std::vector<FrameReport> reports_after(const Played& played, std::uint32_t warm_up) {
  std::vector<FrameReport> reports;
  for (const FrameReport& report : played.reports)
    if (is_newer(report.frame, FrameId{warm_up})) reports.push_back(report);
  return reports;
}

/// True if the client compiled a pipeline in frame `i`.
bool compiled_pipeline(std::span<const PlayedFrame> frames, std::size_t i) {
  return i < frames.size() && frames[i].pipelines != (i == 0 ? 0 : frames[i - 1].pipelines);
}

/// Adds the errors of one frame: those of the worse eye.
void add_eye_errors(const PerEye<EyeErrors>& eyes, Figures& figures) {
  const auto add = [&](const char* name, double EyeErrors::*figure, double unit = 100,
                       Worse worse = Worse::High) {
    const double left = eyes[0].*figure, right = eyes[1].*figure;
    if (std::isnan(left) || std::isnan(right)) return;  // pictures that are not shaded have no masks
    figures.add(Group::Error, name,
                unit * (worse == Worse::High ? std::max(left, right) : std::min(left, right)), worse);
  };
  add("mask_error", &EyeErrors::mask_error);
  add("psnr", &EyeErrors::psnr_db, 1, Worse::Low);
  add("flip", &EyeErrors::flip, 1);
  add("ssim", &EyeErrors::ssim, 1, Worse::Low);
  add("other_surface", &EyeErrors::other_surface);
  add("from_newest", &EyeErrors::newest, 100, Worse::Low);
  add("from_other_eye", &EyeErrors::other_eye);
  add("from_older", &EyeErrors::older);
  add("from_surround", &EyeErrors::cube_mask);
  add("from_neighbours", &EyeErrors::neighbours);
  add("unknown", &EyeErrors::unknown);
  add("stale", &EyeErrors::stale);
  if (const double unknown = std::max(eyes[0].unknown, eyes[1].unknown); !std::isnan(unknown))
    figures.add(Group::Error, "known", 100 * (1 - unknown), Worse::Low);
}

void add_report(const FrameReport& report, Figures& figures) {
  figures.add(Group::Wire, "answer_bytes", report.payload_bytes);
  figures.add(Group::Wire, "answer_datagrams", report.slices + 1.0);
  figures.add(Group::Wire, "primary_rays", static_cast<double>(report.primary_rays));
  figures.add(Group::Wire, "shadow_rays", static_cast<double>(report.shadow_rays));
  if (report.full_shadow_rays > 0)
    figures.add(Group::Wire, "rays_of_full",
                100 * static_cast<double>(report.shadow_rays) / static_cast<double>(report.full_shadow_rays));
}

}  // namespace

void Figures::add(Group group, const std::string& name, double value, Worse worse) {
  Values& values = groups_[group].try_emplace(name, Values{worse, {}}).first->second;
  values.values.push_back(value);
}

nlohmann::json Figures::json() const {
  nlohmann::json all = nlohmann::json::object();
  for (const auto& [group, figures] : groups_)
    for (const auto& [name, figure] : figures) {
      const bool low = figure.worse == Worse::Low;
      all[kGroupNames[static_cast<std::size_t>(group)]][name] = {
          {"median", rounded(quantile(figure.values, 0.5))},
          {"p95", rounded(quantile(figure.values, low ? 0.05 : 0.95))},
          {"p99", rounded(quantile(figure.values, low ? 0.01 : 0.99))},
          {"count", figure.values.size()}};
    }
  return all;
}

LinkModel awaited(Mode mode, const LinkModel& each_way) {
  return answers_for(mode) == 0 ? LinkModel{} : each_way;
}

std::uint32_t round_trip_frames(const LinkModel& each_way, double refresh_hz) {
  return static_cast<std::uint32_t>(std::ceil(2 * seconds_of(each_way.delay + each_way.jitter) * refresh_hz));
}

std::uint32_t warm_up_frames(const LinkModel& each_way, double refresh_hz) {
  const double apart = std::max(std::round(seconds_of(kStillInterval) * refresh_hz), 1.0);
  return round_trip_frames(each_way, refresh_hz) +
         narrow<std::uint32_t>(kMaxMasks) * static_cast<std::uint32_t>(apart);
}

std::uint32_t first_timed_frame(const Played& played, std::uint32_t warm_up) {
  const std::vector<FrameRecord>& records = played.log.records();
  const auto first = std::ranges::find(records, false, &FrameRecord::start_up);
  return narrow<std::uint32_t>(
      std::min<std::ptrdiff_t>(first - records.begin() + warm_up, std::ssize(records)));
}

void add_times(const Played& played, std::uint32_t first, Figures& figures) {
  const auto add = [&](const char* name, Duration time) { figures.add(Group::Time, name, ms_of(time)); };
  for (std::size_t i = first; i < played.log.records().size(); ++i) {
    if (compiled_pipeline(played.frames, i)) continue;
    const StageTimes& client = played.log.records()[i].times;
    add("client_frame", client.frame);
    add("client_request", client.request);
    add("client_collect", client.collect);
    add("client_draw", client.total);
    add("client_gbuffer", client.gbuffer);
    add("client_depth", client.depth);
    add("client_maps", client.maps);
    add("client_shade", client.shade);
    add("client_carry", client.request_reprojection);
    add("client_turn", client.timewarp);
  }
  for (const FrameReport& server : reports_after(played, first)) {
    add("server_frame", total_work(server));
    add("server_primary", server.primary);
    add("server_shadow", server.shadow);
    add("server_draw", server.draw);
    add("server_pack", server.pack);
  }
}

void add_errors(const Played& played, std::uint32_t warm_up, Figures& figures) {
  for (const FrameRecord& record : after(played, warm_up)) {
    if (record.start_up) continue;
    figures.add(Group::Wire, "staleness", record.delta ? ms_of(record.delta->age) : 0.0);
    figures.add(Group::Wire, "latency", ms_of(record.age.value_or(Duration::zero())));
    figures.add(Group::Error, "black", 100 * std::max(record.black[0], record.black[1]));
    if (record.errors) add_eye_errors(*record.errors, figures);
  }
  for (const FrameReport& report : reports_after(played, warm_up)) add_report(report, figures);
  // Bytes and datagrams of the whole run, handshake and reports included, per frame shown. For a mode that
  // requests nothing, the handshake does not count.
  const double frames = static_cast<double>(played.log.records().size());
  const auto share = [&](const char* name, std::uint64_t count) {
    figures.add(Group::Wire, name, played.server.frames == 0 ? 0 : static_cast<double>(count) / frames);
  };
  share("down_bytes", played.server.port.sent_bytes);
  share("down_datagrams", played.server.port.sent);
  share("up_bytes", played.client.port.sent_bytes);
  share("up_datagrams", played.client.port.sent);
  share("answers", played.server.frames);
}

}  // namespace farshade::study
