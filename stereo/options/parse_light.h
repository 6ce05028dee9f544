/// Lights of the command line: the values of --light and --sun.
#pragma once

#include <string_view>

#include "stereo/scene/lighting.h"

namespace farshade {

/// Parses the value of --light: a kind (point, spot or directional), then words NAME=VALUE in any order.
/// Vectors are written X:Y:Z. For example "point,at=0:2:1,candela=40,range=10,color=1:0.9:0.8" or
/// "spot,at=0:3:0,to=0:0:0,cone=30,candela=100" or "directional,along=0.3:-1:0,lux=3". Malformed or
/// OutOfRange otherwise.
[[nodiscard]] Expected<AddedLight> parse_light(std::string_view text);

/// Parses the value of --sun: AZIMUTH,ELEVATION[,LUX]. Degrees; azimuth 0 is -z and 90 is +x; elevation is
/// above the horizon.
[[nodiscard]] Expected<AddedLight> parse_sun(std::string_view text);

}  // namespace farshade
