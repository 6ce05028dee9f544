#include <fmt/format.h>

#include <algorithm>

#include "stereo/plan/scene_plan.h"

namespace farshade {
namespace {

/// For example "1.2 MB"; 1 MB is 10^6 bytes.
std::string megabytes(std::uint64_t bytes) {
  return fmt::format("{:.3g} MB", static_cast<double>(bytes) * 1e-6);
}

std::string line(std::string_view what, const std::string& words) {
  return fmt::format("  {:<12} {}\n", what, words);
}

/// How many meshes use a vertex stream, and the bytes that the other meshes save without it.
struct Stream {
  std::size_t used = 0;
  std::uint64_t spared_bytes = 0;
};

Stream stream_of(const ScenePlan& plan, const Scene& scene, bool SurfaceNeeds::*need,
                 std::uint64_t vertex_bytes) {
  Stream stream;
  for (std::size_t i = 0; i < scene.meshes.size(); ++i)
    if (plan.draw.surfaces[i].*need)
      ++stream.used;
    else
      stream.spared_bytes += scene.meshes[i].positions.size() * vertex_bytes;
  return stream;
}

std::string of_meshes(const Stream& stream, const Scene& scene, std::string_view read) {
  const std::size_t all = scene.meshes.size();
  if (stream.used == 0) return fmt::format("off: no mesh {}; saves {}", read, megabytes(stream.spared_bytes));
  if (stream.used == all) return fmt::format("on: all {} meshes", all);
  return fmt::format("on for {} of {} meshes; the others save {}", stream.used, all,
                     megabytes(stream.spared_bytes));
}

std::string_view why(LightStatus status) {
  return status == LightStatus::Dark ? "it has no intensity" : "it ends before the scene begins";
}

std::string light_words(const ScenePlan& plan) {
  const MaskLayout mask = plan.trace.mask;
  const std::uint32_t bytes = mask.planes() * mask.word_bytes();
  std::string text =
      line("masks", fmt::format("{} of {} lights cast shadows: {} byte{} a pixel and eye", mask.lights,
                                plan.lights.size(), bytes, bytes == 1 ? "" : "s"));
  for (std::size_t i = 0; i < plan.lights.size(); ++i)
    if (plan.lights[i] != LightStatus::Casts)
      text += line("", fmt::format("light {} left out: {}", i, why(plan.lights[i])));
  return text;
}

std::string surface_words(const ScenePlan& plan, const Scene& scene) {
  const auto count = [&](bool SurfaceNeeds::*need) {
    return static_cast<std::size_t>(std::ranges::count(plan.trace.surfaces, true, need));
  };
  const std::size_t holes = count(&SurfaceNeeds::alpha_test), backs = count(&SurfaceNeeds::back_test);
  return line("textures", of_meshes(stream_of(plan, scene, &SurfaceNeeds::texture, sizeof(glm::vec2)), scene,
                                    "has one: no texture coordinates, no bindings")) +
         line("vertex colour",
              of_meshes(stream_of(plan, scene, &SurfaceNeeds::vertex_color, sizeof(glm::u8vec4)), scene,
                        "has another colour than white")) +
         line("holes", holes == 0 ? "off: no alpha test in shaders, no alpha filter on rays"
                                  : fmt::format("on for {} of {} meshes", holes, scene.meshes.size())) +
         line("back faces", backs == 0 ? "off: every surface is double-sided, no filter on primary rays"
                                       : fmt::format("on for {} of {} meshes", backs, scene.meshes.size()));
}

std::string motion_words(const ScenePlan& plan) {
  const auto moving = std::ranges::count(plan.trace.moves, true);
  if (!plan.draw.anything_moves())
    return line(
        "motion",
        "off: one acceleration structure of the best quality, never refitted; no motion in reprojection");
  return line("motion",
              fmt::format("on for {} of {} instances{}: each frame places them again, and reprojection "
                          "follows their motion",
                          moving, plan.trace.moves.size(), plan.draw.lights_move ? " and for lights" : ""));
}

std::string light_use_words(const ScenePlan& plan) {
  return line("falloff", plan.draw.ranges_and_cones ? "on: some light has a range or a cone"
                                                    : "off: no light has a range or a cone") +
         line("rays", plan.trace.skips_rays ? "only where a light can matter"
                                            : "one for each covered pixel and light");
}

std::string detail_words(const ScenePlan& plan) {
  return line("detail", plan.draw.detail_px > 0
                            ? fmt::format("levels of each mesh with an error of at most {:g} pixels",
                                          plan.draw.detail_px)
                            : "off: every triangle is drawn");
}

std::string session_words(const ScenePlan& plan) {
  return line("other eye", plan.draw.other_eye ? "on: its masks are looked up"
                                               : "off: there is one view, or masks fit the shown views") +
         line("depth pass", plan.draw.depth_pass ? "on where the requested views differ from the shown ones"
                                                 : "off: masks fit the shown views") +
         line("cube mask", plan.draw.cube_mask ? "on: coarse masks of all directions about the head"
                                               : "off: this mode requests none") +
         line("shading", plan.draw.passes == ShadingPasses::Sorted
                             ? "sorted passes: easy pixels, then lists of the others; on a GPU a single pass"
                             : "a single pass over all pixels") +
         line("requests",
              plan.draw.anything_moves()
                  ? "in each frame: something moves"
                  : "every 28 ms if masks come later than that: nothing moves, so they age slowly") +
         line("server", plan.server ? "on: some light casts shadows" : "off: no light casts shadows");
}

}  // namespace

std::string in_words(const ScenePlan& plan, const Scene& scene) {
  return fmt::format("plan for {}: {}\n", scene.name,
                     plan.kind == PlanKind::Everything ? "everything is on" : "what it needs") +
         light_words(plan) + surface_words(plan, scene) + motion_words(plan) + light_use_words(plan) +
         detail_words(plan) + session_words(plan);
}

}  // namespace farshade
