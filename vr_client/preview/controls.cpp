#include "vr_client/preview/controls.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace farshade {
namespace {

constexpr double kFovStep_rad = 5 * std::numbers::pi / 180, kEyeStep_m = 0.01;
constexpr double kPathStep_ms = 25, kShareStep = 0.25;
constexpr Duration kScrub = std::chrono::seconds(1);
/// Factor by which one notch of the wheel changes the distance of a grabbed light.
constexpr double kDistancePerNotch = 1.1, kNearestGrab_m = 0.05, kFarthestGrab_m = 1000;

constexpr KeyBinding kKeyTable[] = {
    {Key::F1, Command::Help, "show or hide this list"},
    {Key::Tab, Command::Panel, "show or hide the panel"},
    {Key::V, Command::NextDisplayMode,
     "next display mode: side by side, cross-eyed, mono, anaglyph, difference"},
    {Key::O, Command::NextOverlay, "next overlay"},
    {Key::Digit0, Command::NoOverlay, "no overlay"},
    {Key::Z, Command::PictureShare, "overlay: how much of the picture shines through: 0, 25, 50 or 75 %"},
    {Key::F, Command::Reference, "trace the reference in every frame and measure errors"},
    {Key::I, Command::Inspector, "inspect the pixel under the mouse, in the panel"},
    {Key::M, Command::NextMode, "next mode; the frame loop starts again, with a new session"},
    {Key::R, Command::Reprojection, "reprojection on or off"},
    {Key::P, Command::NextPredictor, "next predictor"},
    {Key::B, Command::GuardBand, "guard band on or off"},
    {Key::U, Command::AskWhole, "ask for what is unknown, or for whole views"},
    {Key::Plus, Command::SlowerMasks, "request masks half as often"},
    {Key::Minus, Command::FasterMasks, "request masks twice as often, at last as often as needed"},
    {Key::RightBracket, Command::WorsePath, "25 ms more latency"},
    {Key::LeftBracket, Command::BetterPath, "25 ms less latency"},
    {Key::L, Command::NextLight, "select the next light"},
    {Key::K, Command::LightOnOff, "selected light on or off"},
    {Key::G, Command::GrabLight, "grab or release the selected light; the wheel moves it nearer or farther"},
    {Key::T, Command::ResetLights, "reset all lights to the scene's"},
    {Key::X, Command::Animation, "stop or start the scene's animation"},
    {Key::Enter, Command::HoldFrame, "hold this frame: the time stands still; or let the time run"},
    {Key::N, Command::NextFrame, "hold the frame, or show the next one and hold it"},
    {Key::H, Command::HeadSource, "move the head by mouse and keys, or by the recording"},
    {Key::Space, Command::PlayPause, "play or pause the recording"},
    {Key::Left, Command::Back, "recording: one second back"},
    {Key::Right, Command::Forward, "recording: one second forward"},
    {Key::Down, Command::Slower, "recording: half as fast"},
    {Key::Up, Command::Faster, "recording: twice as fast"},
    {Key::Y, Command::Loop, "recording: loop, or stop at the end"},
    {Key::Period, Command::WiderEyes, "eyes 10 mm further apart"},
    {Key::Comma, Command::CloserEyes, "eyes 10 mm closer together"},
    {Key::Home, Command::WiderFov, "field of view 5 degrees wider"},
    {Key::End, Command::NarrowerFov, "field of view 5 degrees narrower"},
    {Key::F12, Command::Screenshot, "screenshots of each eye and of the window without its panel"},
    {Key::F9, Command::RecordHead, "start or stop recording the head"},
    {Key::F8, Command::RecordCapture, "start or stop a capture, for --replay"},
    {Key::F10, Command::RecordFrames,
     "start or stop writing a picture of every frame, both eyes side by side"},
    {Key::Escape, Command::Quit, "quit"},
};

/// The current change of `light`; without one, a change that leaves the light as it is in the scene.
LightChange change_of(const LightChanges& changes, std::uint32_t light) {
  const auto found = std::ranges::find(changes.lights, light, &LightChange::light);
  return found == changes.lights.end() ? LightChange{.light = light, .pose = {}} : *found;
}

void switch_light(Controls& controls) {
  LightChanges& changes = controls.settings.lights;
  const LightChange now = change_of(changes, controls.light);
  change(changes, controls.light, !now.on, now.pose);
}

void grab_or_release(Controls& controls, const ControlContext& context) {
  if (controls.grab) {
    controls.grab.reset();
    return;
  }
  if (controls.light >= context.lights.lights.size()) return;
  controls.grab = hold(controls.light, context.lights.lights[controls.light], context.stage_from_head);
}

void reset_lights(Controls& controls) {
  controls.grab.reset();
  LightChanges& changes = controls.settings.lights;
  const std::vector<LightChange> before = changes.lights;
  for (const LightChange& changed : before)
    if (!changed.on || changed.pose) change(changes, changed.light, true, std::nullopt);
}

void widen(Controls& controls, double by_rad) {
  if (controls.recorded_fov) {
    const EyeFov& eye = (*controls.recorded_fov)[0];
    controls.fov_rad = eye.up_rad - eye.down_rad;
    controls.recorded_fov.reset();
  }
  controls.fov_rad = std::clamp(controls.fov_rad + by_rad, kNarrowestView_rad, kWidestView_rad);
}

void change_view(Command command, Controls& controls) {
  const auto next = [&](auto value, std::size_t count) {
    do value = static_cast<decltype(value)>((static_cast<std::size_t>(value) + 1) % count);
    while (!controls.offers(value));
    return value;
  };
  if (command == Command::NextDisplayMode) controls.display = next(controls.display, kDisplayModes.size());
  if (command == Command::NextOverlay) controls.overlay = next(controls.overlay, kOverlays.size());
  if (command == Command::NoOverlay) controls.overlay = Overlay::None;
  if (command == Command::PictureShare)
    controls.picture_share = controls.picture_share + kShareStep > kMostPictureShare
                                 ? 0
                                 : (std::floor(controls.picture_share / kShareStep) + 1) * kShareStep;
  if (command == Command::Reference) controls.reference = !controls.reference;
  if (command == Command::Inspector) {
    controls.wanted_tab = inspects_pixel(controls) ? Tab::View : Tab::Pixel;
    controls.tab = *controls.wanted_tab;
    controls.panel = true;
  }
  if (command == Command::Panel) controls.panel = !controls.panel;
  if (command == Command::Help) controls.help = !controls.help;
}

void change_reprojection(Command command, Controls& controls) {
  RequestSettings& request = controls.settings.request;
  Reprojection& reprojection = controls.settings.reprojection;
  if (command == Command::Reprojection)
    reprojection.lookup = reprojection.lookup == Lookup::Reproject ? Lookup::Direct : Lookup::Reproject;
  if (command == Command::NextPredictor) {
    const auto* const now = std::ranges::find(kPredictorKinds, request.predictor);
    request.predictor = now + 1 == std::end(kPredictorKinds) ? *kPredictorKinds : *(now + 1);
  }
  if (command == Command::GuardBand)
    request.guard_band = request.guard_band == GuardBandUse::Off ? GuardBandUse::Measured : GuardBandUse::Off;
  if (command == Command::AskWhole) request.asks = request.asks == Asks::Whole ? Asks::Unknown : Asks::Whole;
  if (command == Command::SlowerMasks)
    request.every = std::min(std::max(request.every, 1u) * 2, kRarestMasks);
  if (command == Command::FasterMasks) request.every /= 2;
  double& latency_ms = controls.path.latency_ms;
  if (command == Command::WorsePath) latency_ms = std::min(latency_ms + kPathStep_ms, kWorstPath.latency_ms);
  if (command == Command::BetterPath) latency_ms = std::max(latency_ms - kPathStep_ms, 0.0);
}

void change_mode(Command command, Controls& controls) {
  if (command != Command::NextMode || controls.modes.empty()) return;
  const auto now = std::ranges::find(controls.modes, controls.mode);
  const bool is_last = now == controls.modes.end() || now + 1 == controls.modes.end();
  controls.mode = is_last ? controls.modes.front() : *(now + 1);
}

void change_scene(Command command, Controls& controls, const ControlContext& context) {
  const std::size_t lights = context.lights.lights.size();
  if (command == Command::NextLight && lights > 0)
    controls.light = static_cast<std::uint32_t>((controls.light + 1) % lights);
  if (command == Command::LightOnOff && lights > 0) switch_light(controls);
  if (command == Command::GrabLight) grab_or_release(controls, context);
  if (command == Command::ResetLights) reset_lights(controls);
  SceneClock& clock = controls.settings.scene;
  if (command == Command::Animation)
    clock = clock == SceneClock::Running ? SceneClock::Paused : SceneClock::Running;
}

void change_time(Command command, Controls& controls) {
  if (command == Command::NextFrame) {
    controls.pending.set(static_cast<std::size_t>(command), controls.held);
    controls.held = true;
  }
  if (command == Command::HoldFrame) {
    controls.pending.reset(static_cast<std::size_t>(Command::NextFrame));
    controls.held = !controls.held;
  }
}

void change_head(Command command, Controls& controls, const ControlContext& context) {
  if (command == Command::WiderEyes)
    controls.eye_distance_m = std::min(controls.eye_distance_m + kEyeStep_m, kWidestEyes_m);
  if (command == Command::CloserEyes)
    controls.eye_distance_m = std::max(controls.eye_distance_m - kEyeStep_m, 0.0);
  if (command == Command::WiderFov) widen(controls, kFovStep_rad);
  if (command == Command::NarrowerFov) widen(controls, -kFovStep_rad);
  Player* const player = context.player;
  if (player == nullptr) return;
  if (command == Command::HeadSource)
    controls.head = controls.head == HeadSource::Simulated ? HeadSource::Recording : HeadSource::Simulated;
  if (command == Command::PlayPause) player->playing() ? player->pause() : player->play();
  if (command == Command::Back) player->scrub(player->position() - kScrub);
  if (command == Command::Forward) player->scrub(player->position() + kScrub);
  if (command == Command::Slower) player->set_speed(player->speed() / 2);
  if (command == Command::Faster) player->set_speed(player->speed() * 2);
  if (command == Command::Loop)
    player->set_at_end(player->at_end() == AtEnd::Loop ? AtEnd::Hold : AtEnd::Loop);
}

}  // namespace

