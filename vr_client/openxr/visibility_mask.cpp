#include "vr_client/openxr/visibility_mask.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace farshade::openxr {
namespace {

Expected<void> get_mask(const Instance& instance, XrSession session, std::uint32_t view,
                        XrVisibilityMaskKHR& mask) {
  const XrResult result =
      call<PFN_xrGetVisibilityMaskKHR>(instance.handle(), "xrGetVisibilityMaskKHR", session, kViews, view,
                                       XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR, &mask);
  return succeeded(result, "xrGetVisibilityMaskKHR");
}

Expected<HiddenArea> read_hidden_of(const Instance& instance, XrSession session, std::uint32_t view) {
  XrVisibilityMaskKHR mask{XR_TYPE_VISIBILITY_MASK_KHR, nullptr, 0, 0, nullptr, 0, 0, nullptr};
  if (auto done = get_mask(instance, session, view, mask); !done) return tl::unexpected(done.error());
  if (mask.vertexCountOutput > kMostMaskVertices || mask.indexCountOutput > kMostMaskIndices)
    return fail(Fault::Unsupported, fmt::format("it has {} vertices and {} indices", mask.vertexCountOutput,
                                                mask.indexCountOutput));
  if (mask.vertexCountOutput == 0 || mask.indexCountOutput == 0) return HiddenArea{};
  std::vector<XrVector2f> vertices(mask.vertexCountOutput);
  std::vector<std::uint32_t> indices(mask.indexCountOutput);
  mask = {XR_TYPE_VISIBILITY_MASK_KHR, nullptr, mask.vertexCountOutput, 0, vertices.data(),
          mask.indexCountOutput,       0,       indices.data()};
  if (auto done = get_mask(instance, session, view, mask); !done) return tl::unexpected(done.error());
  vertices.resize(std::min<std::size_t>(vertices.size(), mask.vertexCountOutput));
  indices.resize(std::min<std::size_t>(indices.size(), mask.indexCountOutput));
  return hidden_area_of(vertices, indices);
}

/// A triangle without an area, with which some meshes are filled up.
bool is_flat(std::span<const glm::vec2, 3> triangle) {
  const glm::dvec2 a(triangle[1] - triangle[0]), b(triangle[2] - triangle[0]);
  return a.x * b.y == a.y * b.x;
}

}  // namespace

Expected<HiddenArea> hidden_area_of(std::span<const XrVector2f> vertices,
                                    std::span<const std::uint32_t> indices) {
  const auto in_view = [](const XrVector2f& at) {  // false for NaN
    return std::abs(at.x) <= kMostMaskTangent && std::abs(at.y) <= kMostMaskTangent;
  };
  if (vertices.size() > kMostMaskVertices || indices.size() > kMostMaskIndices)
    return fail(Fault::Unsupported,
                fmt::format("it has {} vertices and {} indices", vertices.size(), indices.size()));
  if (indices.size() % 3 != 0)
    return fail(Fault::Unsupported, fmt::format("{} indices are no triangles", indices.size()));
  if (!std::ranges::all_of(vertices, in_view))
    return fail(Fault::Unsupported, "a vertex is not finite, or beyond any view");
  HiddenArea area;
  area.corners.reserve(indices.size());
  for (const std::uint32_t index : indices) {
    if (index >= vertices.size())
      return fail(Fault::Unsupported, fmt::format("index {} of {} vertices", index, vertices.size()));
    area.corners.emplace_back(vertices[index].x, vertices[index].y);
    if (area.corners.size() % 3 == 0 && is_flat(std::span(area.corners).last<3>()))
      area.corners.resize(area.corners.size() - 3);
  }
  return area;
}

PerEye<HiddenArea> read_hidden(const Instance& instance, XrSession session) {
  PerEye<HiddenArea> hidden;
  if (!instance.extensions().visibility_mask) return hidden;
  for (std::uint32_t eye = 0; eye < kEyes; ++eye)
    if (Expected<HiddenArea> area = read_hidden_of(instance, session, eye))
      hidden[eye] = std::move(*area);
    else
      spdlog::warn(
          "the runtime's visibility mask of the {} eye is not used, and all its pixels are drawn: {}",
          name_of(kSides[eye]), area.error().what);
  spdlog::info("the lenses hide {} and {} triangles of the views", hidden[0].corners.size() / 3,
               hidden[1].corners.size() / 3);
  return hidden;
}

}  // namespace farshade::openxr
