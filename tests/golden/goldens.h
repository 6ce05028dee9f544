/// Goldens: committed pictures of both eyes that tests compare their pictures with. README.md says how to
/// regenerate them.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "stereo/frame/view.h"
#include "tests/golden/comparison.h"

namespace farshade {

/// `images/lavapipe_embree_SCENE_WHAT_EYE.png`. Throws if one cannot be read.
[[nodiscard]] PerEye<Image<Rgb8>> goldens(const std::string& scene, const std::string& what);

[[nodiscard]] testing::AssertionResult agrees_with(const Image<Rgb8>& picture, const Image<Rgb8>& golden);

/// Expects that both eyes agree with their goldens. Writes the goldens first if the environment variable
/// FARSHADE_UPDATE_GOLDENS is set.
void expect_golden(const std::string& scene, const std::string& what, const PerEye<Image<Rgb8>>& pictures);

/// Expects that neither eye's picture agrees with its golden.
void expect_refused(const PerEye<Image<Rgb8>>& pictures, const PerEye<Image<Rgb8>>& golden);

}  // namespace farshade
