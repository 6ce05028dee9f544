/// Controls: all settings that the viewer of a preview can change, and the table of keys that change them. F1
/// shows this table. Commands only change values here; the preview reads them once per frame.
#pragma once

#include <bitset>
#include <span>
#include <string>

#include "stereo/net/impairment.h"
#include "vr_client/frame/frame_loop.h"
#include "vr_client/preview/composition.h"
#include "vr_client/preview/input.h"
#include "vr_client/preview/preview_runtime.h"
#include "vr_client/preview/remembered.h"
#include "vr_client/report/overlays.h"

namespace farshade {

/// How the window shows the two eyes.
enum class DisplayMode : std::uint8_t { SideBySide, CrossEyed, Mono, Anaglyph, Difference };
inline constexpr std::array kDisplayModes{DisplayMode::SideBySide, DisplayMode::CrossEyed, DisplayMode::Mono,
                                          DisplayMode::Anaglyph, DisplayMode::Difference};
[[nodiscard]] const char* name_of(DisplayMode display);

/// Impairment of the network path from the server to the client, set by sliders.
struct NetworkSettings {
  double latency_ms = 0, jitter_ms = 0, loss_percent = 0;
  friend bool operator==(const NetworkSettings&, const NetworkSettings&) = default;
};
inline constexpr NetworkSettings kWorstPath{300, 100, 50};
/// `base` with the latency, jitter and loss of `settings`.
[[nodiscard]] LinkModel path_of(const NetworkSettings& settings, LinkModel base);

/// A light that moves with its holder, the head or a hand: its pose relative to the holder is constant.
template <class Holder>
struct HeldLight {
  std::uint32_t light = 0;
  Point<Holder> position;
  Vector<Holder> direction;
};
using GrabbedLight = HeldLight<Head>;

enum class Command : std::uint8_t {
  // Display.
  NextDisplayMode,
  NextOverlay,
  NoOverlay,
  PictureShare,
  Reference,
  Inspector,
  // Mode, reprojection, requests and network path.
  NextMode,
  Reprojection,
  NextPredictor,
  GuardBand,
  AskWhole,
  SlowerMasks,
  FasterMasks,
  WorsePath,
  BetterPath,
  // Scene.
  NextLight,
  LightOnOff,
  GrabLight,
  ResetLights,
  Animation,
  // Head.
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
  // Time.
  HoldFrame,
  NextFrame,
  // Executed once by the preview, see Controls::take.
  Screenshot,
  RecordHead,
  RecordCapture,
  RecordFrames,
  Panel,
  Help,
  Quit,
};
inline constexpr std::size_t kCommands = static_cast<std::size_t>(Command::Quit) + 1;

struct KeyBinding {
  Key key;
  Command command;
  const char* description;
};
/// In the order of the help window. No key occurs twice.
[[nodiscard]] std::span<const KeyBinding> key_bindings();
/// The label on the keyboard.
[[nodiscard]] std::string name_of(Key key);

/// A line of the help window.
struct KeyHelp {
  std::string keys;
  const char* description;
};
/// The tabs of the panel, in their order.
enum class Tab : std::uint8_t { View, Masks, Scene, Record, Pixel };

struct Controls {
  DisplayMode display = DisplayMode::SideBySide;
  Overlay overlay = Overlay::None;
  double picture_share = kDefaultPictureShare;         ///< 0..kMostPictureShare
  std::uint32_t light = 0;                             ///< selected
  bool reference = false, panel = true, help = false;  ///< whether they are shown, or measured
  bool held = false;    ///< the time stands still at one frame; NextFrame is pending: show one frame more
  Tab tab = Tab::View;  ///< that is open
  std::optional<Tab> wanted_tab;  ///< to be opened when the panel is drawn next
  HeadSource head = HeadSource::Simulated;
  double eye_distance_m = 0.063;
  double fov_rad = 1.5;  ///< full vertical angle
  /// The fov of the head recording. It overrides `fov_rad` until the viewer changes that.
  std::optional<PerEye<EyeFov>> recorded_fov;
  NetworkSettings path;
  Mode mode = Mode::Hybrid;
  std::vector<Mode> modes;  ///< that the viewer can choose, in the order of the key
  FrameSettings settings;
  PixelReport least_report = PixelReport::Off;  ///< On: every frame reports, whatever is shown
  std::optional<GrabbedLight> grab;
  std::bitset<kCommands> pending;  ///< commands that the preview has not executed yet
  std::bitset<kCommands> absent;   ///< commands that this run cannot carry out: they do nothing

