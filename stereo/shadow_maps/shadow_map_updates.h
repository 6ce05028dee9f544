/// Shadow map updates: what a frame must draw so that the shadow maps equal maps drawn from nothing. A layer
/// changes if its light has moved, or if an instance has moved that was or is in its view. While the light
/// stands still, the depth of the instances that cannot move is kept in a second image. Then the texels that
/// moving instances have left are copied from there, and all moving instances are drawn over them. The
/// greatest depth wins, so the order of drawing changes nothing. Pure; no device needed.
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <vector>

#include "stereo/math/spaces.h"
#include "stereo/shadow_maps/shadow_map_settings.h"

namespace farshade {

/// Texels of a layer, without the row and the column of `high`.
struct TexelRect {
  glm::ivec2 low{0}, high{0};
  [[nodiscard]] bool empty() const { return low.x >= high.x || low.y >= high.y; }
  friend bool operator==(const TexelRect&, const TexelRect&) = default;
};

/// The smallest rectangle that contains both.
[[nodiscard]] TexelRect joined(const TexelRect& a, const TexelRect& b);

/// The texels that a mesh inside of `box` can cover, and one texel around them. All texels if the box reaches
/// behind the view.
[[nodiscard]] TexelRect covered_texels(const glm::mat4& clip_from_box, const Bounds& box,
                                       std::uint32_t side_px);

/// An instance that casts shadows.
struct Caster {
  glm::dvec3 center{0.0};  ///< object space
  bool moves = false;      ///< false: its place is always the same
};

/// Where a caster is in a frame.
struct CasterPlace {
  Affine<Stage, Object> stage_from_object;
  Bounds box;               ///< of its mesh, relative to the caster's center
  std::uint64_t shape = 0;  ///< changes whenever the mesh is deformed
};

struct LayerUpdate {
  enum class Kind : std::uint8_t {
    Nothing,
    Redraw,   ///< clear the layer and draw all instances
    Restore,  ///< copy `lost` from the kept depth and draw the moving instances
  };
  Kind kind = Kind::Nothing;
  bool keeps = false;  ///< before Restore: clear the kept depth and draw the fixed instances into it
  TexelRect lost;
  friend bool operator==(const LayerUpdate&, const LayerUpdate&) = default;
};

class ShadowMapUpdates {
 public:
  /// `can_keep`: for each layer, whether it has memory for kept depth.
  ShadowMapUpdates(std::vector<Caster> casters, std::vector<bool> can_keep,
                   const ShadowMapSettings& settings);

  /// The updates of the next frame, one for each layer; the caller must carry them out. `layer_clip` is
  /// clip_from_stage of each layer, and clip_from_stage({}) for a layer that no shader reads in this frame.
  /// `places` has one for each caster.
  [[nodiscard]] std::vector<LayerUpdate> next(std::span<const glm::dmat4> layer_clip,
                                              std::span<const CasterPlace> places);

 private:
  struct Layer {
    bool can_keep = false;
    std::optional<glm::dmat4> drawn, kept;  ///< clip_from_stage of the contents; empty: no contents
    bool changed = false;                   ///< since drawn: an instance has moved in its view
    TexelRect lost;                         ///< since drawn: where moving instances were
  };
  void follow(std::span<const CasterPlace> places);
  void note_move(const Caster& caster, const CasterPlace& before, const CasterPlace& now);
  [[nodiscard]] bool sees_moving(const glm::dmat4& clip) const;
  [[nodiscard]] LayerUpdate update(Layer& layer, const glm::dmat4& clip) const;

  std::vector<Caster> casters_;
  std::vector<Layer> layers_;
  ShadowMapSettings settings_;
  std::vector<CasterPlace> placed_;  ///< in the last frame; empty before the first
};

}  // namespace farshade
