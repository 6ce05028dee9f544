#include "stereo/raster/frame_data.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace farshade {

namespace {

/// An exposure makes no intensity infinite, which would become NaN in shadow.
constexpr float kMostIntensity = 1e30f;

/// Origin and step of the window's pixels.
glm::dvec4 exact_window(const View& view) {
  const FovTangents w = tangents_of(view.fov);
  return {w.left_tan, w.up_tan, (w.right_tan - w.left_tan) / view.size.width,
          (w.down_tan - w.up_tan) / view.size.height};
}

}  // namespace

gpu::WindowData window_data(const View& view) {
  return {glm::vec4(exact_window(view))};
}

gpu::EyeData eye_data(const View& view) {
  const auto width = static_cast<float>(view.size.width), height = static_cast<float>(view.size.height);
  return {window_data(view),
          glm::mat4(glm::mat4_cast(view.stage_from_eye.rotation)),
          {width, height, 1 / width, 1 / height}};
}

gpu::SourceData source_data(const PoseDelta& delta, const View& traced) {
  gpu::SourceData data{};
  data.traced_from_shown = glm::mat4(matrix(delta.traced_from_shown));
  const glm::dvec4 window = exact_window(traced);
  data.origin_step = window;
  data.per_step = {1 / window.z, 1 / window.w, traced.size.width, traced.size.height};
  return data;
}

glm::ivec2 grid_offset_px(const View& shown, const View& traced) {
  const glm::dvec4 a = exact_window(shown), b = exact_window(traced);
  return {std::lround((a.x - b.x) / b.z), std::lround((a.y - b.y) / b.w)};
}

glm::vec4 pixel_map(const View& shown, const View& traced) {
  const glm::dvec4 a = exact_window(shown), b = exact_window(traced);
  return {a.z / b.z, a.w / b.w, (a.x - b.x) / b.z, (a.y - b.y) / b.w};
}

bool shares_pixels(const View& shown, const View& traced) {
  constexpr double kTolerance_px = 1e-3;
  if (shown.stage_from_eye != traced.stage_from_eye) return false;
  const glm::dvec4 a = exact_window(shown), b = exact_window(traced);
  const glm::ivec2 offset = grid_offset_px(shown, traced);
  const auto on_grid = [&](int axis, std::uint32_t size) {
    const double first = (a[axis] - b[axis]) / b[axis + 2] - offset[axis],
                 last = (a[axis + 2] / b[axis + 2] - 1) * size;
    return std::abs(first) < kTolerance_px && std::abs(first + last) < kTolerance_px;
  };
  return on_grid(0, shown.size.width) && on_grid(1, shown.size.height);
}

gpu::InstanceData instance_data(const StereoView& shown, const Affine<Stage, Object>& stage_from_object) {
  gpu::InstanceData data{};
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const Affine<Eye, Object> eye_from_object = inverse(shown[eye].stage_from_eye) * stage_from_object;
    data.clip_from_object[eye] =
        glm::mat4(clip_from_eye(tangents_of(shown[eye].fov)) * eye_from_object.matrix);
  }
  const glm::dmat3 linear(stage_from_object.matrix);
  data.stage_from_object_normal = glm::mat4(glm::mat3(glm::transpose(glm::inverse(linear))));
  return data;
}

gpu::LightData light_data(const StereoView& shown, const Light& light, const Exposure& exposure) {
  gpu::LightData data{};
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    data.position[eye] = light.kind == LightKind::Directional
                             ? glm::vec4(-light.direction.v, 0.0)
                             : glm::vec4(light.position.v - shown[eye].stage_from_eye.translation, 1.0);
  data.intensity = {
      light.on ? glm::min(light.intensity * exposure.factor(), kMostIntensity) : glm::vec3(0.0f),
      light.range_m > 0 ? 1 / (light.range_m * light.range_m) : 0.0f};
  data.spot_direction = glm::vec4(light.direction.v, 0.0);
  data.spot_cone = {0, 1, 0, 0};
  if (light.kind == LightKind::Spot) {
    const float inner = std::cos(light.inner_cone_rad), outer = std::cos(light.outer_cone_rad);
    const float scale = 1 / std::max(0.001f, inner - outer);
    data.spot_cone = {scale, -outer * scale, 0, 0};
  }
  return data;
}

bool may_be_seen(const gpu::InstanceData& instance, std::size_t eye, const Bounds& box) {
  std::array<int, 5> outside{};  // corners beyond left, right, top, bottom, behind
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec4 p = instance.clip_from_object[eye] * glm::vec4(glm::vec3(box.corner(corner)), 1.0f);
    outside[0] += p.x < -p.w;
    outside[1] += p.x > p.w;
    outside[2] += p.y < -p.w;
    outside[3] += p.y > p.w;
    outside[4] += p.w < 0;
  }
  return std::none_of(outside.begin(), outside.end(), [](int corners) { return corners == 8; });
}

}  // namespace farshade
