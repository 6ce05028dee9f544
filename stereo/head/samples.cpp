#include "stereo/head/samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "stereo/head/plausible.h"

namespace farshade {
namespace {

/// Keeps the longest subsequence with increasing stamps, so that one stamp that is too late removes one
/// sample, not all samples after it. Of equal stamps, the first is kept. Algorithm: patience sorting (M. L.
/// Fredman, "On computing the length of longest increasing subsequences", 1975).
void keep_growing(std::vector<HeadSample>& samples) {
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t>
      last_of_length;  // the sample with the smallest stamp that ends a subsequence of that length
  std::vector<std::size_t> before(samples.size(), kNone);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto at = std::ranges::lower_bound(last_of_length, samples[i].time, {},
                                             [&](std::size_t sample) { return samples[sample].time; });
    if (at != last_of_length.begin()) before[i] = *std::prev(at);
    if (at == last_of_length.end())
      last_of_length.push_back(i);
    else if (samples[i].time < samples[*at].time)
      *at = i;
  }
  std::size_t kept = last_of_length.size();
  std::vector<HeadSample> growing(kept);
  for (std::size_t i = kept > 0 ? last_of_length.back() : kNone; i != kNone; i = before[i])
    growing[--kept] = samples[i];
  samples = std::move(growing);
}

double median_hz(const std::vector<HeadSample>& samples) {
  std::vector<double> stamps;
  for (const HeadSample& sample : samples) stamps.push_back(static_cast<double>(ns_of(sample.time)));
  return rate_hz(stamps, TimeUnit::Nanoseconds);
}

Expected<void> check_headset(const FileFacts& facts) {
  if (!(facts.eye_distance_m >= 0.0 && facts.eye_distance_m <= 1.0))
    return fail(Fault::OutOfRange, fmt::format("{}: eye distance of {:f} m is outside 0..1 m", facts.file,
                                               facts.eye_distance_m));
  for (const Side side : kSides)
    if (!is_valid(facts.fov[index_of(side)]))
      return fail(Fault::OutOfRange, fmt::format("{}: fov of the {} eye is empty or beyond 89.5 degrees",
                                                 facts.file, name_of(side)));
  return {};
}

}  // namespace

std::string SampleList::dropped_rows(std::size_t all) const {
  if (bad_ + backward_ == 0) return {};
  std::string words = fmt::format("left out {} of {} rows ({:.1f} %):", bad_ + backward_, all,
                                  100.0 * static_cast<double>(bad_ + backward_) / static_cast<double>(all));
  if (bad_ > 0)
    words += fmt::format(" {} without a pose (the first is {}){}", bad_, first_bad_->what,
                         backward_ > 0 ? "," : "");
  if (backward_ > 0) words += fmt::format(" {} with a time stamp that repeats or runs backwards", backward_);
  return words;
}

void SampleList::leave_out(Error why) {
  ++bad_;
  if (!first_bad_) first_bad_ = std::move(why);
}

Expected<void> SampleList::add(rows::Place place, std::string_view stamp, const glm::dvec3& position,
                               const glm::dquat& rotation) {
  const Expected<double> time = rows::number(stamp, place);
  if (!time) return tl::unexpected(time.error());
  const double norm = glm::length(rotation), off_unit = std::abs(norm - 1.0);
  if (!(off_unit <= kUnitTolerance))
    return rows::fail_at(place, Fault::Malformed,
                         "quaternion has length " + std::to_string(norm) + " instead of 1");
  // A rotation that is unit up to rounding stays unchanged, so that a written recording reads back bit for
  // bit.
  rows_.push_back({place.line, stamp, {off_unit < 1e-15 ? rotation : rotation / norm, position}});
  stamps_.push_back(*time);
  return {};
}

Expected<std::vector<HeadSample>> SampleList::timed(const FileFacts& facts, TimeUnit unit) {
  std::vector<HeadSample> samples;
  for (const auto& [line, stamp, pose] : rows_) {
    const rows::Place place{facts.file, line};
    const Expected<std::int64_t> ns = rows::nanoseconds(stamp, static_cast<int>(unit), place);
    const glm::dvec3 position_m = pose.translation / facts.units_a_metre;
    if (!ns)
      leave_out(ns.error());
    else if (!(glm::length(position_m) <= kFarthestHead_m))
      leave_out(rows::fail_at(place, Fault::OutOfRange, "head is more than 1e9 m from the origin").value());
    else
      samples.push_back({time_from_ns(*ns), {pose.rotation, position_m}});
  }
  const std::size_t rows = samples.size(), all = rows + bad_;
  keep_growing(samples);
  backward_ = rows - samples.size();
  const std::string bad =
      first_bad_ ? fmt::format("{} of {} rows hold no pose, the first is {}", bad_, all, first_bad_->what)
                 : std::string();
  if (samples.size() < kFewestSamples)
    return fail(first_bad_ ? first_bad_->fault : Fault::Malformed,
                fmt::format("{}: holds {} head samples in time order, at least {} are needed{}{}", facts.file,
                            samples.size(), kFewestSamples, bad.empty() ? "" : "; ", bad));
  if (2 * bad_ > all) return fail(Fault::Malformed, fmt::format("{}: {}", facts.file, bad));
  return samples;
}

Expected<HeadRecording> SampleList::finish(const FileFacts& facts, const HeadFileOptions& options) && {
  const std::optional<TimeUnit> plausible = unit_of(stamps_, facts.usual_unit);
  const std::optional<TimeUnit> known = options.unit ? options.unit : facts.unit;
  const TimeUnit unit = known ? *known : plausible.value_or(facts.usual_unit);
  Expected<std::vector<HeadSample>> samples = timed(facts, unit);
  // A wrong unit of time may be the reason that most stamps repeat.
  const double hz = samples ? median_hz(*samples) : rate_hz(stamps_, unit);
  if (hz > 0 && (samples || 2 * backward_ > rows_.size()))
    if (const Expected<void> sound = check_rate(hz, facts, unit, plausible); !sound)
      return tl::unexpected(sound.error());
  if (!samples) return tl::unexpected(samples.error());
  HeadRecording recording{.samples = std::move(*samples),
                          .eye_distance_m = facts.eye_distance_m,
                          .fov = facts.fov,
                          .rows_left_out = backward_,
                          .bad_rows = bad_,
                          .read_as = {},
                          .doubt = {}};
  if (const Expected<void> sound = check_headset(facts); !sound) return tl::unexpected(sound.error());
  const Uprightness upright = make_upright(recording.samples, facts, options);
  recording.read_as = read_as(recording, facts, options, unit, upright);
  for (const std::string& doubt : {dropped_rows(recording.samples.size() + backward_ + bad_), upright.doubt,
                                   doubt_about_units(recording.samples, stamps_)})
    if (!doubt.empty()) recording.doubt.append(recording.doubt.empty() ? "" : "; ").append(doubt);
  return recording;
}

}  // namespace farshade
