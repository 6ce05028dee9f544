/// The options of both programs and their doctors that choose a scene of the file and light it.
#pragma once

#include <CLI/CLI.hpp>

#include "stereo/options/parse_light.h"
#include "stereo/options/within.h"
#include "stereo/scene/lighting.h"

namespace farshade {

inline void add_choice_options(CLI::App& app, SceneChoice& choice) {
  app.add_option("--scene-index", choice.scene,
                 "which scene of a file with several, from 0 on (default: the file's default scene)");
  app.add_option("--camera", choice.camera,
                 "the camera of the file that is the reference camera, by its name or that of its node");
  app.add_option("--variant", choice.variant, "the variant of the file's materials (KHR_materials_variants)");
  app.add_option(
      "--animation", choice.animation,
      "the animation of the file that plays, by its name; or all at once, or none (default: the first)");
}

/// `lighting` must outlive the parsing.
inline void add_lighting_options(CLI::App& app, Lighting& lighting) {
  add_choice_options(app, lighting.choice);
  const auto add = [&lighting](const char* option, Expected<AddedLight> light) {
    if (!light) throw CLI::ValidationError(option, light.error().what);
    lighting.lights.push_back(std::move(*light));
  };
  app.add_option_function<std::vector<std::string>>(
         "--light",
         [add](const std::vector<std::string>& texts) {
           for (const std::string& text : texts) add("--light", parse_light(text));
         },
         "add a light, such as point,at=0:2:1,candela=40 or spot,at=0:3:0,to=0:0:0,cone=30,candela=100 or "
         "directional,along=0.3:-1:0,lux=3; may be given several times. Client and server need the same "
         "lights")
      ->allow_extra_args(false);
  app.add_option_function<std::vector<std::string>>(
         "--sun",
         [add](const std::vector<std::string>& texts) {
           for (const std::string& text : texts) add("--sun", parse_sun(text));
         },
         "add a sun: AZIMUTH,ELEVATION in degrees and perhaps LUX, such as 145,50,3; azimuth 0 is -z, 90 is "
         "+x")
      ->allow_extra_args(false);
  app.add_option(
         "--ambient", lighting.ambient,
         "light that reaches everything, as a part of the base colour (default: 0 if the scene has lights)")
      ->check(within(0, 1e6));
  app.add_option(
         "--exposure", lighting.exposure,
         "multiply all light by this factor (default: 1, unless the scene would be too dark or too bright)")
      ->check(within(1e-12, 1e12));
}

}  // namespace farshade
