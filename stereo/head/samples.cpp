#include "stereo/head/samples.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "stereo/head/reader.h"

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

}  // namespace

Expected<void> SampleList::add(rows::Place place, std::int64_t stamp_ns, const glm::dvec3& position,
                               const glm::dquat& rotation) {
  const double norm = glm::length(rotation), off_unit = std::abs(norm - 1.0);
  if (!(off_unit <= kUnitTolerance))
    return rows::fail_at(place, Fault::Malformed,
                         "quaternion has length " + std::to_string(norm) + " instead of 1");
  const glm::dvec3 position_m = position / units_a_metre_;
  if (!(glm::length(position_m) <= kFarthestHead_m))
    return rows::fail_at(place, Fault::OutOfRange, "head is more than 1e9 m from the origin");
  // A rotation that is unit up to rounding stays unchanged, so that a written recording reads back bit for
  // bit.
  recording_.samples.push_back(
      {time_from_ns(stamp_ns), {off_unit < 1e-15 ? rotation : rotation / norm, position_m}});
  return {};
}

Expected<HeadRecording> SampleList::finish(std::string_view file, double eye_distance_m,
                                           const PerEye<EyeFov>& fov) && {
  const std::string name(file);
  const std::size_t rows = recording_.samples.size();
  keep_growing(recording_.samples);
  recording_.rows_left_out = rows - recording_.samples.size();
  if (recording_.samples.size() < kFewestSamples)
    return fail(Fault::Malformed, name + ": holds " + std::to_string(recording_.samples.size()) +
                                      " head samples in time order, at least " +
                                      std::to_string(kFewestSamples) + " are needed");
  if (!(eye_distance_m >= 0.0 && eye_distance_m <= 1.0))
    return fail(Fault::OutOfRange,
                name + ": eye distance of " + std::to_string(eye_distance_m) + " m is outside 0..1 m");
  for (const Side side : kSides)
    if (!is_valid(fov[index_of(side)]))
      return fail(Fault::OutOfRange,
                  name + ": fov of the " + name_of(side) + " eye is empty or beyond 89.5 degrees");
  recording_.eye_distance_m = eye_distance_m;
  recording_.fov = fov;
  return std::move(recording_);
}

}  // namespace farshade
