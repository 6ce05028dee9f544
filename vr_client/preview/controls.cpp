#include "vr_client/preview/controls.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace farshade {
namespace {

constexpr double kFovStep_rad = 5 * std::numbers::pi / 180, kEyeStep_m = 0.01;
constexpr double kPathStep_ms = 25;
constexpr Duration kScrub = std::chrono::seconds(1);
/// A notch of the wheel brings a grabbed light so much further, in proportion.
constexpr double kReach = 1.1, kNearestGrab_m = 0.05, kFarthestGrab_m = 1000;

constexpr KeyBinding kKeyTable[] = {
    {Key::F1, Act::Help, "show or hide this"},
    {Key::Tab, Act::Panel, "show or hide the panel"},
    {Key::V, Act::NextLook,
     "next layout to show the eyes: side by side, cross-eyed, mono, anaglyph, difference"},
    {Key::O, Act::NextOverlay, "next overlay"},
    {Key::Digit0, Act::NoOverlay, "no overlay"},
    {Key::F, Act::Reference, "trace the reference in every frame, and measure"},
    {Key::R, Act::Reprojection, "reprojection on or off"},
    {Key::P, Act::NextPredictor, "next predictor"},
    {Key::B, Act::GuardBand, "guard band on or off"},
    {Key::Plus, Act::SlowerMasks, "masks half as often"},
    {Key::Minus, Act::FasterMasks, "masks twice as often"},
    {Key::RightBracket, Act::WorsePath, "25 ms more latency"},
    {Key::LeftBracket, Act::BetterPath, "25 ms less latency"},
    {Key::L, Act::NextLight, "select the next light"},
    {Key::K, Act::LightOnOff, "selected light on or off"},
    {Key::G, Act::GrabLight, "grab the selected light, or let it go; the wheel brings it nearer or further"},
    {Key::T, Act::ResetLights, "all lights as the scene has them"},
    {Key::X, Act::Animation, "stop or start the scene's animation"},
    {Key::H, Act::HeadSource, "head by hand or by the recording"},
    {Key::Space, Act::PlayPause, "play or pause the recording"},
    {Key::Left, Act::Back, "recording: one second back"},
    {Key::Right, Act::Forward, "recording: one second forward"},
    {Key::Down, Act::Slower, "recording: half as fast"},
    {Key::Up, Act::Faster, "recording: twice as fast"},
    {Key::Y, Act::Loop, "recording: loop or hold at the end"},
    {Key::Period, Act::WiderEyes, "eyes 10 mm further apart"},
    {Key::Comma, Act::CloserEyes, "eyes 10 mm closer together"},
    {Key::Home, Act::WiderFov, "field of view 5 degrees wider"},
    {Key::End, Act::NarrowerFov, "field of view 5 degrees narrower"},
    {Key::F12, Act::Screenshot, "screenshot of each eye and of the window's pictures"},
    {Key::F9, Act::RecordHead, "start or stop recording the head"},
    {Key::F8, Act::RecordSession, "start or stop recording the session, to replay it bit for bit"},
    {Key::F10, Act::RecordFrames, "start or stop writing every frame, both eyes side by side"},
    {Key::Escape, Act::Quit, "quit"},
};

/// The change that `light` now has; as the scene has it if there is none.
LightChange change_of(const LightChanges& changes, std::uint32_t light) {
  const auto found = std::ranges::find(changes.lights, light, &LightChange::light);
  return found == changes.lights.end() ? LightChange{.light = light, .pose = {}} : *found;
}

void switch_light(Controls& controls) {
  LightChanges& changes = controls.steering.lights;
  const LightChange now = change_of(changes, controls.light);
  change(changes, controls.light, !now.on, now.pose);
}

void grab_or_let_go(Controls& controls, const ControlState& stand) {
  if (controls.grab) {
    controls.grab.reset();
    return;
  }
  if (controls.light >= stand.lights.lights.size()) return;
  const Light& light = stand.lights.lights[controls.light];
  const auto head_from_stage = inverse(stand.stage_from_head);
  // A point light's direction means nothing, and may be nothing.
  const Vector<Stage> direction = length(light.direction) > 0 ? light.direction : LightPose{}.direction;
  controls.grab = {controls.light, head_from_stage(light.position), head_from_stage(direction)};
}

void reset_lights(Controls& controls) {
  controls.grab.reset();
  LightChanges& changes = controls.steering.lights;
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

void change_view(Act act, Controls& controls) {
  const auto next = [](auto value, std::size_t count) {
    return static_cast<decltype(value)>((static_cast<std::size_t>(value) + 1) % count);
  };
  if (act == Act::NextLook) controls.look = next(controls.look, kLooks.size());
  if (act == Act::NextOverlay) controls.overlay = next(controls.overlay, kOverlays.size());
  if (act == Act::NoOverlay) controls.overlay = Overlay::None;
  if (act == Act::Reference) flip(controls.reference);
  if (act == Act::Panel) flip(controls.panel);
  if (act == Act::Help) flip(controls.help);
}

void change_carry_over(Act act, Controls& controls) {
  RequestSettings& wish = controls.steering.wish;
  CarryOver& carry_over = controls.steering.carry_over;
  if (act == Act::Reprojection)
    carry_over.lookup = carry_over.lookup == Lookup::Reproject ? Lookup::Direct : Lookup::Reproject;
  if (act == Act::NextPredictor) {
    const auto* const now = std::ranges::find(kPredictorKinds, wish.predictor);
    wish.predictor = now + 1 == std::end(kPredictorKinds) ? *kPredictorKinds : *(now + 1);
  }
  if (act == Act::GuardBand)
    wish.guard_band = wish.guard_band == GuardBandUse::Off ? GuardBandUse::Measured : GuardBandUse::Off;
  if (act == Act::SlowerMasks) wish.every = std::min(wish.every * 2, kRarestMasks);
  if (act == Act::FasterMasks) wish.every = std::max(wish.every / 2, 1u);
  double& latency_ms = controls.path.latency_ms;
  if (act == Act::WorsePath) latency_ms = std::min(latency_ms + kPathStep_ms, kWorstPath.latency_ms);
  if (act == Act::BetterPath) latency_ms = std::max(latency_ms - kPathStep_ms, 0.0);
}

void change_scene(Act act, Controls& controls, const ControlState& stand) {
  const std::size_t lights = stand.lights.lights.size();
  if (act == Act::NextLight && lights > 0)
    controls.light = static_cast<std::uint32_t>((controls.light + 1) % lights);
  if (act == Act::LightOnOff && lights > 0) switch_light(controls);
  if (act == Act::GrabLight) grab_or_let_go(controls, stand);
  if (act == Act::ResetLights) reset_lights(controls);
  SceneClock& clock = controls.steering.scene;
  if (act == Act::Animation) clock = clock == SceneClock::Runs ? SceneClock::Stands : SceneClock::Runs;
}

void change_head(Act act, Controls& controls, const ControlState& stand) {
  if (act == Act::WiderEyes)
    controls.eye_distance_m = std::min(controls.eye_distance_m + kEyeStep_m, kWidestEyes_m);
  if (act == Act::CloserEyes) controls.eye_distance_m = std::max(controls.eye_distance_m - kEyeStep_m, 0.0);
  if (act == Act::WiderFov) widen(controls, kFovStep_rad);
  if (act == Act::NarrowerFov) widen(controls, -kFovStep_rad);
  Player* const player = stand.player;
  if (player == nullptr) return;
  if (act == Act::HeadSource)
    controls.head = controls.head == HeadSource::Hand ? HeadSource::Recording : HeadSource::Hand;
  if (act == Act::PlayPause) player->playing() ? player->pause() : player->play();
  if (act == Act::Back) player->scrub(player->position() - kScrub);
  if (act == Act::Forward) player->scrub(player->position() + kScrub);
  if (act == Act::Slower) player->set_speed(player->speed() / 2);
  if (act == Act::Faster) player->set_speed(player->speed() * 2);
  if (act == Act::Loop) player->set_at_end(player->at_end() == AtEnd::Loop ? AtEnd::Hold : AtEnd::Loop);
}

}  // namespace

const char* name_of(Look look) {
  constexpr std::array names{"side by side", "cross-eyed", "mono", "anaglyph", "difference"};
  static_assert(names.size() == kLooks.size());
  return names[static_cast<std::size_t>(look)];
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

LinkModel path_of(const NetworkSettings& wish, LinkModel base) {
  base.delay = duration_from_ms(wish.latency_ms);
  base.jitter = duration_from_ms(wish.jitter_ms);
  base.loss = wish.loss_percent / 100;
  base.burst = std::max(base.burst, 1.0);
  return base;
}

bool Controls::take(Act act) {
  const auto index = static_cast<std::size_t>(act);
  const bool was = wanted[index];
  wanted.reset(index);
  return was;
}

void act(Act act, Controls& controls, const ControlState& stand) {
  change_view(act, controls);
  change_carry_over(act, controls);
  change_scene(act, controls, stand);
  change_head(act, controls, stand);
  for (const Act once : {Act::Screenshot, Act::RecordHead, Act::RecordSession, Act::RecordFrames, Act::Quit})
    if (act == once) controls.wanted.set(static_cast<std::size_t>(act));
}

void obey(const Input& input, Controls& controls, const ControlState& stand) {
  for (const Key key : input.pressed)
    for (const KeyBinding& binding : key_bindings())
      if (binding.key == key) act(binding.act, controls, stand);
  carry_light(controls, stand, input.scroll);
  controls.steering.report = report_for(controls);
}

void carry_light(Controls& controls, const ControlState& stand, double notches) {
  if (!controls.grab) return;
  Grab& grab = *controls.grab;
  const double distance = glm::length(grab.position.v);
  const double wanted =
      std::clamp(distance * std::pow(kReach, notches), kNearestGrab_m, std::max(distance, kFarthestGrab_m));
  if (distance > 0 && notches != 0) grab.position.v *= wanted / distance;
  const LightPose pose{stand.stage_from_head(grab.position),
                       {glm::normalize(stand.stage_from_head(grab.direction).v)}};
  LightChanges& changes = controls.steering.lights;
  const LightChange now = change_of(changes, grab.light);
  if (now.pose != pose) change(changes, grab.light, now.on, pose);
}

HeadInput head_input(const Input& input) {
  const auto axis = [&](Key negative, Key positive) {
    return static_cast<double>(input.holds(positive)) - static_cast<double>(input.holds(negative));
  };
  return {.turn_px = input.drag_px,
          .walk = {axis(Key::A, Key::D), axis(Key::Q, Key::E), axis(Key::W, Key::S)},
          .gait = input.holds(Key::Shift) ? Gait::Run : Gait::Walk};
}

Headset headset_of(const Controls& controls, Extent size) {
  const double aspect = static_cast<double>(size.width) / size.height;
  const EyeFov fov = field_of_view(controls.fov_rad, aspect);
  return {.eye_distance_m = controls.eye_distance_m,
          .fov = controls.recorded_fov.value_or(PerEye<EyeFov>{fov, fov}),
          .eye_size = size};
}

ShadingPass::Report report_for(const Controls& controls) {
  const bool needed =
      controls.overlay != Overlay::None || is_on(controls.reference) || controls.look == Look::Difference;
  return needed ? ShadingPass::Report::On : ShadingPass::Report::Off;
}

}  // namespace farshade
