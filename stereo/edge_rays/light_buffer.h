/// LightBuffer: for one light, the triangles that may lie between it and any point, by direction (E. Haines,
/// D. Greenberg, "The light buffer: a shadow-testing accelerator", IEEE CG&A 6(9), 1986). Directions are the
/// texels of a shadow map's projection. A texel lists every triangle that its pyramid meets (J. Story,
/// "Hybrid ray-traced shadows", GDC 2015), the one nearest to the light first, but none that lies behind a
/// triangle that covers the whole texel. A texel with a long list is divided into kParts x kParts smaller
/// ones, and so on. Pure; no device needed.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "shaders/edge_rays_data.h"
#include "stereo/edge_rays/caster_triangles.h"
#include "stereo/shadow_maps/shadow_map_views.h"

namespace farshade {

/// First the texels, by layer, row and column. A texel is a word: 0 for an empty list; FARSHADE_DIVIDED plus
/// the index of its first part; or the index of its list. A list is a word for each triangle: its number in
/// the lowest bits; above them how far from the light it begins, in steps, so that a ray to a nearer point
/// can stop there; and FARSHADE_LAST in the last one. Indices count from the first word of the buffer.
using LightBuffer = std::vector<std::uint32_t>;

/// How the words of a list say where triangles begin.
struct ListDepths {
  std::uint32_t number_bits = 0;  ///< of a triangle's number
  double first_m = 0;             ///< the depth of step 0
  double step_m = 0;              ///< along the axis of the layer; 0: numbers leave no bits for depths
};
[[nodiscard]] ListDepths list_depths(const MapView& view, const CasterTriangles& casters);

/// `view` is the projection of a light that shines, with FARSHADE_LIGHT_BUFFER_SIDE texels a side. Uses all
/// cores, on threads with the priority of the calling one. Gives up, with nothing, once the buffer or the
/// lists that a layer is made from have more than `most_words`, or `stop` is requested.
[[nodiscard]] std::optional<LightBuffer> make_light_buffer(const MapView& view,
                                                           const CasterTriangles& casters,
                                                           std::size_t most_words,
                                                           const std::stop_token& stop = {});

/// Whether a shader can read `buffer` as that of such a light: every index is in range, and every list
/// ends.
[[nodiscard]] bool is_light_buffer(std::span<const std::uint32_t> buffer, const MapView& view,
                                   const CasterTriangles& casters);

}  // namespace farshade
