/// Goldens: committed pictures of both eyes, and the judgement of a picture against its own. README.md says
/// how they are renewed.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "stereo/frame/view.h"
#include "tests/golden/comparison.h"

namespace farshade {

/// `images/lavapipe_embree_SCENE_WHAT_EYE.png`; throws where one cannot be read.
[[nodiscard]] PerEye<Image<Rgb8>> goldens(const std::string& scene, const std::string& what);

[[nodiscard]] testing::AssertionResult agrees_with(const Image<Rgb8>& picture, const Image<Rgb8>& golden);

/// Both eyes agree with their goldens, which are written anew first where the environment has
/// FARSHADE_UPDATE_GOLDENS.
void expect_golden(const std::string& scene, const std::string& what, const PerEye<Image<Rgb8>>& pictures);

/// Neither eye's picture passes for its golden.
void expect_refused(const PerEye<Image<Rgb8>>& pictures, const PerEye<Image<Rgb8>>& golden);

}  // namespace farshade
