#include "stereo/head/axes.h"

#include <algorithm>

namespace farshade {
namespace {

/// The directions of x, y and z: right, left, up, down, front, back.
struct Convention {
  std::string_view name, world, body;
  double units_a_metre = 1.0;
};
constexpr Convention kConventions[] = {{"openxr", "RUB", "RUB"},  {"ros", "FLU", "FLU"},
                                       {"optical", "RDF", "RDF"}, {"euroc-imu", "FLU", "URF"},
                                       {"unity", "RUF", "RUF"},   {"unreal", "FRU", "FRU", 100.0},
                                       {"ned", "FRD", "FRD"}};

glm::dvec3 in_stage(char direction) {
  switch (direction) {
    case 'R':
      return {1, 0, 0};
    case 'L':
      return {-1, 0, 0};
    case 'U':
      return {0, 1, 0};
    case 'D':
      return {0, -1, 0};
    case 'B':
      return {0, 0, 1};
    default:
      return {0, 0, -1};
  }
}

glm::dmat3 stage_from(std::string_view directions) {
  return {in_stage(directions[0]), in_stage(directions[1]), in_stage(directions[2])};
}

const Convention* convention(std::string_view name) {
  const auto* const found = std::ranges::find(kConventions, name, &Convention::name);
  return found == std::end(kConventions) ? nullptr : found;
}

}  // namespace

Expected<Axes> parse_axes(std::string_view text) {
  const std::size_t slash = text.find('/');
  const Convention* const world = convention(text.substr(0, slash));
  const Convention* const body = slash == text.npos ? world : convention(text.substr(slash + 1));
  if (!world || !body) {
    std::string known;
    for (const Convention& each : kConventions) known.append(known.empty() ? "" : ", ").append(each.name);
    return fail(Fault::Unsupported, "unknown axes '" + std::string(text.substr(0, 40)) + "': known are " +
                                        known + ", and WORLD/HEAD with two of them");
  }
  Axes axes{.name = std::string(text),
            .stage_from_world = stage_from(world->world),
            .head_from_body = stage_from(body->body),
            .units_a_metre = world->units_a_metre};
  if (glm::determinant(axes.stage_from_world) * glm::determinant(axes.head_from_body) < 0)
    return fail(Fault::Unsupported,
                "axes '" + axes.name + "': one convention is left-handed, the other right-handed");
  return axes;
}

Rigid<Recorded, Head> in_stage(const Axes& axes, const Rigid<Recorded, Head>& pose) {
  if (axes.stage_from_world == glm::dmat3(1.0) && axes.head_from_body == glm::dmat3(1.0)) return pose;
  const glm::dmat3 rotation =
      axes.stage_from_world * glm::mat3_cast(pose.rotation) * glm::transpose(axes.head_from_body);
  return {glm::normalize(glm::quat_cast(rotation)), axes.stage_from_world * pose.translation};
}

}  // namespace farshade
