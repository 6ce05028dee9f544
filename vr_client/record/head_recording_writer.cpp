#include "vr_client/record/head_recording_writer.h"

#include <glm/geometric.hpp>

#include "stereo/head/reader.h"
#include "vr_client/ask/request_plan.h"

namespace farshade {

void HeadRecordingWriter::add(Time display_time, const StereoView& views) {
  if (!recording_.samples.empty() && display_time <= recording_.end()) return;
  const Rigid<Stage, Head> head = head_of(views);
  recording_.samples.push_back({display_time, {head.rotation, head.translation}});
  recording_.eye_distance_m =
      glm::length(views[1].stage_from_eye.translation - views[0].stage_from_eye.translation);
  recording_.fov = {views[0].fov, views[1].fov};
}

Expected<void> HeadRecordingWriter::write(const std::filesystem::path& path) const {
  if (recording_.samples.size() < kFewestSamples)
    return fail(Fault::OutOfRange, "a head recording needs at least " + std::to_string(kFewestSamples) +
                                       " frames; " + path.string() + " was not written");
  return write_euroc(path, recording_);
}

}  // namespace farshade
