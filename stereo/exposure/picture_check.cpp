#include "stereo/exposure/picture_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/gtx/component_wise.hpp>
#include <map>
#include <numbers>

#include "stereo/base/quantile.h"
#include "stereo/exposure/arriving_light.h"
#include "stereo/scene/sky.h"

namespace farshade {
namespace {

constexpr std::size_t kLeastPoints = 16;
/// Linear: an 8-bit sRGB value below this is 0.
constexpr float kBlack = 0.5f / 255 / 12.92f;
/// Of no use if nothing is brighter: 13 of 255.
constexpr float kDark = 0.004f;
constexpr double kMostClipped = 0.5;
/// A cure must leave at most this share black or clipped.
constexpr double kCured = 0.5;
constexpr float kUsual = 0.4f, kBright = 0.9f, kTriedAmbient = 0.1f;
constexpr std::size_t kMostNames = 3;

float linear(std::uint8_t value) {
  const float v = static_cast<float>(value) / 255;
  return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}

/// The mean base colour, from at most some hundred texels and vertices.
glm::vec3 mean_color(const Scene& scene, const Mesh& mesh) {
  constexpr std::size_t kMost = 256;
  const auto mean = [](const auto& list, auto color_of) {
    if (list.empty()) return glm::vec3(1.0f);
    const std::size_t step = std::max<std::size_t>(list.size() / kMost, 1);
    glm::vec3 sum(0.0f);
    float count = 0;
    for (std::size_t i = step / 2; i < list.size(); i += step, ++count) sum += color_of(list[i]);
    return sum / std::max(count, 1.0f);
  };
  const Material& material = scene.materials[mesh.material];
  glm::vec3 color(material.base_color);
  if (material.texture && !mesh.uvs.empty())
    color *= mean(scene.textures[*material.texture].image.pixels, [](const Rgba8& pixel) {
      return glm::vec3(linear(pixel.r), linear(pixel.g), linear(pixel.b));
    });
  return color * mean(mesh.colors, [](const glm::u8vec4& c) { return glm::vec3(c) / 255.0f; });
}

/// Two digits, so that what is tried is what is printed.
float rounded(double value) {
  return std::strtof(fmt::format("{:.1e}", value).c_str(), nullptr);
}

std::string percent(double share) {
  return fmt::format("{:.0f} %", share * 100);
}

/// The points of the pictures, and how bright they are under other light.
class PictureTrial {
 public:
  PictureTrial(const ArrivingLight& light, const Scene& scene) {
    std::map<std::uint32_t, glm::vec3> known;
    for (std::size_t i = 0; i < light.points().size(); ++i) {
      const std::uint32_t mesh = scene.instances[light.points()[i].instance].mesh;
      if (!known.contains(mesh)) known[mesh] = mean_color(scene, scene.meshes[mesh]);
      colors_.push_back(known[mesh]);
      light_.push_back(light.irradiance(i) / std::numbers::pi_v<float>);
    }
  }

  /// The brightest channel of each point, with all lights times `lights`.
  [[nodiscard]] std::vector<double> brightness(float lights, float ambient) const {
    std::vector<double> result;
    for (std::size_t i = 0; i < colors_.size(); ++i) {
      const float value = glm::compMax(colors_[i] * (light_[i] * lights + ambient));
      result.push_back(value < kMostIrradiance ? value : kMostIrradiance);  // also for NaN
    }
    return result;
  }
  [[nodiscard]] double black(float lights, float ambient) const {
    return share(brightness(lights, ambient), [](double value) { return value < kBlack; });
  }
  [[nodiscard]] double dark(float lights, float ambient) const {
    return share(brightness(lights, ambient), [](double value) { return value < kDark; });
  }
  [[nodiscard]] double clipped(float lights, float ambient) const {
    return share(brightness(lights, ambient), [](double value) { return value >= 1; });
  }

 private:
  static double share(const std::vector<double>& values, bool (*holds)(double)) {
    return static_cast<double>(std::ranges::count_if(values, holds)) / static_cast<double>(values.size());
  }