const char* name_of(DisplayMode display) {
  constexpr std::array names{"side by side", "cross-eyed", "mono", "anaglyph", "difference"};
  static_assert(names.size() == kDisplayModes.size());
  return names[static_cast<std::size_t>(display)];
}

std::string name_of(Key key) {
  const auto number = static_cast<int>(key);
  const auto within = [&](Key first, Key last) { return key >= first && key <= last; };
  const auto counted = [&](Key first) { return number - static_cast<int>(first); };
  if (within(Key::A, Key::Z)) return {static_cast<char>('A' + counted(Key::A))};
  if (within(Key::Digit0, Key::Digit9)) return {static_cast<char>('0' + counted(Key::Digit0))};
  if (within(Key::F1, Key::F12)) return "F" + std::to_string(counted(Key::F1) + 1);
  constexpr std::array others{"Space", "Tab", "Enter", "Escape", "Left", "Right", "Up", "Down",  "Home",
                              "End",   "+",   "-",     "[",      "]",    ",",     ".",  "Shift", "Ctrl"};
  return others.at(static_cast<std::size_t>(counted(Key::Space)));
}

std::span<const KeyBinding> key_bindings() {
  return kKeyTable;
}

std::vector<KeyHelp> key_help(const Controls& controls) {
  std::vector<KeyHelp> lines;
  if (controls.offers(Command::HeadSource))
    lines = {{"mouse", "drag the picture to look around"},
             {"W A S D", "walk; with Shift run"},
             {"Q E", "down, up"}};
  for (const KeyBinding& binding : kKeyTable)
    if (controls.offers(binding.command)) lines.push_back({name_of(binding.key), binding.description});
  return lines;
}

