#include "stereo/shadow_maps/shadow_map_updates.h"

#include <algorithm>
#include <cmath>

#include "stereo/base/check.h"
#include "stereo/raster/frame_data.h"
#include "stereo/shadow_maps/shadow_map_views.h"

namespace farshade {
namespace {

/// As ScenePass places a mesh, so that both find the same meshes in a view.
glm::mat4 clip_from_box(const glm::dmat4& clip_from_stage, const Caster& caster, const CasterPlace& place) {
  Affine<Stage, Object> stage_from_object = place.stage_from_object;
  stage_from_object.matrix[3] = glm::dvec4(stage_from_object(Point<Object>{caster.center}).v, 1.0);
  return glm::mat4(clip_from_stage * stage_from_object.matrix);
}

bool in_view(const glm::mat4& clip_from_box, const Bounds& box) {
  gpu::InstanceData data{};
  data.clip_from_object[0] = clip_from_box;
  return may_be_seen(data, 0, box);
}

TexelRect all_texels(std::uint32_t side_px) {
  return {glm::ivec2(0), glm::ivec2(static_cast<int>(side_px))};
}

}  // namespace

TexelRect joined(const TexelRect& a, const TexelRect& b) {
  if (a.empty() || b.empty()) return a.empty() ? b : a;
  return {glm::min(a.low, b.low), glm::max(a.high, b.high)};
}

TexelRect covered_texels(const glm::mat4& clip_from_box, const Bounds& box, std::uint32_t side_px) {
  const glm::vec2 side(static_cast<float>(side_px));
  glm::vec2 low = side, high(0.0f);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec4 p = clip_from_box * glm::vec4(glm::vec3(box.corner(corner)), 1.0f);
    if (p.w <= 0) return all_texels(side_px);
    const glm::vec2 at = (glm::vec2(p) / p.w * 0.5f + 0.5f) * side;
    low = glm::min(low, at), high = glm::max(high, at);
  }
  const glm::vec2 first = glm::clamp(glm::floor(low) - 1.0f, glm::vec2(0.0f), side),
                  end = glm::clamp(glm::ceil(high) + 1.0f, glm::vec2(0.0f), side);
  return {glm::ivec2(first), glm::ivec2(end)};
}

ShadowMapUpdates::ShadowMapUpdates(std::vector<Caster> casters, std::vector<bool> can_keep,
                                   const ShadowMapSettings& settings)
    : casters_(std::move(casters)), layers_(can_keep.size()), settings_(settings) {
  for (std::size_t i = 0; i < layers_.size(); ++i) layers_[i].can_keep = can_keep[i];
}

std::vector<LayerUpdate> ShadowMapUpdates::next(std::span<const glm::dmat4> layer_clip,
                                                std::span<const CasterPlace> places) {
  check_eq(layer_clip.size(), layers_.size(), "views for each layer");
  check_eq(places.size(), casters_.size(), "a place for each caster");
  follow(places);
  std::vector<LayerUpdate> updates;
  for (std::size_t i = 0; i < layers_.size(); ++i) updates.push_back(update(layers_[i], layer_clip[i]));
  return updates;
}

/// Notes what has moved since the last frame.
void ShadowMapUpdates::follow(std::span<const CasterPlace> places) {
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const bool stands =
        placed_[i].stage_from_object == places[i].stage_from_object && placed_[i].shape == places[i].shape;
    if (casters_[i].moves && !stands) note_move(casters_[i], placed_[i], places[i]);
  }
  placed_.assign(places.begin(), places.end());
}

void ShadowMapUpdates::note_move(const Caster& caster, const CasterPlace& before, const CasterPlace& now) {
  for (Layer& layer : layers_) {
    if (!layer.drawn) continue;
    const glm::mat4 clip_before = clip_from_box(*layer.drawn, caster, before);
    const bool was_seen = in_view(clip_before, before.box);
    if (was_seen) layer.lost = joined(layer.lost, covered_texels(clip_before, before.box, settings_.side_px));
    layer.changed |= was_seen || in_view(clip_from_box(*layer.drawn, caster, now), now.box);
  }
}

bool ShadowMapUpdates::sees_moving(const glm::dmat4& clip) const {
  for (std::size_t i = 0; i < casters_.size(); ++i)
    if (casters_[i].moves && in_view(clip_from_box(clip, casters_[i], placed_[i]), placed_[i].box))
      return true;
  return false;
}

LayerUpdate ShadowMapUpdates::update(Layer& layer, const glm::dmat4& clip) const {
  if (clip == clip_from_stage({})) return {};
  const bool stands = layer.drawn == clip;
  if (settings_.redraw == Redraw::WhenMoved && stands && !layer.changed) return {};
  LayerUpdate result;
  result.kind = LayerUpdate::Kind::Redraw;
  // While a light moves, kept depth would be of no use in the next frame.
  if (layer.can_keep && (stands || (!layer.drawn && sees_moving(clip)))) {
    result = {.kind = LayerUpdate::Kind::Restore,
              .keeps = layer.kept != clip,
              .lost = stands ? layer.lost : all_texels(settings_.side_px)};
    layer.kept = clip;
  }
  layer.drawn = clip;
  layer.changed = false;
  layer.lost = {};
  return result;
}

}  // namespace farshade
