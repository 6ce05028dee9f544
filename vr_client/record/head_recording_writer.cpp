#include "vr_client/record/head_recording_writer.h"

#include <glm/geometric.hpp>

#include "stereo/head/reader.h"
#include "vr_client/ask/request_plan.h"

namespace farshade {

void HeadRecordingWriter::add(Time display_time, const StereoView& views) {
  if (!trace_.samples.empty() && display_time <= trace_.end()) return;
  const Rigid<Stage, Head> head = head_of(views);
  trace_.samples.push_back({display_time, {head.rotation, head.translation}});
  trace_.eye_distance_m =
      glm::length(views[1].stage_from_eye.translation - views[0].stage_from_eye.translation);
  trace_.fov = {views[0].fov, views[1].fov};
}

Expected<void> HeadRecordingWriter::write(const std::filesystem::path& path) const {
  if (trace_.samples.size() < kFewestSamples)
    return fail(Fault::OutOfRange, "a recording of a head needs at least " + std::to_string(kFewestSamples) +
                                       " frames: " + path.string() + " is not written");
  return write_euroc(path, trace_);
}

}  // namespace farshade
