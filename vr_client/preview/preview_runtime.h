/// PreviewRuntime: a headset on a desk. Its head is moved by hands or by a recording, its display times are
/// paced by a clock, and it asks its owner once a frame what hands did.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "stereo/head/head_recording.h"
#include "vr_client/preview/frame_pacer.h"
#include "vr_client/preview/head.h"
#include "vr_client/preview/player.h"
#include "vr_client/runtime/headset.h"
#include "vr_client/runtime/runtime.h"

namespace farshade {

enum class HeadSource : std::uint8_t { Hand, Recording };

/// What the viewer decides for one frame.
struct HeadControls {
  HeadSource source = HeadSource::Hand;
  HeadInput head;  ///< heeded if `source` is Hand
  Headset headset;
};

/// Called once in each wait_frame, when the frame is about to begin: the place to poll a window, to change
/// the player, or to wait while a window is minimised (that time is not counted as the frame's). Nothing ends
/// the session.
using TakeIn = std::function<std::optional<HeadControls>()>;
using Sleep = std::function<void(Duration)>;

/// A recording to follow. Keeps a reference.
struct PlacedHeadRecording {
  const HeadRecording& trace;
  Rigid<Stage, Recorded> stage_from_recorded;
};

struct PreviewSetup {
  Rigid<Stage, Head> start;  ///< where hands find the head
  std::optional<PlacedHeadRecording> recording;
  double refresh_hz = 72;
  std::optional<std::uint32_t> frames;  ///< to show; without end if not said
};

class PreviewRuntime final : public Runtime {
 public:
  /// Keeps a reference to `clock`. `sleep` lets that clock go on by at least the span given.
  PreviewRuntime(const PreviewSetup& setup, const Clock& clock, Sleep sleep, TakeIn take_in);

  /// Sleeps until the next frame should begin, takes in what hands did, and fixes where the head is in this
  /// frame. Hands move the head and the player moves on by what the display time has since the last frame.
  /// Hands that take over from a recording have the head where it was, upright.
  /// Display times strictly increase, by whole display periods; `period` is the n periods that frames now
  /// take (FramePacer).
  [[nodiscard]] std::optional<FrameTiming> wait_frame() override;

  /// A head moved by hands does not know its future: its pose is this frame's for every time. A recording
  /// is sampled at `display_time`. Not before the first frame.
  [[nodiscard]] StereoView locate_views(Time display_time) const override;
  void end_frame(Time display_time) override;

  /// The head at this frame's display time; before the first frame, the start.
  [[nodiscard]] const Rigid<Stage, Head>& stage_from_head() const { return stage_from_head_; }
  /// What moves the head in this frame: Hand if there is no recording, whatever was wanted.
  [[nodiscard]] HeadSource source() const { return source_; }
  /// Where the recording stands; it stands still while hands move the head. Null without one.
  [[nodiscard]] Player* player() { return player_ ? &*player_ : nullptr; }

 private:
  void move_head(const HeadControls& hands, Duration span);
  [[nodiscard]] Rigid<Stage, Head> recorded_head(Duration ahead) const;

  PreviewSetup setup_;
  const Clock& clock_;
  Sleep sleep_;
  TakeIn take_in_;
  FramePacer pacer_;
  std::optional<Player> player_;
  SimulatedHead hand_;
  Rigid<Stage, Head> stage_from_head_;
  HeadSource source_ = HeadSource::Hand;
  Headset headset_;
  std::uint32_t begun_ = 0;           ///< frames
  std::optional<Time> began_at_;      ///< this frame, on the clock
  std::optional<Time> display_time_;  ///< of this frame
};

}  // namespace farshade
