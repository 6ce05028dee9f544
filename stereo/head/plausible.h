/// Judges whether samples are those of a head that is worn, makes them upright, and tells in words what was
/// assumed.
#pragma once

#include "stereo/head/samples.h"

namespace farshade {

/// Refuses a sample rate beyond 1 to 10,000 Hz. `better`: a unit of time with a plausible rate, which the
/// refusal names.
[[nodiscard]] Expected<void> check_rate(double rate_hz, const FileFacts& facts, TimeUnit unit,
                                        std::optional<TimeUnit> better);

/// What make_upright did.
struct Uprightness {
  QuaternionOrder order = QuaternionOrder::Wxyz;
  std::string doubt{};  ///< also that they were levelled; empty: the heads stand and walk as heads do
};

/// Gives the samples the axes of the stage, and levels them if nobody has stated the axes and they look
/// around widely. If nobody has stated the order of the quaternions, the file does not state its axes, and
/// only with the other order the head is upright (with given axes, also: walks ahead), takes that one.
[[nodiscard]] Uprightness make_upright(std::vector<HeadSample>& samples, const FileFacts& facts,
                                       const HeadFileOptions& options);

/// Why `stamps`, as they are in the file, may be frame numbers, or positions something else than metres.
/// Empty: they are plausible.
[[nodiscard]] std::string doubt_about_units(const std::vector<HeadSample>& samples,
                                            const std::vector<double>& stamps);

/// The sentence `HeadRecording::read_as`.
[[nodiscard]] std::string read_as(const HeadRecording& recording, const FileFacts& facts,
                                  const HeadFileOptions& options, TimeUnit unit, const Uprightness& upright);

}  // namespace farshade
