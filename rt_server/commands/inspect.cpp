#include <spdlog/fmt/fmt.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "rt_server/commands/commands.h"
#include "stereo/base/printable.h"
#include "stereo/exposure/chosen_exposure.h"
#include "stereo/gltf/gltf.h"
#include "stereo/net/explain.h"
#include "stereo/options/lighting_options.h"
#include "stereo/plan/scene_plan.h"
#include "stereo/scene/viewpoint.h"
#include "stereo/tracer/tracer_memory.h"

namespace farshade {
namespace {

using nlohmann::ordered_json;

// Outside of these sizes, the unit is probably not the metre that glTF asks for.
constexpr double kLikelyLeast_m = 0.05, kLikelyMost_m = 500;

ordered_json list(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

std::string unit_warning(double longest_m) {
  if (longest_m > kLikelyMost_m)
    return fmt::format(
        "the scene is {:.4g} m long: if it was made in millimetres or centimetres, export it in metres",
        longest_m);
  if (longest_m < kLikelyLeast_m)
    return fmt::format("the scene is {:.3g} mm long: a head moves far beyond it; export it in metres",
                       longest_m * 1e3);
  return {};
}

std::string_view name_of(LightKind kind) {
  return kind == LightKind::Point ? "point" : kind == LightKind::Spot ? "spot" : "directional";
}

/// Everything that is told, in the order of the text.
ordered_json facts_of(const Scene& file, const Lighting& lighting, const LitScene& lit) {
  const Scene& scene = lit.scene;
  const auto [planned, plan] = plan_scene(scene, {.cube_mask = false});
  const glm::dvec3 size = scene.bounds.high - scene.bounds.low;
  std::uint64_t texture_pixels = 0;
  for (const Texture& texture : scene.textures) texture_pixels += texture.image.size.pixels();
  ordered_json lights = ordered_json::array();
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const LightSource& light = scene.lights[i];
    const bool casts = plan.lights[i] == LightStatus::Casts;
    lights.push_back({{"name", light.name},
                      {"kind", name_of(light.kind)},
                      {"intensity", list(glm::dvec3(light.intensity))},
                      {"casts", casts},
                      {"moves", scene.nodes[light.node].moving}});
  }
  const Rigid<Stage, Eye> viewpoint = viewpoint_of(scene);
  ordered_json notes = lit.notes;
  const Exposure exposure = lighting.exposure ? Exposure{} : chosen_exposure(scene);
  if (const std::string words = in_words(exposure, scene.name); !words.empty()) notes.push_back(words);
  if (const std::string warning = unit_warning(std::max({size.x, size.y, size.z})); !warning.empty())
    notes.push_back(warning);
  return {{"file", scene.name},
          {"triangles", scene.triangle_count},
          {"meshes", scene.meshes.size()},
          {"instances", scene.instances.size()},
          {"moving_instances", std::ranges::count(plan.trace.moves, true)},
          {"materials", scene.materials.size()},
          {"textures", scene.textures.size()},
          {"texture_pixels", texture_pixels},
          {"low_m", list(scene.bounds.low)},
          {"high_m", list(scene.bounds.high)},
          {"size_m", list(size)},
          {"camera", file.camera ? "of the file" : "chosen"},
          {"camera_m", list(viewpoint.translation)},
          {"scenes", scene.contents.scenes},
          {"scene", scene.contents.scene},
          {"cameras", scene.contents.cameras},
          {"variants", scene.contents.variants},
          {"animations", scene.contents.animations},
          {"lights", lights},
          {"lights_of_the_file", file.lights.size()},
          {"ambient", scene.ambient},
          {"animation_s", scene.animation_length_s},
          {"tracer_bytes", estimated_memory(planned, plan.trace).total()},
          {"hash", short_form(scene.hash)},
          {"notes", notes}};
}

std::string point_words(const ordered_json& v) {
  return fmt::format("({:.4g} {:.4g} {:.4g})", v[0].get<double>(), v[1].get<double>(), v[2].get<double>());
}

/// "  scenes     0 'day', 1 'night' (shown: 0)" and the like, for a file that offers a choice.
std::string offers_in_words(const ordered_json& facts) {
  std::string text;
  for (const std::string_view kind : {"scenes", "cameras", "variants", "animations"}) {
    const ordered_json& names = facts[kind];
    if (names.size() < (kind == "scenes" || kind == "cameras" ? 2u : 1u)) continue;
    text += fmt::format("  {:<10}", kind);
    for (std::size_t i = 0; i < names.size(); ++i)
      text += fmt::format("{} {} '{}'", i ? "," : "", i, printable(names[i].get<std::string>()));
    text += kind == "scenes" ? fmt::format("; scene {} is shown (--scene-index)\n", facts["scene"].get<int>())
                             : fmt::format(" (--{})\n", kind.substr(0, kind.size() - 1));
  }
  return text;
}

std::string in_words(const ordered_json& facts) {
  const auto number = [&](const char* name) { return facts[name].get<std::uint64_t>(); };
  const ordered_json& size = facts["size_m"];
  std::string text = fmt::format(
      "{}: {} triangles in {} instances of {} meshes\n"
      "  size       {:.4g} x {:.4g} x {:.4g} m, from {} to {}\n"
      "  materials  {}, {} textures with {:.1f} million pixels\n"
      "  camera     {}, at {}\n",
      facts["file"].get<std::string>(), number("triangles"), number("instances"), number("meshes"),
      size[0].get<double>(), size[1].get<double>(), size[2].get<double>(), point_words(facts["low_m"]),
      point_words(facts["high_m"]), number("materials"), number("textures"),
      static_cast<double>(number("texture_pixels")) * 1e-6, facts["camera"].get<std::string>(),
      point_words(facts["camera_m"]));
  text += offers_in_words(facts);
  for (const ordered_json& light : facts["lights"])
    text += fmt::format("  light      {} '{}', intensity {}{}{}\n", light["kind"].get<std::string>(),
                        printable(light["name"].get<std::string>()), point_words(light["intensity"]),
                        light["casts"].get<bool>() ? "" : ", reaches nothing",
                        light["moves"].get<bool>() ? ", moves" : "");
  text += number("moving_instances") == 0 && facts["animation_s"].get<double>() == 0
              ? "  animation  none\n"
              : fmt::format("  animation  {:.4g} s, {} instances move\n", facts["animation_s"].get<double>(),
                            number("moving_instances"));
  text += fmt::format("  memory     about {:.1f} MB in the tracer\n",
                      static_cast<double>(number("tracer_bytes")) * 1e-6);
  for (const ordered_json& note : facts["notes"]) text += "  note       " + note.get<std::string>() + "\n";
  return text;
}

}  // namespace

void add_inspect(CLI::App& program, InspectOptions& options) {
  CLI::App* command =
      program.add_subcommand("inspect",
                             "Says what a scene file has, what is left out or chosen, and why a file "
                             "is refused. Exit status 1 if it is.");
  command->add_option("file", options.file, "glTF 2.0 file (.gltf or .glb)")->required();
  command->add_flag("--json", options.json, "print everything as JSON");
  add_lighting_options(*command, options.lighting);
}

Expected<std::string> inspect(const InspectOptions& options) {
  const Expected<Scene> scene = load_scene(options.file, {}, options.lighting.choice);
  if (!scene) return tl::unexpected(scene.error());
  const Expected<LitScene> lit = light_scene(*scene, options.lighting);
  if (!lit) return tl::unexpected(lit.error());
  const ordered_json facts = facts_of(*scene, options.lighting, *lit);
  return options.json ? facts.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n"
                      : in_words(facts);
}

}  // namespace farshade
