// Head recordings: a text in any of the layouts is refused, or it decodes to a recording that keeps the
// promises of HeadRecording and that reads back bit for bit after it is written in either format.
#include <bit>
#include <cmath>

#include "stereo/head/reader.h"
#include "stereo/head/writer.h"
#include "tests/fuzz/target.h"

using namespace farshade;

namespace {

/// Compares bits, so that a NaN equals itself. -0 equals 0.
bool is_same(double a, double b) {
  return a == b || std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

bool is_same(const Rigid<Recorded, Head>& a, const Rigid<Recorded, Head>& b) {
  const auto& [q, p] = a;
  const auto& [r, s] = b;
  return is_same(q.w, r.w) && is_same(q.x, r.x) && is_same(q.y, r.y) && is_same(q.z, r.z) &&
         is_same(p.x, s.x) && is_same(p.y, s.y) && is_same(p.z, s.z);
}

void check_promises(const HeadRecording& recording) {
  check(recording.samples.size() >= kFewestSamples, "enough samples");
  for (std::size_t i = 0; i < recording.samples.size(); ++i) {
    const auto& [time, head] = recording.samples[i];
    check(i == 0 || recording.samples[i - 1].time < time, "stamps grow");
    check(std::abs(glm::length(head.rotation) - 1.0) < 1e-12, "rotations are unit");
    check(glm::length(head.translation) <= kFarthestHead_m, "heads are near");
  }
  const auto span = recording.end() - recording.start();
  for (const Time time :
       {recording.start(), recording.start() + span / 3, recording.end() - Duration(1), recording.end()}) {
    const auto head = head_at(recording, time);
    check(std::abs(glm::length(head.rotation) - 1.0) < 1e-9, "rotations between samples are unit");
    check(glm::length(head.translation) <= 1.001 * kFarthestHead_m, "heads between samples are near");
  }
}

void check_same(const Expected<HeadRecording>& read, const HeadRecording& recording) {
  check(read.has_value(), "a written recording can be read");
  check_eq(read->samples.size(), recording.samples.size(), "samples");
  for (std::size_t i = 0; i < recording.samples.size(); ++i) {
    check(read->samples[i].time == recording.samples[i].time, "a time comes back");
    check(is_same(read->samples[i].recorded_from_head, recording.samples[i].recorded_from_head),
          "a pose comes back bit for bit");
  }
  check(read->fov == recording.fov && is_same(read->eye_distance_m, recording.eye_distance_m),
        "the headset comes back");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // This name contains a scale, which EyeNavGS files need.
  const auto recording = parse_head_recording(fuzz::text_of(data, size), "eyenavgs_room.csv");
  if (!recording) {
    check(!recording.error().what.empty(), "a refusal says why");
    return 0;
  }
  check(!recording->read_as.empty(), "it is told how a recording is read");
  check_promises(*recording);
  check_same(parse_head_recording(euroc_text(*recording), "a.csv"), *recording);
  check_same(parse_head_recording(tum_text(*recording), "a.txt"), *recording);
  return 0;
}