  std::vector<glm::vec3> colors_, light_;
};

/// What the user's options make of the light of the file: --exposure multiplies it, and ambient light.
struct GivenLight {
  float exposure = 1;  ///< of the user
  float ambient = 0;   ///< without it

  explicit GivenLight(const Scene& scene, const Lighting& lighting)
      : exposure(lighting.exposure.value_or(1.0f)), ambient(scene.ambient / exposure) {}
};

PictureFinding dark_finding(const PictureTrial& trial, const Scene& scene, const Lighting& lighting,
                            const Exposure& exposure) {
  const bool all_black = trial.black(exposure.factor(), scene.ambient) == 1;
  const std::string what =
      fmt::format("everything that the head sees is {}black", all_black ? "" : "almost ");
  const GivenLight given(scene, lighting);
  std::vector<double> lit = trial.brightness(1 / given.exposure, 0);
  std::erase_if(lit, [](double value) { return !(value > 0); });
  if (!lit.empty()) {
    const float wanted = rounded(kUsual / quantile(std::move(lit), 0.5));
    const double dark = trial.dark(wanted / given.exposure, given.ambient * wanted);
    if (std::isfinite(wanted) && dark <= kCured)
      return {true, fmt::format("{}; the cure is --exposure {:g} on both sides: then {} of it is", what,
                                wanted, percent(dark))};
  }
  const double dark = trial.dark(exposure.factor(), kTriedAmbient);
  if (dark <= kCured)
    return {true, fmt::format("{}, because {} light arrives there; the cure is --ambient {:g} on both sides: "
                              "then {} of it is",
                              what, all_black ? "no" : "little", kTriedAmbient, percent(dark))};
  return {true, fmt::format("{}, and stays so in any light: its materials have {} colour", what,
                            all_black ? "no" : "hardly any")};
}

PictureFinding clipped_finding(const PictureTrial& trial, const Scene& scene, const Lighting& lighting,
                               const Exposure& exposure) {
  const GivenLight given(scene, lighting);
  const std::string what = fmt::format("{} of what the head sees is as bright as can be",
                                       percent(trial.clipped(exposure.factor(), scene.ambient)));
  const double bright = quantile(trial.brightness(1 / given.exposure, given.ambient), kBright);
  const float wanted = rounded(kBright / bright);
  const double left = trial.clipped(wanted / given.exposure, given.ambient * wanted);
  if (std::isfinite(wanted) && wanted > 0 && left <= kCured)
    return {true, fmt::format("{}; the cure is --exposure {:g} on both sides: then {} of it is", what, wanted,
                              percent(left))};
  return {true, what + ", and no factor of the light helps"};
}

/// A light that reaches nothing that is seen.
struct Unseen {
  std::size_t light = 0;
  std::size_t facing = 0;  ///< points that it would reach
  /// An instance whose material blocks at least nine in ten of them.
  std::optional<std::uint32_t> blocker{};
};

std::uint32_t material_of(const Scene& scene, std::uint32_t instance) {
  return scene.meshes[scene.instances[instance].mesh].material;
}

std::vector<Unseen> unseen_lights(const ArrivingLight& light, const Scene& scene) {
  std::vector<Unseen> unseen;
  for (std::size_t l = 0; l < light.lights(); ++l) {
    Unseen one{.light = l};
    struct Blocks {
      std::size_t count = 0;
      std::uint32_t instance = 0;
    };
    std::map<std::uint32_t, Blocks> blocked;  // by material
    bool reaches = false;
    for (std::size_t i = 0; i < light.points().size() && !reaches; ++i) {
      const Arrival& arrival = light.at(i)[l];
      if (arrival.irradiance == glm::vec3(0.0f)) continue;
      reaches = !arrival.blocker;
      ++one.facing;
      if (!arrival.blocker) continue;
      Blocks& blocks = blocked[material_of(scene, *arrival.blocker)];
      blocks = {blocks.count + 1, *arrival.blocker};
    }
    if (reaches) continue;
    for (const auto& [material, blocks] : blocked)
      if (10 * blocks.count >= 9 * one.facing) one.blocker = blocks.instance;
    unseen.push_back(one);
  }
  return unseen;
}

std::string name_of_light(const Scene& scene, std::size_t light) {
  const LightSource& source = scene.lights[light];
  const std::string& node = scene.nodes[source.node].name;
  return source.name.empty() && node.empty() ? fmt::format("number {}", light)
                                             : "'" + (source.name.empty() ? node : source.name) + "'";
}

std::string name_of_thing(const Scene& scene, std::uint32_t instance) {
  const std::string& mesh = scene.meshes[scene.instances[instance].mesh].name;
  const std::string& node = scene.nodes[scene.instances[instance].node].name;
  return node.empty() && mesh.empty() ? fmt::format("mesh {}", scene.instances[instance].mesh)
                                      : "'" + (node.empty() ? mesh : node) + "'";
}

/// Things of one material stand before every point, and would be a sky if its material were unlit: what would
/// the light reach then?
std::optional<PictureFinding> shell_finding(const ArrivingLight& light, const Scene& scene,
                                            const Unseen& unseen) {
  if (!unseen.blocker) return std::nullopt;
  const std::vector<std::uint32_t> shell = would_be_sky(scene, material_of(scene, *unseen.blocker));
  if (shell.empty()) return std::nullopt;
  const auto without = Surroundings::create(scene, {.without = shell});
  if (!without) return std::nullopt;
  Scene alone;  // only the light
  alone.nodes = scene.nodes;
  alone.lights = {scene.lights[unseen.light]};
  const ArrivingLight again(*without, alone, {light.points().begin(), light.points().end()});
  std::size_t reached = 0;
  for (std::size_t i = 0; i < again.points().size(); ++i) reached += again.irradiance(i) != glm::vec3(0.0f);
  if (reached == 0) return std::nullopt;
  const std::string thing = name_of_thing(scene, *unseen.blocker);
  return PictureFinding{
      false, fmt::format("the light {} reaches nothing that the head sees, because {} blocks it; if that is "
                         "a sky around the scene, the cure is KHR_materials_unlit in its material: then the "
                         "light reaches {}",
                         name_of_light(scene, unseen.light), thing,
                         percent(static_cast<double>(reached) / static_cast<double>(again.points().size())))};
}

/// `dark`: another sentence says that nothing is lit.
std::vector<PictureFinding> unseen_findings(const ArrivingLight& light, const Scene& scene, bool dark) {
  std::vector<PictureFinding> findings;
  std::vector<std::string> others;
  for (const Unseen& unseen : unseen_lights(light, scene)) {
    if (findings.empty())
      if (auto shell = shell_finding(light, scene, unseen)) {
        findings.push_back(*std::move(shell));
        continue;
      }
    others.push_back(name_of_light(scene, unseen.light));
  }
  if (others.empty() || dark) return findings;
  const std::size_t count = others.size();
  others.resize(std::min(count, kMostNames));
  findings.push_back(
      {false,
       fmt::format("{} of {} lights reach nothing that the head sees ({}{}): without them, the picture "
                   "is the same",
                   count, light.lights(), fmt::join(others, ", "), count > kMostNames ? ", ..." : "")});
  return findings;
}

}  // namespace

std::vector<PictureFinding> check_picture(const Surroundings& surroundings, const Scene& scene,
                                          const Lighting& lighting, const Exposure& exposure,
                                          std::span<const Ray> rays) {
  const ArrivingLight light(surroundings, scene, seen_points(surroundings, rays));
  if (light.points().size() < kLeastPoints || scene.lights.empty()) return {};
  const PictureTrial trial(light, scene);
  std::vector<PictureFinding> findings;
  const bool dark = trial.dark(exposure.factor(), scene.ambient) == 1;
  if (dark)
    findings.push_back(dark_finding(trial, scene, lighting, exposure));
  else if (trial.clipped(exposure.factor(), scene.ambient) > kMostClipped)
    findings.push_back(clipped_finding(trial, scene, lighting, exposure));
  for (PictureFinding& one : unseen_findings(light, scene, dark)) findings.push_back(std::move(one));
  return findings;
}

}  // namespace farshade