  [[nodiscard]] bool offers(Command command) const { return !absent[static_cast<std::size_t>(command)]; }
  /// Without a reference there is no difference and no error.
  [[nodiscard]] bool offers(DisplayMode one) const {
    return one != DisplayMode::Difference || offers(Command::Reference);
  }
  [[nodiscard]] bool offers(Overlay one) const { return one != Overlay::Error || offers(Command::Reference); }

  /// True if `command` is pending, which it then no longer is.
  [[nodiscard]] bool take(Command command);
};

inline constexpr double kWidestEyes_m = 0.5;
inline constexpr std::uint32_t kRarestMasks = 16;  ///< frames a request

/// What commands depend on: the current lights of the scene, the head pose, and the player of the head
/// recording, if there is one.
struct ControlContext {
  const LightSet& lights;
  Rigid<Stage, Head> stage_from_head;
  Player* player = nullptr;
};
/// Changes the controls as `command` says, if they offer it.
void execute(Command command, Controls& controls, const ControlContext& context);

/// All that mouse and keys do: the head's movement and every key binding of an offered command. A run without
/// Command::HeadSource has a head that mouse and keys do not move.
[[nodiscard]] std::vector<KeyHelp> key_help(const Controls& controls);

/// Executes the commands of the pressed keys, and moves a grabbed light.
void apply_input(const Input& input, Controls& controls, const ControlContext& context);

/// The holder takes `light`, whose index is `index`, where it is.
template <class Holder>
[[nodiscard]] HeldLight<Holder> hold(std::uint32_t index, const Light& light,
                                     const Rigid<Stage, Holder>& stage_from_holder) {
  const Rigid<Holder, Stage> holder_from_stage = inverse(stage_from_holder);
  // A point light has no direction; its vector may be zero.
  const Vector<Stage> direction = length(light.direction) > 0 ? light.direction : LightPose{}.direction;
  return {index, holder_from_stage(light.position), holder_from_stage(direction)};
}

/// Where the holder has a light that it holds.
template <class Holder>
[[nodiscard]] LightPose pose_of(const HeldLight<Holder>& held,
                                const Rigid<Stage, Holder>& stage_from_holder) {
  return {stage_from_holder(held.position), {glm::normalize(stage_from_holder(held.direction).v)}};
}

/// Makes the next revision, in which `light` is at `pose`, unless it is there already.
void move_light(LightChanges& changes, std::uint32_t light, const LightPose& pose);

/// Moves a grabbed light with the head. Positive `notches` of the wheel move it away from the viewer.
void carry_light(Controls& controls, const ControlContext& context, double notches);

/// What the preview remembers of these controls, and the controls set to it. The size of the window is not
/// theirs.
[[nodiscard]] Remembered remembered_of(const Controls& controls);
void recall(const Remembered& remembered, Controls& controls);

/// The head movement that the held keys and the mouse ask for.
[[nodiscard]] HeadInput head_input(const Input& input);

/// The headset with the eye distance and fov of these controls, and `size` pixels per eye.
[[nodiscard]] Headset headset_of(const Controls& controls, Extent size);

/// Whether these controls need a full trace of the shown frame.
[[nodiscard]] bool needs_reference(const Controls& controls);

/// Whether these controls replace the pictures of the eyes, or measure them.
[[nodiscard]] bool replaces_pictures(const Controls& controls);

/// Whether the pixel under the mouse is inspected.
[[nodiscard]] bool inspects_pixel(const Controls& controls);

/// Whether the shading pass must report, for overlays, measuring or the inspector. A held frame reports,
/// because the viewer may choose an overlay while it is shown.
[[nodiscard]] PixelReport report_for(const Controls& controls);

}  // namespace farshade
