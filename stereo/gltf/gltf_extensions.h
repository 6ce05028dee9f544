/// Which extensions the loader can do without, and which it knows.
#pragma once

#include <string>
#include <vector>

#include "stereo/base/expected.h"

namespace farshade::gltf {

/// Unsupported, naming the first extension of `required` without which the scene would be wrong.
[[nodiscard]] Expected<void> check_extensions(const std::vector<std::string>& required);

/// A warning for each extension of `used` that changes the look and is not drawn.
[[nodiscard]] std::vector<std::string> warnings_of_extensions(const std::vector<std::string>& used);

}  // namespace farshade::gltf
