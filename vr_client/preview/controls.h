/// Controls: everything that a viewer can set, and the one table of keys that sets it, which the window obeys
/// and F1 prints. Pure: acts change values; whoever runs the session reads them once a frame.
#pragma once

#include <bitset>
#include <span>
#include <string>

#include "stereo/net/impairment.h"
#include "vr_client/frame/frame_loop.h"
#include "vr_client/preview/composition.h"
#include "vr_client/preview/input.h"
#include "vr_client/preview/preview_runtime.h"
#include "vr_client/report/overlays.h"

namespace farshade {

/// How the window shows the eyes.
enum class Look : std::uint8_t { SideBySide, CrossEyed, Mono, Anaglyph, Difference };
inline constexpr std::array kLooks{Look::SideBySide, Look::CrossEyed, Look::Mono, Look::Anaglyph,
                                   Look::Difference};
[[nodiscard]] const char* name_of(Look look);

enum class Switch : std::uint8_t { Off, On };
constexpr bool is_on(Switch s) {
  return s == Switch::On;
}
constexpr Switch switch_of(bool on) {
  return on ? Switch::On : Switch::Off;
}
constexpr void flip(Switch& s) {
  s = switch_of(!is_on(s));
}

/// What the sliders do to the path from the server to here.
struct NetworkSettings {
  double latency_ms = 0, jitter_ms = 0, loss_percent = 0;
  friend bool operator==(const NetworkSettings&, const NetworkSettings&) = default;
};
inline constexpr NetworkSettings kWorstPath{300, 100, 50};
/// `base` with the wish's latency, jitter and loss.
[[nodiscard]] LinkModel path_of(const NetworkSettings& wish, LinkModel base);

/// A light held in the hand: where the head sees it, it stays.
struct Grab {
  std::uint32_t light = 0;
  Point<Head> position;
  Vector<Head> direction;
};

enum class Act : std::uint8_t {
  // What the eyes see.
  NextLook,
  NextOverlay,
  NoOverlay,
  Reference,
  // How shadows are carried over, and asked for.
  Reprojection,
  NextPredictor,
  GuardBand,
  SlowerMasks,
  FasterMasks,
  WorsePath,
  BetterPath,
  // The scene.
  NextLight,
  LightOnOff,
  GrabLight,
  ResetLights,
  Animation,
  // The head.
  HeadSource,
  PlayPause,
  Back,
  Forward,
  Slower,
  Faster,
  Loop,
  WiderEyes,
  CloserEyes,
  WiderFov,
  NarrowerFov,
  // Wanted once, of whoever runs the session.
  Screenshot,
  RecordHead,
  RecordSession,
  RecordFrames,
  Panel,
  Help,
  Quit,
};
inline constexpr std::size_t kActs = static_cast<std::size_t>(Act::Quit) + 1;

struct KeyBinding {
  Key key;
  Act act;
  const char* does;
};
/// In the order in which F1 prints them; no key twice.
[[nodiscard]] std::span<const KeyBinding> key_bindings();
/// As on the keyboard.
[[nodiscard]] std::string name_of(Key key);

struct Controls {
  Look look = Look::SideBySide;
  Overlay overlay = Overlay::None;
  std::uint32_t light = 0;  ///< selected
  Switch reference = Switch::Off, panel = Switch::On, help = Switch::Off;
  HeadSource head = HeadSource::Hand;
  double eye_distance_m = 0.063;
  double fov_rad = 1.5;  ///< full vertical angle
  /// What a recording says its eyes see; until `fov_rad` is touched.
  std::optional<PerEye<EyeFov>> recorded_fov;
  NetworkSettings path;
  FrameSettings steering;
  std::optional<Grab> grab;
  std::bitset<kActs> wanted;  ///< acts that are wanted once; taken by take()

  /// True once after each Act of the kind.
  [[nodiscard]] bool take(Act act);
};

inline constexpr double kWidestEyes_m = 0.5;
inline constexpr std::uint32_t kRarestMasks = 16;  ///< frames a request

/// What acts look at: the scene's lights as they now stand, where the head is, and its recording, if any.
struct ControlState {
  const LightSet& lights;
  Rigid<Stage, Head> stage_from_head;
  Player* player = nullptr;
};
void act(Act act, Controls& controls, const ControlState& stand);

/// Does what keys and wheel ask for.
void obey(const Input& input, Controls& controls, const ControlState& stand);

/// Carries a grabbed light along with the head; the wheel, `notches` away from the viewer, brings it further.
void carry_light(Controls& controls, const ControlState& stand, double notches);

/// What the input says about the head, from the keys that are held and the mouse.
[[nodiscard]] HeadInput head_input(const Input& input);

/// The headset that these controls describe, with eyes of `size`.
[[nodiscard]] Headset headset_of(const Controls& controls, Extent size);

/// What overlays and measuring need of the shading pass.
[[nodiscard]] ShadingPass::Report report_for(const Controls& controls);

}  // namespace farshade
