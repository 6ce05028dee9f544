/// Replay: repeats a captured run. It supplies the runtime, the link and the settings of each frame from the
/// capture file, and compares the requests and pictures of the replay with the captured ones. The same
/// program with the same scene on the same device gives the same bits. The replay does not depend on
/// wall-clock time.
#pragma once

#include "vr_client/record/capture_link.h"
#include "vr_client/record/capture_reader.h"

namespace farshade {

/// The first difference between a replay and its capture.
struct ReplayDifference {
  FrameId frame;
  std::string what;
};

struct ReplayVerdict {
  std::uint32_t frames = 0;  ///< replayed
  std::optional<ReplayDifference> first;
};

/// "312 frames, all requests and pictures as captured", or the first difference and its frame.
[[nodiscard]] std::string to_string(const ReplayVerdict& verdict);

class Replay final : public Runtime {
 public:
  /// `report` replaces the captured setting; it changes no picture. The run must be configured as the
  /// reader's header states. The object must not move.
  Replay(CaptureReader reader, ShadingPass::Report report);

  /// Returns nothing at the end of the file.
  [[nodiscard]] std::optional<FrameTiming> wait_frame() override;
  /// The captured views of the current frame, whatever the time.
  [[nodiscard]] StereoView locate_views(Time display_time) const override;
  void end_frame(Time) override {}

  /// Null if the captured run had no server.
  [[nodiscard]] AnswerLink* link() { return link_ ? &*link_ : nullptr; }
  [[nodiscard]] const FrameSettings& settings() const { return settings_; }

  /// Compares the current frame, which was shown as these pictures.
  void watch(const FrameView& view, const PerEye<Image<Rgb8>>& shown);

  /// The result so far. An error if the file could not be read to its end.
  [[nodiscard]] Expected<ReplayVerdict> verdict() const;

 private:
  CaptureReader reader_;
  ShadingPass::Report report_;
  std::optional<CaptureLink> link_;
  CapturedFrame frame_;
  FrameSettings settings_;
  ReplayVerdict verdict_;
  std::optional<Error> error_;
};

}  // namespace farshade
