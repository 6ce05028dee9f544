#include "vr_client/preview/headset_controls.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "stereo/math/rotation.h"
#include "vr_client/preview/head.h"

namespace farshade {
namespace {

using Press = ControllerState::Press;
using Grip = ControllerState::Grip;

bool is_finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

template <class To, class From>
bool is_finite(const Rigid<To, From>& pose) {
  return is_finite(pose.translation) && std::isfinite(glm::dot(pose.rotation, pose.rotation));
}

/// Without poses and a walk that are not finite.
Hands usable(Hands hands) {
  for (HandInput& hand : hands.hand)
    if (hand.tracked_from_hand && !is_finite(*hand.tracked_from_hand)) hand.tracked_from_hand.reset();
  if (!std::isfinite(hands.walk.x) || !std::isfinite(hands.walk.y)) hands.walk = {};
  return hands;
}

Press after_input(Press before, double value, Threshold threshold) {
  if (!std::isfinite(value)) return before;
  if (value <= threshold.release) return Press::Released;
  return before == Press::Released && value >= threshold.press ? Press::Pressed : before;
}

/// Follows a button. True if it was pressed now.
bool is_new_press(Press& press, double value, Threshold threshold) {
  const Press before = std::exchange(press, after_input(press, value, threshold));
  return before == Press::Released && press == Press::Pressed;
}

/// The stick without its dead zone: 0 at its edge, length 1 at most.
glm::dvec2 beyond_dead_zone(const glm::dvec2& stick) {
  const double length = glm::length(stick);
  if (length <= kDeadZone) return {};
  return stick / length * std::min((length - kDeadZone) / (1 - kDeadZone), 1.0);
}

/// Level, relative to the heading of `rotation`: x is right, y is ahead.
glm::dvec3 level(const glm::dquat& rotation, const glm::dvec2& way) {
  return rotation_exp({0, heading_rad(rotation), 0}) * glm::dvec3(way.x, 0, -way.y);
}

/// The time since the last frame. A delayed frame does not move the viewer far.
Duration step_of(ControllerState& state, Time display_time) {
  const Duration since = display_time - state.last_frame.value_or(display_time);
  state.last_frame = display_time;
  return std::clamp(since, Duration::zero(), kLongestStep);
}

/// Turns the tracked space around the head, which stays where it is.
void turn(Rigid<Stage, Tracked>& stage_from_tracked, const Point<Tracked>& head, double angle_rad) {
  const glm::dvec3 centre = stage_from_tracked(head).v;
  const glm::dquat turned = rotation_exp({0, angle_rad, 0});
  stage_from_tracked = {glm::normalize(turned * stage_from_tracked.rotation),
                        centre + turned * (stage_from_tracked.translation - centre)};
}

/// The direction in which the viewer walks, length 0..1.
glm::dvec3 walk_of(const Hands& hands, const ControllerState& state,
                   const Rigid<Stage, Tracked>& stage_from_tracked, const Rigid<Tracked, Head>& head) {
  glm::dvec3 walk = level((stage_from_tracked * head).rotation, beyond_dead_zone(hands.walk));
  for (std::size_t side = 0; side < hands.hand.size(); ++side) {
    const HandInput& hand = hands.hand[side];
    const Grip& grip = state.grips[side];
    if (!hand.ahead || !hand.tracked_from_hand || grip.press != Press::Pressed || grip.light) continue;
    walk += level((stage_from_tracked * *hand.tracked_from_hand).rotation, {0, 1});
  }
  return walk / std::max(1.0, glm::length(walk));
}

/// The light that the hand points at, if there is one.
std::optional<std::uint32_t> light_at(const LightSet& set, const Rigid<Stage, Hand>& stage_from_hand) {
  std::optional<std::uint32_t> nearest;
  double smallest_rad = kWidestGrab_rad;
  const Rigid<Hand, Stage> hand_from_stage = inverse(stage_from_hand);
  for (std::uint32_t i = 0; i < set.lights.size(); ++i) {
    const Light& light = set.lights[i];
    if (light.kind == LightKind::Directional || !light.on) continue;
    const glm::dvec3 at = hand_from_stage(light.position).v;
    const double off_rad = glm::length(at) < kTouch_m ? 0 : std::atan2(std::hypot(at.x, at.y), -at.z);
    if (off_rad > smallest_rad || (nearest && off_rad == smallest_rad)) continue;
    nearest = i;
    smallest_rad = off_rad;
  }
  return nearest;
}

/// The hand takes the light that it points at, from whoever holds it.
void take_light(ControllerState& state, std::size_t side, Controls& controls, const LightSet& lights,
                const Rigid<Stage, Hand>& stage_from_hand) {
  const std::optional<std::uint32_t> light = light_at(lights, stage_from_hand);
  if (!light) return;
  for (Grip& other : state.grips)
    if (other.light && other.light->light == *light) other.light.reset();
  if (controls.grab && controls.grab->light == *light) controls.grab.reset();
  controls.light = *light;
  state.grips[side].light = hold(*light, lights.lights[*light], stage_from_hand);
}

/// Grabs, releases and moves the lights of both hands.
void carry_lights(const Hands& hands, const Rigid<Stage, Tracked>& stage_from_tracked, ControllerState& state,
                  Controls& controls, const LightSet& lights) {
  for (std::size_t side = 0; side < hands.hand.size(); ++side) {
    Grip& grip = state.grips[side];
    const HandInput& hand = hands.hand[side];
    const bool grabs = is_new_press(grip.press, hand.grab, kGrabThreshold);
    if (grip.press != Press::Pressed) grip.light.reset();
    if (!hand.tracked_from_hand) continue;
    const Rigid<Stage, Hand> stage_from_hand = stage_from_tracked * *hand.tracked_from_hand;
    if (grabs) take_light(state, side, controls, lights, stage_from_hand);
    if (grip.light)
      move_light(controls.settings.lights, grip.light->light, pose_of(*grip.light, stage_from_hand));
  }
}

}  // namespace

Rigid<Stage, Tracked> follow_hands(const ViewerInput& viewer, ControllerState& state, Controls& controls,
                                   const LightSet& lights) {
  Rigid<Stage, Tracked> stage_from_tracked = viewer.stage_from_tracked;
  const Duration step = step_of(state, viewer.display_time);
  if (!viewer.hands) {
    state = {};
    state.last_frame = viewer.display_time;
    return stage_from_tracked;
  }
  const Hands hands = usable(*viewer.hands);
  const Rigid<Tracked, Head>& head = viewer.tracked_from_head;
  if (is_new_press(state.turn, std::abs(hands.turn), kTurnThreshold))
    turn(stage_from_tracked, {head.translation}, std::copysign(kSnapTurn_rad, -hands.turn));
  stage_from_tracked.translation +=
      kWalkingSpeed_m_per_s * seconds_of(step) * walk_of(hands, state, stage_from_tracked, head);
  carry_lights(hands, stage_from_tracked, state, controls, lights);
  const Rigid<Stage, Head> stage_from_head = stage_from_tracked * head;
  if (is_new_press(state.next_overlay, hands.next_overlay ? 1 : 0, kGrabThreshold))
    execute(Command::NextOverlay, controls, {lights, stage_from_head});
  return stage_from_tracked;
}

}  // namespace farshade