LinkModel path_of(const NetworkSettings& settings, LinkModel base) {
  base.delay = duration_from_ms(settings.latency_ms);
  base.jitter = duration_from_ms(settings.jitter_ms);
  base.loss = settings.loss_percent / 100;
  base.burst = std::max(base.burst, 1.0);
  return base;
}

bool Controls::take(Command command) {
  const auto index = static_cast<std::size_t>(command);
  const bool is_pending = pending[index];
  pending.reset(index);
  return is_pending;
}

void execute(Command command, Controls& controls, const ControlContext& context) {
  if (!controls.offers(command)) return;
  change_view(command, controls);
  change_mode(command, controls);
  change_reprojection(command, controls);
  change_scene(command, controls, context);
  change_time(command, controls);
  change_head(command, controls, context);
  for (const Command once : {Command::Screenshot, Command::RecordHead, Command::RecordCapture,
                             Command::RecordFrames, Command::Quit})
    if (command == once) controls.pending.set(static_cast<std::size_t>(command));
}

void apply_input(const Input& input, Controls& controls, const ControlContext& context) {
  for (const Key key : input.pressed)
    for (const KeyBinding& binding : key_bindings())
      if (binding.key == key) execute(binding.command, controls, context);
  carry_light(controls, context, input.scroll);
  controls.settings.report = report_for(controls);
}

