/// Lighting: what makes a scene visible that its file leaves dark, and what a user adds. The command lines of
/// both programs name the same lighting. It becomes part of the scene and of its hash, so a client whose
/// lighting differs from the server's is refused like one with another scene (docs/scenes.md).
#pragma once

#include <string>
#include <vector>

#include "stereo/scene/scene.h"
#include "stereo/scene/scene_choice.h"

namespace farshade {

/// A light of the command line. Its source's node is not used.
struct AddedLight {
  LightSource source;
  Point<Stage> position;                ///< point and spot
  Vector<Stage> direction{{0, -1, 0}};  ///< unit, in which the light travels; spot and directional
};

struct Lighting {
  SceneChoice choice{};              ///< which of the file's scenes is lit
  std::vector<AddedLight> lights{};  ///< in addition to those of the file
  std::optional<float> ambient{};    ///< linear factor of the base colour everywhere; none: chosen
  std::optional<float> exposure{};   ///< factor of all light; none: an Exposure is chosen (stereo/exposure)
};

/// In lux, of a sun without a stated strength.
inline constexpr float kSun_lux = 2.2f;

/// A sun. Degrees; azimuth 0 is -z and 90 is +x; elevation is above the horizon.
[[nodiscard]] AddedLight sun_light(double azimuth_deg, double elevation_deg, float lux);

struct LitScene {
  Scene scene;
  std::vector<std::string>
      notes;  ///< one sentence for each thing that was chosen, and for each warning of the file
};

/// Adds the lights, ambient light, exposure and, without a camera, the viewpoint (viewpoint.h) to a scene as
/// loaded from its file, and hashes it again if anything changed.
///
/// A scene without any light gets a sun, a lamp beside its viewpoint (viewpoint.h) and a little ambient
/// light. OutOfRange if there are more lights than a mask has bits.
[[nodiscard]] Expected<LitScene> light_scene(Scene scene, const Lighting& lighting);

}  // namespace farshade
