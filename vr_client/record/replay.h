/// Replay: repeats a captured run. It supplies the runtime, the link and the settings of each frame from the
/// capture file, and compares the requests and pictures of the replay with the captured ones. The same
/// program with the same scene on the same device gives the same bits. The replay does not depend on
/// wall-clock time.
#pragma once

#include "stereo/link/server_connection.h"
#include "vr_client/record/capture_reader.h"

namespace farshade {

/// Replays the messages of a capture. Each message arrives in the same frame as in the captured run, and
/// before or after the request as it did then. The link compares the requests of the replay with the captured
/// ones. It never waits.
class CaptureLink final : public ServerConnection {
 public:
  explicit CaptureLink(const CaptureHeader& header) : receiver_(header.requests, MaskLayout{header.lights}) {}

  /// Begins a frame. `frame` must live until the next call.
  void begin(const CapturedFrame& frame);

  /// Ends the current frame. Returns how its request differs from the captured one; nothing if they are
  /// equal.
  [[nodiscard]] std::optional<std::string> end();

  /// As with a NetworkLink, no request is sent before the first Welcome. The frame that received the Welcome
  /// may or may not have sent one.
  void request(const FrameRequest& request, Time requested_at, const RequestParts& parts = {}) override;

  /// Takes all messages of the current frame, whatever the timeout.
  bool wait_for(FrameId frame, Duration timeout) override;

  [[nodiscard]] bool takes_parts() const override { return false; }
  [[nodiscard]] const FrameReceiver& receiver() const override { return receiver_; }
  [[nodiscard]] const std::optional<Error>& refused() const override { return refused_; }
  [[nodiscard]] Duration busy() const override { return busy_; }

 private:
  void take(std::span<const CapturedMessage> messages);

  FrameReceiver receiver_;
  bool welcomed_ = false;      ///< a Welcome was received
  bool was_welcomed_ = false;  ///< as welcomed_, when the current frame began
  const CapturedFrame* frame_ = nullptr;
  std::size_t taken_ = 0;   ///< messages of frame_->after
  bool requested_ = false;  ///< in the current frame
  std::optional<std::string> difference_;
  std::optional<Error> refused_;  ///< always empty
  Duration busy_{};
};

/// The first difference between a request and the captured one; nothing if they are equal.
[[nodiscard]] std::optional<std::string> difference_of(const FrameRequest& request,
                                                       const FrameRequest& captured);

/// The first difference between a replay and its capture.
struct ReplayDifference {
  FrameId frame;
  std::string what;
};

struct ReplayVerdict {
  std::uint32_t frames = 0;  ///< replayed
  std::optional<ReplayDifference> first;
  std::optional<std::string> cut_off{};  ///< the capture lacks its end: see CaptureReader::cut_off
};

/// "312 frames, all requests and pictures as captured", or the first difference and its frame; then what the
/// capture lacks.
[[nodiscard]] std::string to_string(const ReplayVerdict& verdict);

class Replay final : public Runtime {
 public:
  /// `report` replaces the captured setting; it changes no picture. The run must be configured as the
  /// reader's header states. The object must not move.
  Replay(CaptureReader reader, PixelReport report);

  /// Returns nothing at the end of the file.
  [[nodiscard]] std::optional<FrameTiming> wait_frame() override;
  /// The captured views of the current frame, whatever the time.
  [[nodiscard]] StereoView locate_views(Time display_time) override;

  /// Null if the captured run had no server.
  [[nodiscard]] ServerConnection* link() { return link_ ? &*link_ : nullptr; }
  [[nodiscard]] const FrameSettings& settings() const { return settings_; }

  /// Compares the current frame, which was shown as these pictures.
  void watch(const FrameView& view, const PerEye<Image<Rgb8>>& shown);

  /// The result so far. An error if the file could not be read to its end.
  [[nodiscard]] Expected<ReplayVerdict> verdict() const;

 private:
  CaptureReader reader_;
  PixelReport report_;
  std::optional<CaptureLink> link_;
  CapturedFrame frame_;
  FrameSettings settings_;
  ReplayVerdict verdict_;
  std::optional<Error> error_;
};

}  // namespace farshade