void move_light(LightChanges& changes, std::uint32_t light, const LightPose& pose) {
  const LightChange now = change_of(changes, light);
  if (now.pose != pose) change(changes, light, now.on, pose);
}

void carry_light(Controls& controls, const ControlContext& context, double notches) {
  if (!controls.grab) return;
  GrabbedLight& grab = *controls.grab;
  const double distance = glm::length(grab.position.v);
  const double moved = std::clamp(distance * std::pow(kDistancePerNotch, notches), kNearestGrab_m,
                                  std::max(distance, kFarthestGrab_m));
  if (distance > 0 && notches != 0) grab.position.v *= moved / distance;
  move_light(controls.settings.lights, grab.light, pose_of(grab, context.stage_from_head));
}

Remembered remembered_of(const Controls& controls) {
  return {.window = std::nullopt,
          .panel = controls.panel,
          .overlay = controls.overlay,
          .picture_share = controls.picture_share};
}

void recall(const Remembered& remembered, Controls& controls) {
  controls.panel = remembered.panel;
  controls.overlay = remembered.overlay;
  controls.picture_share = remembered.picture_share;
}

HeadInput head_input(const Input& input) {
  const auto axis = [&](Key negative, Key positive) {
    return static_cast<double>(input.holds(positive)) - static_cast<double>(input.holds(negative));
  };
  return {.turn_px = input.drag_px,
          .walk = {axis(Key::A, Key::D), axis(Key::Q, Key::E), axis(Key::W, Key::S)},
          .speed = input.holds(Key::Shift) ? MoveSpeed::Run : MoveSpeed::Walk};
}

Headset headset_of(const Controls& controls, Extent size) {
  const double aspect = static_cast<double>(size.width) / size.height;
  const EyeFov fov = field_of_view(controls.fov_rad, aspect);
  return {.eye_distance_m = controls.eye_distance_m,
          .fov = controls.recorded_fov.value_or(PerEye<EyeFov>{fov, fov}),
          .eye_size = size};
}

bool needs_reference(const Controls& controls) {
  return controls.reference || controls.display == DisplayMode::Difference ||
         controls.overlay == Overlay::Error;
}

bool replaces_pictures(const Controls& controls) {
  return controls.overlay != Overlay::None || needs_reference(controls);
}

bool inspects_pixel(const Controls& controls) {
  return controls.panel && controls.tab == Tab::Pixel;
}

PixelReport report_for(const Controls& controls) {
  const bool needed = replaces_pictures(controls) || inspects_pixel(controls) || controls.held;
  return needed || controls.least_report == PixelReport::On ? PixelReport::On : PixelReport::Off;
}

}  // namespace farshade
