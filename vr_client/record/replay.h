/// Replay: a session on file, shown again. It is the runtime, the link and the steering of a session whose
/// frames are those of the file, and it compares what that session asks and shows with what was asked and
/// shown. Same program, same scene, same device: the same bits. Time plays no part.
#pragma once

#include "vr_client/record/capture_link.h"
#include "vr_client/record/capture_reader.h"

namespace farshade {

/// Where a replay first is not what was recorded.
struct ReplayDifference {
  FrameId frame;
  std::string what;
};

struct ReplayVerdict {
  std::uint32_t frames = 0;  ///< replayed
  std::optional<ReplayDifference> first;
};

/// "312 frames, all requests and pictures as recorded", or what first differs, and in which frame.
[[nodiscard]] std::string to_string(const ReplayVerdict& verdict);

class Replay final : public Runtime {
 public:
  /// `report`: what the session is steered to report, which changes no picture. The session must have what
  /// the reader's header says. Stays where it is.
  Replay(CaptureReader reader, ShadingPass::Report report);

  /// Ends with the file.
  [[nodiscard]] std::optional<FrameTiming> wait_frame() override;
  /// As recorded for the frame at hand, whatever the time.
  [[nodiscard]] StereoView locate_views(Time display_time) const override;
  void end_frame(Time) override {}

  /// Null if the session had none.
  [[nodiscard]] AnswerLink* link() { return link_ ? &*link_ : nullptr; }
  [[nodiscard]] const FrameSettings& steering() const { return steering_; }

  /// The frame at hand was shown as these pictures.
  void watch(const FrameView& view, const PerEye<Image<Rgb8>>& shown);

  /// What came of it so far; the error if the file could not be read to its end.
  [[nodiscard]] Expected<ReplayVerdict> verdict() const;

 private:
  CaptureReader reader_;
  ShadingPass::Report report_;
  std::optional<CaptureLink> link_;
  CapturedFrame frame_;
  FrameSettings steering_;
  ReplayVerdict verdict_;
  std::optional<Error> error_;
};

}  // namespace farshade
