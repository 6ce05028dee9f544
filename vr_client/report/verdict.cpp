#include "vr_client/report/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "stereo/base/quantile.h"
#include "stereo/net/rate_control.h"

namespace farshade {
namespace {

constexpr double kFewLate = 0.01, kMostInside = 0.5;

/// In as many frames an answer comes, also at 120 Hz over a path of 100 ms.
constexpr std::size_t kEnoughFrames = 60;

const Figure& figure_of(const std::string& group, const std::string& name) {
  return *std::ranges::find_if(
      figures(), [&](const Figure& figure) { return figure.group() == group && figure.text.name == name; });
}

std::optional<Spread> spread_of(const FrameLog& log, const std::string& group, const std::string& name) {
  const Figure& figure = figure_of(group, name);
  const std::vector<double> values = log.values(figure);
  if (values.empty()) return std::nullopt;
  return spread_toward(figure.worse, values);
}

std::optional<TimeUse> time_use(const FrameLog& log, const std::string& group, const RunTotals& totals,
                                double frames) {
  const std::vector<double> values = log.values(figure_of(group, "frame"));
  if (values.empty()) return std::nullopt;
  const double budget_ms = ms_of(totals.period) * frames;
  const auto late = std::ranges::count_if(values, [&](double ms) { return ms > budget_ms; });
  return TimeUse{quantile(values, 0.5), budget_ms,
                 static_cast<double>(late) / static_cast<double>(values.size()), frames};
}

/// Display frames for each request. The server has so much time for an answer.
double frames_per_request(const FrameLog& log) {
  const auto& records = log.records();
  const auto requested = [](const FrameRecord& record) {
    return !record.silent && record.requested.has_value();
  };
  const auto loud = std::ranges::count(records, false, &FrameRecord::silent);
  const auto requests = std::ranges::count_if(records, requested);
  return requests == 0 ? 1 : static_cast<double>(loud) / static_cast<double>(requests);
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

std::optional<ByteUse> byte_use(const FrameLog& log, const RunTotals& totals) {
  const std::vector<double> down = log.values(figure_of("wire", "bytes down a frame"));
  if (down.empty()) return std::nullopt;
  const double mbit_per_byte = 8e-6 / seconds_of(totals.period);
  ByteUse use;
  use.down_bytes = mean_of(down);
  use.up_bytes = mean_of(log.values(figure_of("wire", "bytes up a frame")));
  use.down_mbit_s = use.down_bytes * mbit_per_byte;
  use.up_mbit_s = use.up_bytes * mbit_per_byte;
  std::vector<double> rates = log.values(figure_of("wire", "rate of the path"));
  std::erase(rates, RateControl::kStart * 8e-6);  // until something is measured
  if (!rates.empty()) use.path = PathRate{.down_mbit_s = quantile(rates, 0.5)};
  use.is_stated = totals.stated_path.has_value();
  if (use.is_stated) use.path = totals.stated_path;
  if (const auto size = spread_of(log, "wire", "size of requested views"))
    use.view_size_percent = size->median;
  return use;
}

std::string not_measured(const RunTotals& totals) {
  if (totals.start_up_frames == totals.frames && totals.frames > 0)
    return fmt::format("not measured: no frame has shown an answer of the server{}",
                       totals.frames < kEnoughFrames
                           ? fmt::format("; {} are few, use --frames {}", totals.frames, kEnoughFrames)
                           : "");
  const std::string none = "not measured: no frame was compared with a full trace";
  if (totals.reference_every == 0) return none + "; --reference-every 8 compares every 8th";
  return none + fmt::format(", which happens every {} frames: use --frames {} or more",
                            totals.reference_every,
                            totals.start_up_frames + std::size_t{2} * totals.reference_every);
}

std::string picture_in_words(const std::optional<PictureError>& picture, const RunTotals& totals) {
  if (totals.inside_share > kMostInside)
    return fmt::format(
        "INVALID: the head is inside geometry in {:.0f} % of its poses; the cure is --stand X,Y,Z or, for a "
        "recorded head, --place fit",
        100 * totals.inside_share);
  if (!picture) return not_measured(totals);
  const Spread& psnr = picture->psnr_db;
  if (psnr.p99 >= kEqualPictures_dB) return "equal to a full trace";
  std::string text = fmt::format("PSNR {:.1f} dB against a full trace, {:.1f} dB in the worst 1 % of frames",
                                 psnr.median, psnr.p99);
  text += fmt::format("; FLIP {:.3f}, SSIM {:.3f}", picture->flip, picture->ssim);
  if (const auto& error = picture->mask_error_percent)
    text += fmt::format("; mask error {:.2f} %, {:.2f} % in the worst 1 %", error->median, error->p99);
  return text + fmt::format(" ({} eye, the worse one)", name_of(picture->eye));
}

std::string rate_in_words(double per_second) {
  return fmt::format("{:.{}f}", per_second, per_second < 10 ? 1 : 0);
}

double rate_of(const TimeUse& use) {
  return 1e3 / use.median_ms;
}

/// "fits", or what is wrong, if not the median.
std::string within_in_words(const TimeUse& use) {
  return use.budget() == Budget::Kept
             ? "fits"
             : fmt::format("too slow in {:.0f} % of frames", std::max(100 * use.late_share, 1.0));
}

/// How fast smaller pictures would be, if the time is proportional to their side: a part of it does not
/// depend on the number of pixels. (The demo on lavapipe: 14, 25 and 44 frames a second at 512, 256 and 128
/// pixels.) The largest that reach most of the display's rate. Empty without a size.
std::string advice(const TimeUse& use, const RunTotals& totals) {
  constexpr std::uint32_t kLeastSide_px = 64;
  constexpr double kMost = 0.6;
  const double wanted = 1e3 / use.budget_ms;
  Extent size = totals.eye_size;
  double rate = rate_of(use);
  while (rate < kMost * wanted && std::min(size.width, size.height) >= 2 * kLeastSide_px)
    size = {size.width / 2, size.height / 2}, rate *= 2;
  if (size == totals.eye_size) return "";
  return fmt::format("; --size {}x{} would have about {} (an estimate)", size.width, size.height,
                     rate_in_words(std::min(rate, wanted)));
}

std::string client_in_words(const TimeUse& use, const RunTotals& totals) {
  if (use.budget() != Budget::Exceeded)
    return fmt::format("client {:.1f} ms of {:.1f} ms a frame: {}", use.median_ms, use.budget_ms,
                       within_in_words(use));
  const Extent size = totals.eye_size;
  return fmt::format(
      "{}{} frames a second{}, the display has {:g}{}",
      totals.cpu_draws ? "without a GPU the CPU draws: " : "client: ", rate_in_words(rate_of(use)),
      size.pixels() > 0 ? fmt::format(" at {}x{}", size.width, size.height) : "",
      std::round(1e4 / use.budget_ms) * 0.1, advice(use, totals));
}

std::string server_in_words(const TimeUse& use) {
  if (use.budget() != Budget::Exceeded)
    return fmt::format("server {:.1f} ms of {:.1f} ms a {}: {}", use.median_ms, use.budget_ms,
                       use.frames > 1 ? "request" : "frame", within_in_words(use));
  return fmt::format("server: {} answers a second, {:g} were requested; --mask-every {:.0f} requests as many",
                     rate_in_words(rate_of(use)), std::round(1e4 / use.budget_ms) * 0.1,
                     std::ceil(use.frames * use.median_ms / use.budget_ms));
}

std::string bytes_in_words(const ByteUse& use, const RunTotals& totals) {
  std::string text = fmt::format(
      "{:.1f} kB down and {:.1f} kB up a frame: {:.1f} and {:.1f} Mbit/s at {:g} Hz", use.down_bytes * 1e-3,
      use.up_bytes * 1e-3, use.down_mbit_s, use.up_mbit_s, std::round(1e5 / ms_of(totals.period)) * 1e-2);
  if (!use.path)
    return text + "; the rate of the path was not measured: the run sent too little; --path-rate states it";
  const PathRate path = *use.path;
  text += fmt::format(" of {:g}", use.is_stated ? path.down_mbit_s : std::round(path.down_mbit_s));
  if (path.up_mbit_s) text += fmt::format(" and {:g}", *path.up_mbit_s);
  text += fmt::format(" Mbit/s that {}: {}",
                      use.is_stated ? "--path-rate states" : "the path was measured to carry down",
                      use.budget() == Budget::Kept ? "fits" : "does not fit");
  if (!path.up_mbit_s && use.up_mbit_s > path.down_mbit_s) text += ", if it carries no more up";
  if (use.view_size_percent < 100)
    text += fmt::format(", the server asks for {:.0f} % of the width", use.view_size_percent);
  return text;
}

}  // namespace

std::optional<PictureError> picture_error(const FrameLog& log) {
  std::optional<PictureError> worse;
  for (const Side side : kSides) {
    const std::string eye = std::string(name_of(side)) + " eye";
    const auto median = [&](const char* name) { return spread_of(log, eye, name).value_or(Spread{}).median; };
    const std::optional<Spread> psnr = spread_of(log, eye, "PSNR");
    if (psnr && (!worse || psnr->median < worse->psnr_db.median))
      worse = {side, *psnr, median("FLIP"), median("SSIM"), spread_of(log, eye, "mask error")};
  }
  return worse;
}

Budget TimeUse::budget() const {
  if (late_share <= kFewLate) return Budget::Kept;
  return median_ms <= budget_ms ? Budget::OftenKept : Budget::Exceeded;
}

Budget ByteUse::budget() const {
  const bool is_carried =
      !path || (down_mbit_s <= path->down_mbit_s && up_mbit_s <= path->up_mbit_s.value_or(path->down_mbit_s));
  return is_carried && view_size_percent >= 100 ? Budget::Kept : Budget::Exceeded;
}

bool Verdict::fits() const {
  const auto each = [](const auto& use) { return !use || use->budget() == Budget::Kept; };
  return is_valid && each(client) && each(server) && each(bytes) && missed_share <= kFewLate;
}

Verdict verdict_of(const FrameLog& log, const RunTotals& totals) {
  const auto display_times = static_cast<double>(totals.frames + totals.missed);
  return {.picture = picture_error(log),
          .client = time_use(log, "client", totals, 1),
          .server = time_use(log, "server", totals, frames_per_request(log)),
          .bytes = byte_use(log, totals),
          .missed_share = totals.missed == 0 ? 0 : static_cast<double>(totals.missed) / display_times,
          .is_valid = totals.inside_share <= kMostInside};
}

std::string in_words(const Verdict& verdict, const RunTotals& totals) {
  std::string time = "no frame was shown";
  if (verdict.client) time = client_in_words(*verdict.client, totals);
  if (verdict.server) time += "; " + server_in_words(*verdict.server);
  if (totals.missed > 0)
    time += fmt::format("; {} of {} display times were missed", totals.missed, totals.frames + totals.missed);
  return fmt::format("picture: {}\ntime: {}\nbytes: {}\n", picture_in_words(verdict.picture, totals), time,
                     verdict.bytes ? bytes_in_words(*verdict.bytes, totals) : "no network was used");
}

}  // namespace farshade
