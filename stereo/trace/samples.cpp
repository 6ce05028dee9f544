#include "stereo/trace/samples.h"

#include <cmath>

#include "stereo/trace/reader.h"

namespace farshade {

Expected<void> SampleList::add(rows::Place place, std::int64_t stamp_ns, const glm::dvec3& position,
                               const glm::dquat& rotation) {
  const Time time = time_from_ns(stamp_ns);
  if (!trace_.samples.empty() && time < trace_.end())
    return rows::fail_at(
        place, Fault::Malformed,
        "time stamp lies " + std::to_string(ms_of(trace_.end() - time)) + " ms before the last one");
  const double norm = glm::length(rotation), off_unit = std::abs(norm - 1.0);
  if (!(off_unit <= kUnitTolerance))
    return rows::fail_at(place, Fault::Malformed,
                         "quaternion has length " + std::to_string(norm) + " instead of 1");
  const glm::dvec3 position_m = position / units_a_metre_;
  if (!(glm::length(position_m) <= kFarthestHead_m))
    return rows::fail_at(place, Fault::OutOfRange, "head is more than 1e9 m from the origin");
  if (!trace_.samples.empty() && time == trace_.end()) {
    ++trace_.repeated_stamps;
    return {};
  }
  // Unit as far as doubles can be: kept as it is, so that what was written reads back bit for bit.
  trace_.samples.push_back({time, {off_unit < 1e-15 ? rotation : rotation / norm, position_m}});
  return {};
}

Expected<HeadTrace> SampleList::finish(std::string_view file, double eye_distance_m,
                                       const PerEye<EyeFov>& fov) && {
  const std::string name(file);
  if (trace_.samples.size() < kFewestSamples)
    return fail(Fault::Malformed, name + ": holds " + std::to_string(trace_.samples.size()) +
                                      " head samples, at least " + std::to_string(kFewestSamples) +
                                      " are needed");
  if (!(eye_distance_m >= 0.0 && eye_distance_m <= 1.0))
    return fail(Fault::OutOfRange,
                name + ": eye distance of " + std::to_string(eye_distance_m) + " m is outside 0..1 m");
  for (const Side side : kSides)
    if (!is_valid(fov[index_of(side)]))
      return fail(Fault::OutOfRange,
                  name + ": fov of the " + name_of(side) + " eye is empty or beyond 89.5 degrees");
  trace_.eye_distance_m = eye_distance_m;
  trace_.fov = fov;
  return std::move(trace_);
}

}  // namespace farshade
