#include "vr_client/draw/frame_data.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace farshade {

gpu::WindowData window_data(const View& view) {
  const EyeWindow w = window_of(view.fov);
  return {{w.left, w.up, (w.right - w.left) / view.size.width, (w.down - w.up) / view.size.height}};
}

gpu::EyeData eye_data(const View& view) {
  const auto width = static_cast<float>(view.size.width), height = static_cast<float>(view.size.height);
  return {window_data(view),
          glm::mat4(glm::mat4_cast(view.stage_from_eye.rotation)),
          {width, height, 1 / width, 1 / height}};
}

gpu::MaskData mask_data(const StereoView& shown, const StereoView& traced) {
  gpu::MaskData data{};
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const Rigid<Eye, Eye> traced_from_shown = inverse(traced[eye].stage_from_eye) * shown[eye].stage_from_eye;
    data.traced_from_shown[eye] = glm::mat4(matrix(traced_from_shown));
    data.window[eye] = window_data(traced[eye]);
  }
  return data;
}

gpu::InstanceData instance_data(const StereoView& shown, const Affine<Stage, Object>& stage_from_object) {
  gpu::InstanceData data{};
  for (std::size_t eye = 0; eye < kEyes; ++eye) {
    const Affine<Eye, Object> eye_from_object = inverse(shown[eye].stage_from_eye) * stage_from_object;
    data.clip_from_object[eye] = glm::mat4(clip_from_eye(window_of(shown[eye].fov)) * eye_from_object.matrix);
  }
  const glm::dmat3 linear(stage_from_object.matrix);
  data.stage_from_object_normal = glm::mat4(glm::mat3(glm::transpose(glm::inverse(linear))));
  return data;
}

gpu::LightData light_data(const StereoView& shown, const Light& light) {
  gpu::LightData data{};
  for (std::size_t eye = 0; eye < kEyes; ++eye)
    data.position[eye] = light.kind == LightKind::Directional
                             ? glm::vec4(-light.direction.v, 0.0)
                             : glm::vec4(light.position.v - shown[eye].stage_from_eye.translation, 1.0);
  data.intensity = {light.intensity, light.range_m > 0 ? 1 / (light.range_m * light.range_m) : 0.0f};
  data.spot_direction = glm::vec4(light.direction.v, 0.0);
  data.spot_cone = {0, 1, 0, 0};
  if (light.kind == LightKind::Spot) {
    const float inner = std::cos(light.inner_cone_rad), outer = std::cos(light.outer_cone_rad);
    const float scale = 1 / std::max(0.001f, inner - outer);
    data.spot_cone = {scale, -outer * scale, 0, 0};
  }
  return data;
}

bool may_be_seen(const gpu::InstanceData& instance, std::size_t eye, const glm::vec3& low,
                 const glm::vec3& high) {
  std::array<int, 5> outside{};  // corners beyond left, right, top, bottom, behind
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec4 p =
        instance.clip_from_object[eye] * glm::vec4(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                                                   corner & 4 ? high.z : low.z, 1.0f);
    outside[0] += p.x < -p.w;
    outside[1] += p.x > p.w;
    outside[2] += p.y < -p.w;
    outside[3] += p.y > p.w;
    outside[4] += p.w < 0;
  }
  return std::none_of(outside.begin(), outside.end(), [](int corners) { return corners == 8; });
}

}  // namespace farshade
