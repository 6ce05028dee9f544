/// Mode: how the work is split between client and server, and the settings of each mode. docs/modes.md.
#pragma once

#include <array>
#include <string_view>

#include "stereo/frame/answer_spec.h"
#include "stereo/plan/plan_masks.h"
#include "stereo/plan/scene_plan.h"
#include "stereo/shadow_maps/shadow_map_settings.h"

namespace farshade {

enum class Mode : std::uint8_t {
  Hybrid,           ///< the client rasterises, reprojects the server's masks and shades
  ClientPositions,  ///< the same with masks of positions that the client sends
  ServerGBuffer,    ///< the client shades the server's G-buffer and masks
  Remote,           ///< the client shows the server's video
  Delta,            ///< the client draws without shadows and adds the server's difference
  Local,            ///< the client alone, with shadow maps
  Full,             ///< the client alone traces every pixel: the reference
};

struct ModeName {
  Mode mode;
  std::string_view name;
  AnswerSet answers;  ///< that a server must offer; empty if the mode needs no server
};
inline constexpr std::array<ModeName, 7> kModes{
    {{Mode::Hybrid, "hybrid", set_of(Answer::Masks)},
     {Mode::ClientPositions, "client-positions", set_of(Answer::MasksOfPositions)},
     {Mode::ServerGBuffer, "server-gbuffer", set_of(Answer::GBuffer)},
     {Mode::Remote, "remote", set_of(Answer::Video)},
     {Mode::Delta, "delta", set_of(Answer::Difference)},
     {Mode::Local, "local", 0},
     {Mode::Full, "full", 0}}};

[[nodiscard]] constexpr std::string_view name_of(Mode mode) {
  return kModes[static_cast<std::size_t>(mode)].name;
}

[[nodiscard]] constexpr AnswerSet answers_for(Mode mode) {
  return kModes[static_cast<std::size_t>(mode)].answers;
}

/// The mode reprojects masks from the views they were traced for.
[[nodiscard]] constexpr bool reprojects_masks(Mode mode) {
  return mode == Mode::Hybrid || mode == Mode::ClientPositions;
}

/// Requested views may be wider than the shown ones.
[[nodiscard]] constexpr bool has_guard_band(Mode mode) {
  return reprojects_masks(mode) || mode == Mode::Remote || mode == Mode::Delta;
}

/// A capture holds masks, not pictures or G-buffers.
[[nodiscard]] constexpr bool can_be_captured(Mode mode) {
  return mode == Mode::Hybrid || mode == Mode::Full;
}

/// The client draws the scene itself. In the other modes it draws nothing but references.
[[nodiscard]] constexpr bool draws_scene(Mode mode) {
  return mode != Mode::Remote && mode != Mode::ServerGBuffer;
}

/// The limit of the geometric error of what a mode draws, unless the user sets it; 0: full detail. Mode full
/// shows the reference, which is drawn in full detail.
[[nodiscard]] constexpr float default_detail_px(Mode mode) {
  return draws_scene(mode) && mode != Mode::Full ? kDefaultDetail_px : 0;
}

/// How the server codes the masks of mode hybrid (docs/partial-requests.md).
enum class MaskCode : std::uint8_t {
  Range,  ///< slices that each decode alone, of what the client asks for
  Lz4,    ///< one LZ4 block of both eyes' whole views, as published systems have it
};

struct ModeSettings {
  Mode mode = Mode::Hybrid;
  MaskCode mask_code = MaskCode::Range;        ///< Hybrid
  std::uint32_t bits_per_second = 20'000'000;  ///< Remote, Delta
  std::uint32_t position_bits = 14;            ///< ClientPositions: bits for each axis of the scene
  ShadowMapSettings shadow_maps{};             ///< Local
  friend bool operator==(const ModeSettings&, const ModeSettings&) = default;
};

}  // namespace farshade
